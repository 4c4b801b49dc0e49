"""Proved ranges of outputs and slopes over boxes of inputs.

Needs NumPy and numba alone. Read `bounds` (what is asked), `taylor` (enclosures), `branch_and_bound` (how they get tight).
"""
