"""Kernels as readable C99 with the same bits: the one text of the physics, printed in another language.

`Program.entry` translates a kernel and all that it calls; it refuses what has no counterpart, with file and line.
"""
