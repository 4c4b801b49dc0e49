"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `simulate` (the function to call), `reference` (the tight judge)
and `trajectory` (comparison and plots).
"""

from polydraulic.simulation.reference import reference
from polydraulic.simulation.simulate import simulate
from polydraulic.simulation.trajectory import Difference, compare, plot_run

__all__ = ["Difference", "compare", "plot_run", "reference", "simulate"]
