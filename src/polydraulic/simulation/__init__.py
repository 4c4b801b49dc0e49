"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `batch` (many machines
at once, `lanes` inside), `continuous` (the tight judge), `trajectory` (comparison), and for the eye `plot`, `shapes` (the
linkage as drawn) and `animation`.
"""

from polydraulic.simulation.animation import write_animation
from polydraulic.simulation.batch import Batch, simulate_batch
from polydraulic.simulation.continuous import reference
from polydraulic.simulation.plot import plot_run
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import Difference, compare

__all__ = [
    "Batch",
    "Difference",
    "compare",
    "plot_run",
    "reference",
    "simulate",
    "simulate_batch",
    "write_animation",
]
