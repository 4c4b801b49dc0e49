"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `batch` (many machines
at once, `lanes` inside), `continuous` (the tight judge) and `trajectory` (comparison and plots).
"""

from polydraulic.simulation.batch import Batch, simulate_batch
from polydraulic.simulation.continuous import reference
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import Difference, compare, plot_run

__all__ = ["Batch", "Difference", "compare", "plot_run", "reference", "simulate", "simulate_batch"]
