"""Equations of motion as rows that are linear in what is to be found, made of measured positions and pressures.

The equation d/dt (M qd) - dT/dq + gravity + friction = torque of the oil is multiplied by a smooth weight that moves along the log, and
integrated by parts, so that nothing is differentiated twice. Positions and torques pass one filter first: what it does to both sides is
the same wherever the equation is linear, and the noise of a rate stays small against what smooths Coulomb friction.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.log_pieces import even_pieces
from polydraulic.identification.equations.mechanics.inertia import Inertial, torque_regressor
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import columns_of, function_column
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.tables import Table

FRICTION = ("coulomb", "static", "viscous")
# s, widths of the filter, whose bias grows with its fourth power, and of the weight, which sets the noise
_FILTER, _WEIGHT = 0.045, 0.08
_FAR = 4.0  # widths after which they end
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


def motion_rows(machine: LayoutMachine, numbers: Sequence[Inertial], pieces: Sequence[Piece]) -> MotionRows:
    """Rows of all pieces that are long enough.

    Raises
    ------
    InputError
        If none is.
    """
    made = [rows for piece in pieces for rows in [_of_piece(machine, numbers, piece)] if rows is not None]
    if not made:
        raster = min(_raster_of(piece) for piece in pieces)
        least = (_least_rows(*(len(_gaussian(width, raster, 0.0)[0]) for width in (_FILTER, _WEIGHT))) - 1) * raster
        raise InputError(
            f"no piece of the log lasts {least:.3g} s without a gap; the mechanics cannot be identified from it"
        )
    return MotionRows(*(np.concatenate(parts) for parts in zip(*made, strict=True)))


def _of_piece(machine: LayoutMachine, numbers: Sequence[Inertial], piece: Piece) -> MotionRows | None:
    raster = _raster_of(piece)
    smooth, slope = _gaussian(_FILTER, raster, 0.5)
    weight, weight_slope = _gaussian(_WEIGHT, raster, 0.0)
    if len(piece.time) < _least_rows(len(smooth), len(weight)):
        return None
    position, rate = _passed(piece.position, smooth), _passed(piece.position, slope)
    oil = oil_torques(machine, piece.position, piece.p_a, piece.p_b)
    torque = _passed(oil, smooth)
    late = -oil_torques(machine, position, _passed(piece.p_a, slope), _passed(piece.p_b, slope))[:, :, None]
    moments = _momentum(machine, numbers, position, rate)
    rest = _rest(machine, numbers, position, rate)
    friction = _friction(machine, rate)
    stride = max(1, round(_WEIGHT / raster))
    regressor = _passed(moments, weight_slope)[::stride] + _passed(rest, weight)[::stride]
    known = _steady(machine, piece, position, rate, len(smooth) // 2)
    half = len(weight) // 2
    windows: np.ndarray = np.all(np.lib.stride_tricks.sliding_window_view(known, len(weight), axis=0), axis=-1)
    return MotionRows(
        np.concatenate([regressor, *(_passed(part, weight)[::stride] for part in (friction, late))], axis=-1),
        _passed(torque, weight)[::stride],
        windows[::stride],
        piece.time[len(smooth) // 2 + half :][: len(windows) : stride],
    )


def _raster_of(piece: Piece) -> float:
    """Time between rows, s; infinite for a single one."""
    return float(np.median(np.diff(piece.time))) if len(piece.time) > 1 else np.inf


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


def _friction(machine: LayoutMachine, rate: np.ndarray) -> np.ndarray:
    """Friction for each unit of coulomb, static and viscous friction of each function."""
    n = len(machine.functions)
    found = np.zeros((len(rate), n, 3 * n))
    for k, f in enumerate(machine.functions):
        w = rate[:, k]
        side, near = np.tanh(w / f.friction.smoothing), np.exp(-((w / f.friction.stribeck) ** 2))
        for place, values in enumerate((side * (1.0 - near), side * near, w)):
            found[:, k, 3 * k + place] = values
    return found


def _steady(machine: LayoutMachine, piece: Piece, position: np.ndarray, rate: np.ndarray, half: int) -> np.ndarray:
    """Where a joint is away from its stops and moves faster than what smooths its friction."""
    known = np.empty(rate.shape, dtype=bool)
    for k, f in enumerate(machine.functions):
        fast = np.abs(rate[:, k]) > max(_TURNS * f.friction.stribeck, 3.0 * f.friction.smoothing)
        away = (position[:, k] > f.stops.low + _NEAR_STOP) & (position[:, k] < f.stops.high - _NEAR_STOP)
        known[:, k] = fast & away
    return known


def _gaussian(width: float, raster: float, flat: float) -> tuple[np.ndarray, np.ndarray]:
    """A smooth weight over samples, and what gives the derivative of what it smooths.

    With `flat` of one half it passes cubics as they are (the kernel of fourth order): what is made of filtered positions is then what it would
    be of filtered torques, though not linear.
    """
    half = max(2, int(np.ceil(_FAR * width / raster)))
    at = np.arange(-half, half + 1) * raster
    square = (at / width) ** 2
    bell = np.exp(-0.5 * square)
    weight = bell * (1.0 + flat * (1.0 - square))
    slope = at * bell * (1.0 + flat * (3.0 - square))
    return weight / weight.sum(), slope / (slope @ at)


def _passed(values: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Weighted sums along the first axis, where all rows are there."""
    from scipy.signal import oaconvolve

    shape = (-1, *[1] * (values.ndim - 1))
    return np.asarray(oaconvolve(values, weight[::-1].reshape(shape), mode="valid", axes=0))


def measured_pieces(machine: LayoutMachine, table: Table) -> list[Piece]:
    """Pieces of a log with positions and pressures of all functions."""
    names = [function_column(machine, f, "angle", "rad").name for f in machine.names]
    columns = [*names, *(f"{f}.{p}" for p in ("p_a", "p_b") for f in machine.names)]
    return [Piece(at, *np.split(values, 3, axis=1)) for at, values in even_pieces(table, columns)]
