"""Tipping of machines that move: margins as columns of runs, and of any state by itself."""
