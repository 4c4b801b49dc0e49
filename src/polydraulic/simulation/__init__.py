"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `batch` (many machines
at once), `solvers` (the other methods of `simulate`). Then `events` (what happened when) and `trajectory` (comparison).
"""
