"""What an environment reads of its machines after a step: columns of a run, machines side by side."""

from typing import NamedTuple

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import EFFECTOR, STATE, columns_of


class Motion(NamedTuple):
    """Machines as they move, a column each; rows are functions, or axes of the ground.

    Attributes
    ----------
    spool : (n_function, n) array, m
    p_a, p_b : (n_function, n) array, Pa
    position : (n_function, n) array, rad or m
    rate : (n_function, n) array, rad/s or m/s
    tip : (3, n) array, m
    """

    spool: np.ndarray
    p_a: np.ndarray
    p_b: np.ndarray
    position: np.ndarray
    rate: np.ndarray
    tip: np.ndarray


def motion_columns(machine: LayoutMachine) -> list[str]:
    """Names of the outputs that `motion_from` takes, in their order."""
    of = columns_of(machine)
    keys = [f"{f}.{quantity}" for quantity, _ in STATE for f in machine.names]
    return [of.columns[of.place[key]].name for key in keys] + list(EFFECTOR)


def motion_from(values: np.ndarray) -> Motion:
    """Rows of `motion_columns`, (5 n_function + 3, n), by their names."""
    n = (len(values) - len(EFFECTOR)) // len(STATE)
    return Motion._make([*(values[k * n : (k + 1) * n] for k in range(len(STATE))), values[len(STATE) * n :]])
