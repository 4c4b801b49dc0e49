"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), `batch` (many machines
at once, `lanes` inside). The other methods of `simulate`: `right_hand_side` (the equations in continuous time), `runge_kutta`,
`rosenbrock`, `tight` (the judge). Then `events` (what happened when), `trajectory` (comparison), and for the eye `plot`,
`shapes` (the linkage as drawn) and `animation`.
"""

from typing import Any

from polydraulic.parameters import Machine, Scenario
from polydraulic.simulation.animation import write_animation
from polydraulic.simulation.batch import Batch, simulate_batch
from polydraulic.simulation.plot import plot_run
from polydraulic.simulation.runs import METHODS, simulate
from polydraulic.simulation.trajectory import Difference, compare
from polydraulic.tables import Table

__all__ = [
    "METHODS",
    "Batch",
    "Difference",
    "compare",
    "plot_run",
    "reference",
    "simulate",
    "simulate_batch",
    "write_animation",
]


def reference(
    machine: Machine,
    flow: Any,
    scenario: Scenario,
    *,
    dt: float = 5e-3,
    rtol: float = 1e-9,
    t_end: float | None = None,
) -> Table:
    """`simulate` with ``method="reference"``: the tight solution.

    Parameters
    ----------
    machine, flow, scenario
        As for `simulate`.
    dt : float, s
        Raster of the result.
    rtol : float
        Relative tolerance of the solver.
    t_end : float, s, optional
        Instead of the scenario's duration.
    """
    return simulate(machine, flow, scenario, dt=dt, t_end=t_end, method="reference", rtol=rtol)
