"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `continuous` (the tight judge),
`trajectory` (comparison), and for the eye `plot`, `shapes` (the linkage as drawn) and `animation`.
"""

from polydraulic.simulation.animation import write_animation
from polydraulic.simulation.continuous import reference
from polydraulic.simulation.plot import plot_run
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import Difference, compare

__all__ = ["Difference", "compare", "plot_run", "reference", "simulate", "write_animation"]
