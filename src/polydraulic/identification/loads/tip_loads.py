"""Payload, and force at the tip, from pressures and positions of a machine whose masses and friction are known.

The torques that the known machine needs for the measured motion (Newton and Euler), less those of the oil and with friction, are what something at the
tip adds: those of a point mass, which follow its acceleration and weight, or of a force. Over a window in time the mass, or the force, is constant and is found by
least squares over all joints. Positions and torques pass the same filter, whose own slopes give rates and accelerations: what it does to both sides is the
same wherever the equation is linear.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.identification.equations.mechanics.motion_rows import Piece, measured_pieces, oil_torques
from polydraulic.identification.log_pieces import weighted_sums
from polydraulic.identification.plausible import check_functions, check_plausible, check_units
from polydraulic.machine.joint_torques import torques_of_friction, torques_of_motion
from polydraulic.machine.reach.tip import tip_jacobian
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.tables import Table
from polydraulic.watch.blocks import FAR, FILTER, motion_filters

WINDOW = 2.0  # s, over which a load is constant
_BLOCK = 0.25  # s, of which means are taken: what is left of a noisy acceleration in them is little
_CORRELATED = 2.0  # blocks that one independent block stands for
_NEAR_STOP = 0.02  # rad or m
_TRIAL = 1000.0  # kg
_LEAST_TORQUE = 1e-9
_FELT = 1e-9  # of the largest: squares of what joints feel


class PayloadEstimate(NamedTuple):
    """Payload, window by window.

    Attributes
    ----------
    time : (n_window,) array, s
        Middle of each.
    payload : (n_window,) array, kg
        nan where no joint feels it, with the error inf.
    error : (n_window,) array, kg
        Standard error: of noise, by the scatter in the window, and of friction, which at rest may hold as much as static friction.
    mean, mean_error : float, kg
        Of the whole log, windows weighted by their errors; the error of friction does not fall with their number.
    """

    time: np.ndarray
    payload: np.ndarray
    error: np.ndarray
    mean: float
    mean_error: float


class TipForceEstimate(NamedTuple):
    """Force on the tip, window by window, along the ground's axes.

    Attributes
    ----------
    time : (n_window,) array, s
    force, error : (n_window, 3) array, N
        Error as of `PayloadEstimate`; force nan and error inf along an axis along which joints feel nothing by itself.
    """

    time: np.ndarray
    force: np.ndarray
    error: np.ndarray


def estimate_payload(machine: LayoutMachine | str | Path, log: Table, *, window: float = WINDOW) -> PayloadEstimate:
    """Estimate the mass that hangs at the tip.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        Without the payload.
    log : Table
        In SI: ``time``, and of each function ``.angle`` (``.position`` where it slides), ``.p_a`` and ``.p_b``.
    window : float, s
        For how long the payload is taken as constant.

    Returns
    -------
    PayloadEstimate

    Raises
    ------
    InputError
        Columns that are missing or not in SI, a log without a piece as long as a window, or one in which no joint feels a payload.
    """
    machine = as_machine(machine)
    found = [_solved(rows, rows.of_mass[:, :, None]) for rows in _windows(machine, log, window, 0.0)]
    if not any(np.isfinite(error[0]) for _, _, error, _ in found):
        raise InputError("no joint of the machine feels a payload in this log: all are upright, or at their stops")
    time, value, error = (np.array([item[k] for item in found]) for k in (0, 1, 2))
    systematic = np.array([item[3][0] for item in found])
    weight = 1.0 / error[:, 0] ** 2
    mean = float((weight * np.nan_to_num(value[:, 0])).sum() / weight.sum())
    noise2 = np.maximum(error[:, 0] ** 2 - systematic**2, 0.0)
    spread = np.sqrt((np.where(weight > 0.0, weight**2 * noise2, 0.0)).sum()) / weight.sum()
    shared = float((weight * np.where(weight > 0.0, systematic, 0.0)).sum() / weight.sum())
    return PayloadEstimate(time, value[:, 0], error[:, 0], mean, float(np.hypot(spread, shared)))


def estimate_tip_force(
    machine: LayoutMachine | str | Path, log: Table, *, payload: float = 0.0, window: float = WINDOW
) -> TipForceEstimate:
    """Estimate the force that pushes at the tip.

    Parameters
    ----------
    machine, log, window
        As of `estimate_payload`; the force is constant over a window.
    payload : float, kg
        That is known to hang there; its weight is not part of the force.

    Returns
    -------
    TipForceEstimate

    Raises
    ------
    InputError
        As `estimate_payload`; a payload that is no mass.
    """
    machine = as_machine(machine)
    if not (np.isfinite(payload) and payload >= 0.0):
        raise InputError(f"payload = {payload} kg: must be a mass of 0 kg or more")
    found = [_solved(rows, rows.of_force) for rows in _windows(machine, log, window, payload)]
    time, value, error = (np.array([item[k] for item in found]) for k in (0, 1, 2))
    return TipForceEstimate(time, value, error)


class _Rows(NamedTuple):
    """Rows of a window: what is left of the torques, and what a kilogram and a newton add, (n_row, n_function, ...)."""

    time: float
    left: np.ndarray
    of_mass: np.ndarray
    of_force: np.ndarray
    unsure: np.ndarray  # friction, standard deviation that all rows share
    used: np.ndarray


def _windows(machine: LayoutMachine, log: Table, window: float, payload: float) -> list[_Rows]:
    check_functions(machine, log)
    check_units(log)
    pieces = measured_pieces(machine, log)
    check_plausible(machine, log)
    if not (np.isfinite(window) and window > 0.0):
        raise InputError(f"window = {window} s: must be a positive time")
    found = [rows for piece in pieces for rows in _of_piece(machine, piece, window, payload)]
    if not found:
        raise InputError(
            f"no piece of the log lasts {window + 2.0 * FAR * FILTER + _BLOCK:g} s without a gap; give a shorter window"
        )
    return found


def _of_piece(machine: LayoutMachine, piece: Piece, window: float, payload: float) -> list[_Rows]:
    raster = float(np.median(np.diff(piece.time))) if len(piece.time) > 1 else np.inf
    if len(piece.time) * raster < window + 2.0 * FAR * FILTER + _BLOCK:
        return []
    smooth, slope, curve = motion_filters(raster)
    q, qd, qdd = (weighted_sums(piece.position, weights) for weights in (smooth, slope, curve))
    oil = weighted_sums(oil_torques(machine, piece.position, piece.p_a, piece.p_b), smooth)
    time = piece.time[len(smooth) // 2 :][: len(q)]
    bare = torques_of_motion(with_payload(machine, payload), q, qd, qdd)
    more = (torques_of_motion(with_payload(machine, payload + _TRIAL), q, qd, qdd) - bare) / _TRIAL
    friction, unsure = torques_of_friction(machine, qd)
    left = oil - friction - bare
    pushed = -np.swapaxes(tip_jacobian(machine, q), -1, -2)  # torques for each newton at the tip
    stops = np.array([f.stops for f in machine.functions])
    away = (piece.position > stops[:, 0] + _NEAR_STOP) & (piece.position < stops[:, 1] - _NEAR_STOP)
    # no row that has seen a stop
    used = np.lib.stride_tricks.sliding_window_view(away, len(smooth), axis=0).all(axis=-1)
    block = max(1, round(_BLOCK / raster))
    made = [_means(values, block) for values in (time, left, more, pushed, unsure)]
    made.append(_means(used.astype(float), block) == 1.0)
    count = max(1, round(window / (block * raster)))
    starts = range(0, len(made[0]) - count + 1, count)
    return [_Rows(float(made[0][a : a + count].mean()), *(part[a : a + count] for part in made[1:])) for a in starts]


def _means(values: np.ndarray, count: int) -> np.ndarray:
    """Means of so many rows each."""
    whole = len(values) // count
    return np.asarray(values[: whole * count].reshape(whole, count, *values.shape[1:]).mean(axis=1))


def _solved(rows: _Rows, columns: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Time, values, their standard errors, and of these what friction leaves, by least squares over rows and joints of a window.

    Joints are weighted by how well their friction is known and by their scatter, found in a first solution without.
    """
    n = columns.shape[2]
    level = np.sqrt((rows.unsure**2).mean(axis=0)) + _LEAST_TORQUE
    scatter = np.zeros(len(level))
    for _ in range(2):
        weight = rows.used / np.hypot(level, scatter)
        a, b = (columns * weight[:, :, None]).reshape(-1, n), (rows.left * weight).ravel()
        square = a.T @ a
        inverse = np.linalg.pinv(square, rcond=_FELT, hermitian=True)
        value = inverse @ (a.T @ b)
        off = (rows.left - columns @ value) * rows.used
        free = max(float(rows.used.sum()) / _CORRELATED - n, 1.0)
        scatter = np.sqrt((off**2).sum(axis=0) / np.maximum(rows.used.sum(axis=0), 1))
    spread = (off * weight).ravel()
    noise = np.sqrt(np.diag(inverse) * _CORRELATED * (spread @ spread) / max(free * _CORRELATED, 1.0))
    shares = np.einsum("mn,tkn->mtk", inverse, columns * weight[:, :, None] ** 2)
    friction = np.sqrt((np.einsum("mtk,tk->mk", shares, rows.unsure) ** 2).sum(axis=1))
    felt = np.abs(np.diag(inverse @ square) - 1.0) < 1e-6  # what joints feel of it, not together with something else
    error = np.where(felt, np.hypot(noise, friction), np.inf)
    return rows.time, np.where(felt, value, np.nan), error, np.where(felt, friction, np.inf)


def load_table(found: PayloadEstimate | TipForceEstimate) -> Table:
    """Windows of an estimate in which everything is known, as a table in SI: ``time``, then each value with its ``_error``."""
    known = np.isfinite(found.error)
    if isinstance(found, PayloadEstimate):
        rows, parts = known, {"payload": (found.payload, found.error, "kg")}
    else:
        axes = [k for k in range(3) if known[:, k].any()]
        rows = known[:, axes].all(axis=1)
        parts = {f"force_{'xyz'[k]}": (found.force[:, k], found.error[:, k], "N") for k in axes}
    values, units = {"time": found.time[rows]}, {"time": "s"}
    for name, (value, error, unit) in parts.items():
        values[name], values[f"{name}_error"] = value[rows], error[rows]
        units[name] = units[f"{name}_error"] = unit
    return Table(values, units)
