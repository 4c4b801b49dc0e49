"""Machines whose layout is data: links in a tree, functions that move them, circuits that feed these."""
