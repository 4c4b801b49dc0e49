"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `continuous` (the tight judge)
and `trajectory` (comparison and plots).
"""

from polydraulic.simulation.continuous import reference
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import Difference, compare, plot_run

__all__ = ["Difference", "compare", "plot_run", "reference", "simulate"]
