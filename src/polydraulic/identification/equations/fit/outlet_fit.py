"""Outlet curves of a valve: rises that are never negative, from what leaves the actuator and the pressure behind it.

The flow is conductance times the root of the pressure drop, so that a curve on given knots is a linear problem: non-negative least squares.
Rows are weighted by what noise of spool, pressure and flow makes of the flow; those that are far off count less.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import HUBER
from polydraulic.identification.equations.fit.valve_curves import at_place, between, hats, placed_among, rising
from polydraulic.identification.equations.observations import Balance, mean_weights
from polydraulic.identification.equations.sensors import Signals

_LEAST_DROP = 3.0  # standard deviations of the pressure's noise, below which a drop says nothing of the conductance
_PASSES, _CHOICES = 4, 2


class OutletRows(NamedTuple):
    """What says something of one outlet: travels and drops of the rows of each window, and mean flows."""

    travel: np.ndarray  # (n_window, n_long) m
    drop: np.ndarray  # (n_window, n_long) Pa, as if nothing held the return line
    q_out: np.ndarray  # (n_window,) m3/s
    block: np.ndarray  # (n_window,)
    noise_travel: float
    noise_pressure: float
    noise_flow: float


class OutletFit(NamedTuple):
    """An outlet's curve.

    Attributes
    ----------
    values, errors : (m,) array, m3/s/Pa^0.5
        At the knots, and standard errors, which hold how far they move where there are twice as many.
    held_out : float
        Root of the mean square of what is left on blocks held out, m3/s.
    loss : float
        Half the weighted squares of all rows.
    rows : int
    """

    values: np.ndarray
    errors: np.ndarray
    held_out: float
    loss: float
    rows: int


def outlet_rows(s: Signals, b: Balance, block: np.ndarray, forward: bool, opens: float) -> OutletRows:
    """Windows in which the valve is open to one side, `forward` that of positive spools."""
    assert s.spool is not None
    assert s.p_a is not None
    assert s.p_b is not None
    spool = s.spool[b.rows]
    side = (spool > 0.0) if forward else (spool <= 0.0)
    p_out = (s.p_b if forward else s.p_a)[b.rows]
    travel = np.abs(spool)
    keep = b.known_out & side.all(axis=1) & (travel.max(axis=1) > 0.8 * opens)
    noise = s.noise["p_b" if forward else "p_a"]
    return OutletRows(
        travel[keep], p_out[keep], b.q_out[keep], block[b.rows[keep, 0]], s.noise["spool"], noise, b.noise_out
    )


def fit_outlet(rows: OutletRows, knots: np.ndarray, p_return: float, before: np.ndarray, spread: float) -> OutletFit:
    """Curve on given knots.

    Parameters
    ----------
    rows : OutletRows
    knots : (m,) array, m
    p_return : float, Pa
    before : (m,) array, m3/s/Pa^0.5
        What was known of the curve before.
    spread : float
        How far that may be off, as a share.
    """
    hold = rows.block % 5 == 4
    learnt, _, _ = _solved(rows, ~hold, knots, p_return, before, spread)
    left = (predicted_out(rows, knots, learnt, p_return) - rows.q_out)[hold & _speaks(rows, knots, learnt)]
    every, finer = np.ones(len(hold), dtype=bool), between(knots)
    values, errors, loss = _solved(rows, every, knots, p_return, before, spread)
    bent, _, _ = _solved(rows, every, finer, p_return, np.interp(finer, knots, before), spread)
    errors = np.hypot(errors, np.interp(knots, finer, bent) - values)  # a straight line between knots is no curve
    return OutletFit(values, errors, float(np.sqrt(np.mean(left**2))) if left.size else np.nan, loss, len(rows.q_out))


def predicted_out(rows: OutletRows, knots: np.ndarray, values: np.ndarray, p_return: float) -> np.ndarray:
    """Mean flows out, (n_window,)."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    return (k * np.sqrt(np.maximum(rows.drop - p_return, 0.0))) @ mean_weights(rows.travel.shape[1])


def _speaks(rows: OutletRows, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Windows whose flow needs a drop well above the pressure's noise; by the measured drop, noise would choose them."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    drop = np.square(rows.q_out / np.maximum(k.mean(axis=1), 1e-12))
    return np.asarray((drop > _LEAST_DROP * rows.noise_pressure) | (k.max(axis=1) < 1e-9))


def _solved(
    rows: OutletRows, keep: np.ndarray, knots: np.ndarray, p_return: float, before: np.ndarray, spread: float
) -> tuple[np.ndarray, np.ndarray, float]:
    values = before
    for _ in range(_CHOICES):
        chosen = keep & _speaks(rows, knots, values)
        values, errors, loss = _solved_on(rows, chosen, knots, p_return, before, spread)
    return values, errors, loss


def _solved_on(
    rows: OutletRows, keep: np.ndarray, knots: np.ndarray, p_return: float, before: np.ndarray, spread: float
) -> tuple[np.ndarray, np.ndarray, float]:
    from scipy.optimize import nnls

    travel, drop, q = rows.travel[keep], np.maximum(rows.drop[keep] - p_return, 1.0), rows.q_out[keep]
    m, long = len(knots), travel.shape[1]
    weights, to_values = mean_weights(long), rising(m)
    place = placed_among(knots, travel.ravel())
    root = np.sqrt(drop)
    shares = np.einsum("wlm,wl->wm", hats(place, m).reshape(-1, long, m), root * weights)
    width = spread * np.maximum(before, 0.1 * before.max())
    prior, prior_target = to_values[1:] / width[1:, None], before[1:] / width[1:]
    values, robust = before, np.ones(len(q))
    for _ in range(_PASSES):
        k = at_place(values, place).reshape(travel.shape)
        slope = (np.diff(values) / np.diff(knots))[place.left].reshape(travel.shape)
        by_travel, by_pressure = slope * root, 0.5 * k / root
        share = np.sqrt(np.sum(weights**2))
        variance = (
            rows.noise_flow**2
            + (
                (by_travel.mean(axis=1) * rows.noise_travel) ** 2
                + (by_pressure.mean(axis=1) * rows.noise_pressure) ** 2
            )
            * share**2
        )
        scale = robust / np.sqrt(variance)
        design = np.concatenate([shares * scale[:, None] @ to_values, prior])
        target = np.concatenate([q * scale, prior_target])
        gram, moment = design.T @ design, design.T @ target
        unit = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        lower = np.linalg.cholesky(gram * unit[:, None] * unit + 1e-12 * np.eye(m - 1))
        rises = nnls(lower.T, np.linalg.solve(lower, moment * unit))[0] * unit
        values = to_values @ rises
        off = (shares @ values - q) / np.sqrt(variance)
        robust = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.abs(off), 1e-300)))
    size = np.abs(off)
    loss = float(np.sum(np.where(size <= HUBER, 0.5 * off * off, HUBER * (size - 0.5 * HUBER))))
    free = rises > 0.0
    covariance = np.zeros((m - 1, m - 1))
    covariance[np.ix_(free, free)] = np.linalg.pinv(gram[np.ix_(free, free)])
    spread_left = max(1.0, float(np.mean(np.minimum(size, 3.0) ** 2))) if size.size else 1.0
    errors = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", to_values, covariance, to_values), 0.0) * spread_left)
    return values, errors, loss
