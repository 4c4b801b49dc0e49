"""Equations of motion as rows that are linear in what is to be found, made of measured positions and pressures.

The equation d/dt (M qd) - dT/dq + gravity + friction = torque of the oil is multiplied by a smooth weight that moves along the log, and
integrated by parts, so that nothing is differentiated twice. Positions and torques pass one filter first: what it does to both sides is
the same wherever the equation is linear, and the noise of a rate stays small against what smooths Coulomb friction.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.inertia import Inertial, torque_regressor
from polydraulic.identification.log_pieces import even_pieces
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of, function_column
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.tables import Table

FRICTION = ("coulomb", "static", "viscous")
_FILTER = 0.045  # s, its width; its bias grows with the fourth power of it
_FAR, _ENDS = 4.0, 3.0  # widths after which the filter ends, and the weight
_NEAR_STOP = 0.02  # rad or m
_STEP = 1e-4  # s, of the difference along a motion
_TURNS = 2.0  # Stribeck rates, below which friction is not told from its smoothing


class MotionRows(NamedTuple):
    """Rows of one equation for each function, at every instant.

    Attributes
    ----------
    regressor : (n_instant, n_function, n_number + 3 n_function + 1) array
        Inertial numbers; coulomb, static and viscous friction of each function; by how many seconds pressures are late against positions.
    torque : (n_instant, n_function) array, N m or N
        Of the oil.
    known : (n_instant, n_function) array of bool
        Whether a function moves steadily there, away from its stops.
    time : (n_instant,) array, s
    """

    regressor: np.ndarray
    torque: np.ndarray
    known: np.ndarray
    time: np.ndarray


class Piece(NamedTuple):
    """Rows of a log on an even raster, without a gap: time (n,), positions, pressures at A and B (n, n_function)."""

    time: np.ndarray
    position: np.ndarray
    p_a: np.ndarray
    p_b: np.ndarray


def steady(machine: LayoutMachine, position: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Where a joint is away from its stops and moves faster than what smooths its friction, (n_row, n_function) as both."""
    friction = [f.friction for f in machine.functions]
    fast = np.abs(rate) > [max(_TURNS * own.stribeck, 3.0 * own.smoothing) for own in friction]
    return np.asarray(fast & clear_of_stops(machine, position))


def clear_of_stops(machine: LayoutMachine, position: np.ndarray) -> np.ndarray:
    """Where a joint is away from its stops, at any rate, (n_row, n_function) as the positions."""
    low, high = ([getattr(f.stops, end) for f in machine.functions] for end in ("low", "high"))
    return np.asarray((position > np.array(low) + _NEAR_STOP) & (position < np.array(high) - _NEAR_STOP))


def motion_rows(
    machine: LayoutMachine,
    numbers: Sequence[Inertial],
    pieces: Sequence[Piece],
    widths: np.ndarray,
    step: float = 0.0,
    counts: Callable[[LayoutMachine, np.ndarray, np.ndarray], np.ndarray] = steady,
) -> MotionRows:
    """Rows of all pieces that are long enough.

    Parameters
    ----------
    machine : LayoutMachine
    numbers : sequence of Inertial
    pieces : sequence of Piece
    widths : (n_function,) array, s
        Of the weight of each function's equation.
    step : float, s
        Of the simulation that the rows are to agree with. It takes friction at the rate between the position before and this one, half a step
        ago, so that an inertia acts as if it were smaller by viscous friction over half a step. None for motion without steps.
    counts : function (machine, positions, rates) -> (n_row, n_function) array of bool
        Which rows say something, `known` of what comes of them.

    Raises
    ------
    InputError
        If no piece is long enough, or has two rows.
    """
    pieces = [piece for piece in pieces if len(piece.time) > 1]
    if not pieces:
        raise InputError(
            "no two rows of the log with positions and pressures of all functions follow each other; the mechanics cannot be identified from it"
        )
    made = [
        rows
        for piece in pieces
        for rows in [_of_piece(machine, numbers, piece, widths, step, counts)]
        if rows is not None
    ]
    if not made:
        raster = min(map(raster_of_piece, pieces))
        longest = len(_modulating(float(np.max(widths)), raster)[0])
        least = (_least_rows(len(_filter(raster)[0]), longest) - 1) * raster
        raise InputError(
            f"no piece of the log lasts {least:.3g} s without a gap; the mechanics cannot be identified from it"
        )
    return MotionRows(*(np.concatenate(parts) for parts in zip(*made, strict=True)))


def _of_piece(
    machine: LayoutMachine, numbers: Sequence[Inertial], piece: Piece, widths: np.ndarray, step: float,
    counts: Callable[[LayoutMachine, np.ndarray, np.ndarray], np.ndarray],
) -> MotionRows | None:  # fmt: skip
    raster = raster_of_piece(piece)
    smooth, slope = _filter(raster)
    weights = [_modulating(width, raster) for width in widths.tolist()]
    longest = max(len(weight) for weight, _ in weights)
    if len(piece.time) < _least_rows(len(smooth), longest):
        return None
    position, rate = _passed(piece.position, smooth), _passed(piece.position, slope)
    torque = _passed(oil_torques(machine, piece.position, piece.p_a, piece.p_b), smooth)
    late = -oil_torques(machine, position, _passed(piece.p_a, slope), _passed(piece.p_b, slope))[:, :, None]
    moments = _momentum(machine, numbers, position, rate)
    before = rate - 0.5 * step * np.gradient(rate, raster, axis=0)
    others = np.concatenate([friction_regressor(machine, before), late], axis=-1)
    rest = np.concatenate([_rest(machine, numbers, position, rate), others], axis=-1)
    known, stride = counts(machine, position, rate), max(1, round(widths.min() / raster))
    of = []
    for k, (weight, weight_slope) in enumerate(weights):
        short = (longest - len(weight)) // 2  # at the same instants as the longest
        inside = slice(short, len(rate) - short)
        made = _passed(rest[inside, k], weight)
        made[:, : len(numbers)] += _passed(moments[inside, k], weight_slope)
        told = np.all(np.lib.stride_tricks.sliding_window_view(known[inside, k], len(weight)), axis=-1)
        of.append((made[::stride], _passed(torque[inside, k], weight)[::stride], told[::stride]))
    regressor, oil, told = (np.stack(parts, axis=1) for parts in zip(*of, strict=True))
    first = len(smooth) // 2 + longest // 2
    return MotionRows(regressor, oil, told, piece.time[first : len(piece.time) - first : stride])


