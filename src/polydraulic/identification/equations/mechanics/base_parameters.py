"""Base parameters: the combinations of inertial numbers that a motion can tell, found by QR with pivoting.

A column of the regressor that others make up adds nothing of its own: its number only shifts theirs. What is left is as many
combinations as the regressor has rank (Gautier, J. Robotic Systems 8 (1991) 485).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import qr, solve_triangular

from polydraulic.identification.equations.mechanics.inertia import Inertial, inertial_numbers, torque_regressor
from polydraulic.parameters.layout.schema import LayoutMachine

_ROWS, _WIDEST = 200, 3.0  # random motions that show what any motion can tell; rad or m where no stop is nearer
_RANK = 1e-9
_SHOWN = 1e-6


class BaseParameters(NamedTuple):
    """Combinations of inertial numbers.

    Attributes
    ----------
    numbers : list of Inertial
    combine : (n_base, n_number) array
        Base parameters are this times the numbers.
    texts : list of str
        Such as ``boom h.x + 4.9 stick mass``, in m, kg and their products.
    """

    numbers: list[Inertial]
    combine: np.ndarray
    texts: list[str]


def base_parameters(machine: LayoutMachine) -> BaseParameters:
    """What any motion of a machine between its stops can tell of its inertia."""
    numbers, rng = inertial_numbers(machine), np.random.default_rng(0)
    n = len(machine.functions)
    low = np.array([max(f.stops.low, -_WIDEST) for f in machine.functions])
    high = np.array([min(f.stops.high, _WIDEST) for f in machine.functions])
    position = rng.uniform(low, high, (_ROWS, n))
    rate, acceleration = rng.normal(size=(2, _ROWS, n))
    regressor = torque_regressor(machine, numbers, position, rate, acceleration, machine.gravity)
    return combined(numbers, regressor.reshape(-1, len(numbers)))


def combined(numbers: Sequence[Inertial], regressor: np.ndarray) -> BaseParameters:
    """Base parameters of a regressor, (n_row, n_number).

    Columns are scaled to one length; of those that depend on each other the ones with the largest part of their own are kept.
    """
    length = np.linalg.norm(regressor, axis=0)
    scale = np.where(length > 0.0, length, 1.0)
    triangle, order = qr(regressor / scale, mode="r", pivoting=True)
    size = np.abs(np.diagonal(triangle))
    rank = int(np.sum(size > _RANK * size[0])) if len(size) else 0
    combine = np.zeros((rank, len(numbers)))
    kept, dropped = order[:rank], order[rank:]
    combine[np.arange(rank), kept] = 1.0
    depends = solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
    combine[:, dropped] = depends * scale[dropped] / scale[kept][:, None]
    in_order = np.argsort(kept)
    combine = combine[in_order]
    return BaseParameters(
        list(numbers), combine, [_text(row, numbers, k) for row, k in zip(combine, np.sort(kept), strict=True)]
    )


def _text(row: np.ndarray, numbers: Sequence[Inertial], own: int) -> str:
    text = numbers[own].text
    for k in np.flatnonzero(np.abs(row) > _SHOWN).tolist():
        if k != own:
            factor = "" if abs(abs(row[k]) - 1.0) < _SHOWN else f"{abs(row[k]):.3g} "
            text += f" {'+' if row[k] > 0.0 else '-'} {factor}{numbers[k].text}"
    return text
