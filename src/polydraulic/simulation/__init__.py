"""Simulation: the machine in time.

Read `step` (one step, the whole algorithm), `loop` (compiled), `runs` (`simulate`, the function to call), then the other methods:
`right_hand_side` (the equations in continuous time), `runge_kutta`, `rosenbrock`, `tight` (the judge); `events`
(what happened when) and `trajectory` (comparison and plots).
"""

from typing import Any

from polydraulic.parameters import Machine, Scenario
from polydraulic.simulation.runs import METHODS, simulate
from polydraulic.simulation.trajectory import Difference, compare, plot_run
from polydraulic.tables import Table

__all__ = ["METHODS", "Difference", "compare", "plot_run", "reference", "simulate"]


def reference(machine: Machine, flow: Any, scenario: Scenario, **options: Any) -> Table:
    """`simulate` with ``method="reference"``."""
    return simulate(machine, flow, scenario, method="reference", **options)