def raster_of_piece(piece: Piece) -> float:
    """Time between rows of a piece of two at least, s."""
    return float(np.median(np.diff(piece.time)))


def _least_rows(smooth: int, weight: int) -> int:
    """Rows of a piece, so that at least as many are left as both weights reach over."""
    return 2 * (smooth + weight)


def oil_torques(machine: LayoutMachine, position: np.ndarray, p_a: np.ndarray, p_b: np.ndarray) -> np.ndarray:
    """Torques of the oil on the joints, (n_row, n_function), from positions and pressures of the same shape."""
    place, ready = columns_of(machine), prepare_layout(machine, 1e-3)
    rows, found = np.zeros((len(position), len(place.columns))), np.empty((len(position), 3 * len(machine.names)))
    for quantity, values in (("angle", position), ("p_a", p_a), ("p_b", p_b)):
        rows[:, [place.place[f"{f}.{quantity}"] for f in machine.names]] = values
    ready.module.torques(ready.plant, rows, np.zeros((len(rows), 3)), found)
    return found[:, ::3]


def _momentum(machine: LayoutMachine, numbers: Sequence[Inertial], q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """M qd for each unit of the numbers."""
    return torque_regressor(machine, numbers, q, np.zeros_like(q), qd, 0.0)


def _rest(machine: LayoutMachine, numbers: Sequence[Inertial], q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """What the torques at constant rates are beyond the change of M qd: -dT/dq and gravity."""
    ahead, behind = (_momentum(machine, numbers, q + way * qd, qd) for way in (_STEP, -_STEP))
    still = torque_regressor(machine, numbers, q, qd, np.zeros_like(q), machine.gravity)
    return still - (ahead - behind) / (2.0 * _STEP)


def friction_regressor(machine: LayoutMachine, rate: np.ndarray) -> np.ndarray:
    """Friction for each unit of coulomb, static and viscous friction of each function."""
    n = len(machine.functions)
    found = np.zeros((len(rate), n, 3 * n))
    for k, f in enumerate(machine.functions):
        w = rate[:, k]
        side, near = np.tanh(w / f.friction.smoothing), np.exp(-((w / f.friction.stribeck) ** 2))
        for place, values in enumerate((side * (1.0 - near), side * near, w)):
            found[:, k, 3 * k + place] = values
    return found


def _filter(raster: float) -> tuple[np.ndarray, np.ndarray]:
    """A smooth weight over samples, and what gives the derivative of what it smooths.

    It is of fourth order, so that cubics pass as they are: what is made of filtered positions is then what it would be of filtered torques,
    though not linear.
    """
    half = max(2, int(np.ceil(_FAR * _FILTER / raster)))
    at = np.arange(-half, half + 1) * raster
    square = (at / _FILTER) ** 2
    bell = np.exp(-0.5 * square)
    weight, slope = bell * (1.5 - 0.5 * square), at * bell * (2.5 - 0.5 * square)
    return weight / weight.sum(), slope / (slope @ at)


def _modulating(width: float, raster: float) -> tuple[np.ndarray, np.ndarray]:
    """The same with an end, at three times its standard deviation, to which it falls with two derivatives: nothing is left at the ends.

    A function that modulates (Shinbrot, Trans. ASME 79 (1957) 579).
    """
    half = max(2, int(np.ceil(_ENDS * width / raster)) - 1)
    at = np.arange(-half, half + 1) * raster
    inner = np.maximum(1.0 - (at / (_ENDS * width)) ** 2, 0.0)
    weight, slope = inner**3, at * inner**2
    return weight / weight.sum(), slope / (slope @ at)


def _passed(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted sums along the first axis, where all rows are there."""
    from scipy.signal import oaconvolve

    shape = (-1, *[1] * (values.ndim - 1))
    return np.asarray(oaconvolve(values, weight[::-1].reshape(shape), mode="valid", axes=0))


def smoothed(values: np.ndarray, raster: float) -> tuple[np.ndarray, np.ndarray]:
    """Values and their rates, filtered, at all rows of a piece, (n_row, n); beyond its ends it goes on as its mirror image about the last row."""
    smooth, slope = _filter(raster)
    reach = len(smooth) // 2
    longer = np.pad(values, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    return _passed(longer, smooth), _passed(longer, slope)


def rate_noise(raster: float, width: float | None = None) -> float:
    """Standard deviation of a filtered rate, or its mean under a weight of that width, for each unit of that of white noise of positions, 1/s."""
    slope = _filter(raster)[1]
    return float(np.linalg.norm(slope if width is None else np.convolve(slope, _modulating(width, raster)[0])))


def measured_pieces(machine: LayoutMachine, table: Table) -> list[Piece]:
    """Pieces of a log with positions and pressures of all functions."""
    names = [function_column(machine, f, "angle", "rad").name for f in machine.names]
    columns = [*names, *(f"{f}.{p}" for p in ("p_a", "p_b") for f in machine.names)]
    return [Piece(at, *np.split(values, 3, axis=1)) for at, values in even_pieces(table, columns)]
