"""Whether dry friction holds joints that rest: torques that smoothed friction would let go by creeping.

What masses need is found with friction where joints slide, so that a file's masses need not be right; what the oil is off from that at rest is friction.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.motion_rows import (
    FRICTION,
    Piece,
    clear_of_stops,
    measured_pieces,
    motion_rows,
    raster_of_piece,
    rate_noise,
)
from polydraulic.identification.equations.mechanics.weight_widths import weight_widths
from polydraulic.identification.noise import noise_of_pieces
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

_WIDTH = 0.1  # s, of the weight under which a joint is to rest
_SLOW = 0.1  # of the rate that smooths friction, below which a joint rests: smoothed friction gives a tenth of itself
_HELD = 0.25  # of Coulomb friction, which torques at rest are beyond half of the time where it holds, and a joint that creeps does not reach
_BEYOND = 2.0  # times what the equations leave where joints slide
_FEW, _SLIDING, _MOST = 20, 200, 30000  # rows at rest and of sliding at least, and of the log at most


class Resting(NamedTuple):
    """What a joint carries at rest.

    Attributes
    ----------
    holds : bool
        Whether that is more than smoothed friction would.
    torque, coulomb : float, N m or N
        Of friction half of the time at rest, and where the joint slides.
    rows : int
        At rest.
    """

    holds: bool
    torque: float
    coulomb: float
    rows: int


def at_rest(machine: LayoutMachine, table: Table) -> dict[str, Resting]:
    """Functions of which a log with positions and pressures of all says what they carry at rest.

    Parameters
    ----------
    machine : LayoutMachine
    table : Table
        In SI.

    Raises
    ------
    InputError
        No rows of positions and pressures of all functions that follow each other, or none for long enough.
    """
    numbers, pieces = base_parameters(machine).numbers, _first(measured_pieces(machine, table))
    if not pieces:
        return {}
    n, joints = len(numbers), len(machine.functions)
    sliding = motion_rows(machine, numbers, pieces, weight_widths(machine, numbers, pieces))
    if sliding.known.sum() < _SLIDING:
        return {}
    size = np.array(
        [np.median(np.abs(sliding.torque[k, i])) if k.any() else 1.0 for i, k in enumerate(sliding.known.T)]
    )
    weight = sliding.known / np.maximum(size, 1e-300)
    told = np.linalg.lstsq(
        (sliding.regressor * weight[:, :, None]).reshape(-1, sliding.regressor.shape[-1]),
        (sliding.torque * weight).ravel(),
        rcond=1e-10,
    )[0]
    left = np.abs(sliding.torque - sliding.regressor @ told)
    still = motion_rows(
        machine,
        numbers,
        pieces,
        np.full(joints, _WIDTH),
        counts=lambda machine, position, _: clear_of_stops(machine, position),
    )
    without = told.copy()
    without[n : n + len(FRICTION) * joints] = 0.0
    friction, found = np.abs(still.torque - still.regressor @ without), dict[str, Resting]()
    raster = raster_of_piece(pieces[0])
    noise = [noise_of_pieces([piece.position[:, k] for piece in pieces]) for k in range(joints)]
    unsure = np.array(noise) * rate_noise(raster, _WIDTH)
    for k, f in enumerate(machine.functions):
        place = n + len(FRICTION) * k
        slow, coulomb = _SLOW * f.friction.smoothing, float(told[place])
        rest = still.known[:, k] & (np.abs(still.regressor[:, k, place + 2]) < slow)
        if unsure[k] > slow or rest.sum() < _FEW or not coulomb > 0.0 or sliding.known[:, k].sum() < _FEW:
            continue
        carried, unknown = float(np.median(friction[rest, k])), float(np.median(left[sliding.known[:, k], k]))
        holds = carried > max(_HELD * coulomb, _BEYOND * unknown)
        found[f.name] = Resting(holds, carried, coulomb, int(rest.sum()))
    return found


def _first(pieces: Sequence[Piece]) -> list[Piece]:
    """Pieces of so many rows, since what a joint does at rest shows soon."""
    found, left = list[Piece](), _MOST
    for piece in pieces:
        if left > 1 and len(piece.time) > 1:
            found.append(Piece(*(values[:left] for values in piece)))
            left -= len(found[-1].time)
    return found
