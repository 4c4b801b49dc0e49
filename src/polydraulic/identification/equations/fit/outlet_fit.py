"""Outlet curves of a valve: rises that are never negative, from what leaves the actuator and the pressure behind it.

The flow is conductance times the root of the pressure drop, so that a curve on given knots is a linear problem: non-negative least squares.
Rows are weighted by what noise of spool, pressure and flow makes of the flow, with the drop that the flow takes: by the measured drop, noise would choose
them. Rows that are far off count less. Knots are added where an outlet bends and inlet and bypass do not.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.circuit_fit import HUBER
from polydraulic.identification.equations.fit.knots import BETTER, SURE
from polydraulic.identification.equations.fit.valve_curves import at_place, between, hats, placed_among, rising
from polydraulic.identification.equations.numbers.estimates import unhidden
from polydraulic.identification.equations.observations import Balance, mean_weights
from polydraulic.identification.equations.sensors import Signals

_LEAST_DROP = 3.0  # standard deviations of the pressure's noise, below which a drop says nothing of the conductance
_PASSES, _CHOICES = 4, 2
_LEAST_FLOW = 5.0  # standard deviations of its noise, from which on a flow tells the drop that it takes
_PIECES, _LEAST_ROWS = 10, 20  # of the log for each number, and rows of one at least
_CLOSEST = 1e-4  # m, between two knots
_SHARES = (0.2, 0.35, 0.5, 0.65, 0.8)  # of the way between two knots, where one more may be


class OutletRows(NamedTuple):
    """What says something of one outlet: travels and drops of the rows of each window, and mean flows."""

    travel: np.ndarray  # (n_window, n_long) m
    drop: np.ndarray  # (n_window, n_long) Pa, as if nothing held the return line
    q_out: np.ndarray  # (n_window,) m3/s
    block: np.ndarray  # (n_window,)
    noise_travel: float
    noise_pressure: float
    noise_flow: float

    def some(self, keep: np.ndarray) -> "OutletRows":
        """Those windows."""
        return self._replace(**{name: getattr(self, name)[keep] for name in ("travel", "drop", "q_out", "block")})


class OutletPrior(NamedTuple):
    """What was known before: pressure in the return line, Pa, a curve at knots, and how far it may be off, as a share."""

    p_return: float
    knots: np.ndarray
    values: np.ndarray
    spread: float


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


class _Linear(NamedTuple):
    """Flows as conductances times factors, around a curve."""

    root: np.ndarray  # (n_window, n_long) Pa^0.5
    target: np.ndarray  # (n_window,) m3/s
    sd: np.ndarray  # (n_window,) m3/s


class _Solution(NamedTuple):
    """A curve and what it leaves: slopes over its rises and residuals in standard deviations, and what was known before of the rises."""

    values: np.ndarray
    slopes: np.ndarray  # (n_window, m - 1)
    off: np.ndarray  # (n_window,)
    at: _Linear
    known: np.ndarray  # (m - 1, m - 1)

    @property
    def robust(self) -> np.ndarray:
        """How much each window counts."""
        return np.minimum(1.0, HUBER / np.maximum(np.abs(self.off), 1e-300))


def outlet_rows(
    s: Signals,
    b: Balance,
    block: np.ndarray,
    forward: bool,
    opens: float,
    rates: tuple[np.ndarray, np.ndarray],
    lead: float,
) -> OutletRows:
    """Windows in which the valve is open to one side, `forward` that of positive spools.

    `rates` are those of the pressures at both ports, Pa/s, whose sensors are `lead` behind those of flow, s.
    """  # fmt: skip
    assert s.spool is not None
    assert s.p_a is not None
    assert s.p_b is not None
    spool = s.spool[b.rows]
    side = (spool > 0.0) if forward else (spool <= 0.0)
    p_out = ((s.p_b if forward else s.p_a) + lead * rates[1 if forward else 0])[b.rows]
    travel = np.abs(spool)
    keep = b.known_out & side.all(axis=1) & (travel.max(axis=1) > 0.8 * opens)
    noise = s.noise["p_b" if forward else "p_a"]
    return OutletRows(
        travel[keep], p_out[keep], b.q_out[keep], block[b.rows[keep, 0]], s.noise["spool"], noise, b.noise_out
    )


def fit_outlet(rows: OutletRows, knots: np.ndarray, prior: OutletPrior) -> OutletFit:
    """Curve on given knots.

    Parameters
    ----------
    rows : OutletRows
    knots : (m,) array, m
    prior : OutletPrior
    """
    hold = rows.block % 5 == 4
    learnt = _solved(rows.some(~hold), knots, prior).values
    held = rows.some(hold)
    left = (predicted_out(held, knots, learnt, prior.p_return) - held.q_out)[_speaks(held, knots, learnt)]
    found, finer = _solved(rows, knots, prior), between(knots)
    bent = _solved(rows, finer, prior).values
    errors = np.hypot(_errors(found), np.interp(knots, finer, bent) - found.values)
    size = np.abs(found.off)
    loss = float(np.sum(np.where(size <= HUBER, 0.5 * size * size, HUBER * (size - 0.5 * HUBER))))
    return OutletFit(
        found.values, errors, float(np.sqrt(np.mean(left**2))) if left.size else np.nan, loss, len(rows.q_out)
    )


def bent_knots(rows: OutletRows, knots: np.ndarray, prior: OutletPrior, most: int) -> np.ndarray:
    """Knots, at most so many, with those that the outlet needs besides: one more at a time, while blocks held out get better."""
    first = _solved(rows.some(rows.block % 5 != 4), knots, prior).values
    rows = rows.some(_speaks(rows, knots, first))
    hold = rows.block % 5 == 4
    learn, held = rows.some(~hold), rows.some(hold)
    if not len(held.q_out):
        return knots
    now = _solved_on(learn, knots, prior, first)
    by_block = _block_losses(held, knots, now.values, prior)
    while len(knots) < most:
        at = _promising(learn, knots, now)
        if at is None:
            break
        more = np.sort(np.append(knots, at))
        wider = _solved_on(learn, more, prior, np.interp(more, knots, now.values))
        of_blocks = _block_losses(held, more, wider.values, prior)
        saved = by_block - of_blocks
        if saved.mean() <= max(BETTER * by_block.mean(), SURE * saved.std() / np.sqrt(max(len(saved) - 1, 1))):
            break
        knots, now, by_block = more, wider, of_blocks
    return knots


def predicted_out(rows: OutletRows, knots: np.ndarray, values: np.ndarray, p_return: float) -> np.ndarray:
    """Mean flows out, (n_window,)."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    return (k * np.sqrt(np.maximum(rows.drop - p_return, 0.0))) @ mean_weights(rows.travel.shape[1])


def _speaks(rows: OutletRows, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Windows whose flow needs a drop well above the pressure's noise; by the measured drop, noise would choose them."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    drop = np.square(rows.q_out / np.maximum(k.mean(axis=1), 1e-12))
    return np.asarray((drop > _LEAST_DROP * rows.noise_pressure) | (k.max(axis=1) < 1e-9))


def _solved(rows: OutletRows, knots: np.ndarray, prior: OutletPrior) -> _Solution:
    values = np.interp(knots, prior.knots, prior.values)
    for _ in range(_CHOICES):
        found = _solved_on(rows.some(_speaks(rows, knots, values)), knots, prior, values)
        values = found.values
    return found


def _solved_on(rows: OutletRows, knots: np.ndarray, prior: OutletPrior, values: np.ndarray) -> _Solution:
    from scipy.optimize import nnls

    m, long = len(knots), rows.travel.shape[1]
    to_values, before = rising(m), np.interp(knots, prior.knots, prior.values)
    shares = hats(placed_among(knots, rows.travel.ravel()), m).reshape(-1, long, m) @ to_values
    width = (prior.spread * np.maximum(before, 0.1 * before.max()))[1:]
    known, known_target = to_values[1:] / width[:, None], before[1:] / width
    for _ in range(_PASSES):
        at = _linear(rows, knots, values, prior)
        by_rise = _mean_over(shares, at.root) / at.sd[:, None]
        target = at.target / at.sd
        scale = np.sqrt(np.minimum(1.0, HUBER / np.maximum(np.abs(by_rise @ np.diff(values) - target), 1e-300)))
        design = np.concatenate([by_rise * scale[:, None], known])
        gram, moment = design.T @ design, design.T @ np.concatenate([target * scale, known_target])
        unit = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        lower = np.linalg.cholesky(gram * unit[:, None] * unit + 1e-12 * np.eye(m - 1))
        values = to_values @ (nnls(lower.T, np.linalg.solve(lower, moment * unit))[0] * unit)
    return _Solution(values, by_rise, by_rise @ np.diff(values) - target, at, known.T @ known)


def _mean_over(shares: np.ndarray, root: np.ndarray) -> np.ndarray:
    return np.einsum("wlm,wl->wm", shares, root * mean_weights(root.shape[1]))


def _linear(rows: OutletRows, knots: np.ndarray, values: np.ndarray, prior: OutletPrior) -> _Linear:
    """The problem around a curve.

    The root of a noisy drop is a noisy factor of the conductance: too small in the mean, and skewed. Where the flow is known better, the drop that it takes
    is the factor, and what the measured drop is off from that is the noise. Elsewhere the mean is put right: the root is too small by an eighth of
    the square of the drop's relative noise, and its square is not. Windows are left as they are.
    """
    place, drop = placed_among(knots, rows.travel.ravel()), rows.drop - prior.p_return
    k = at_place(values, place).reshape(drop.shape)
    slope = (np.diff(values) / np.diff(knots))[place.left].reshape(drop.shape).mean(axis=1)
    root, one, mean_k = np.sqrt(np.maximum(drop, 1.0)), mean_weights(drop.shape[1]), k.mean(axis=1)
    least = np.sqrt(_LEAST_DROP * rows.noise_pressure)
    # the mean flow of a window is no flow at its mean travel
    flows = (rows.q_out > _LEAST_FLOW * rows.noise_flow) & (k.max(axis=1) > 1e-9) & (drop.shape[1] == 1)
    taken = np.where(flows, np.maximum(rows.q_out / np.maximum(mean_k, 1e-12), least), root @ one)
    share = np.sum(one**2)
    sd = np.sqrt(
        rows.noise_flow**2
        + ((slope * taken * rows.noise_travel) ** 2 + (0.5 * mean_k / taken * rows.noise_pressure) ** 2) * share
    )
    of_pressure, of_flow = rows.noise_pressure / taken**2, 2.0 * rows.noise_flow / np.maximum(rows.q_out, 1e-12)
    by_flow = flows & (of_pressure > of_flow)
    target = np.where(
        by_flow,
        mean_k * taken - 0.5 * mean_k / taken * (drop @ one - taken**2),
        rows.q_out * (1.0 - np.where(flows, 0.125, 0.0) * of_pressure**2),
    )
    return _Linear(np.where(by_flow[:, None], taken[:, None], root), target, sd)


def _errors(found: _Solution) -> np.ndarray:
    """Standard errors from how pieces of the log pull at a solution; bounds are left out, so that what lies flat is not taken for known."""
    n, m = found.slopes.shape
    h = (found.slopes * found.robust[:, None]).T @ found.slopes + found.known
    unit = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    bread = np.linalg.pinv(h * unit[:, None] * unit, rcond=1e-12) * unit[:, None] * unit
    pieces = max(min(_PIECES * m, n // _LEAST_ROWS), 1)
    pulls = np.zeros((pieces, m))
    np.add.at(pulls, np.arange(n) * pieces // max(n, 1), found.slopes * (found.robust * found.off)[:, None])
    meat = pulls.T @ pulls * unhidden(pieces, float(np.trace(bread @ (h - found.known))))
    t = rising(m + 1)
    covariance = t @ bread @ (meat + found.known) @ bread @ t.T
    return np.sqrt(np.maximum(np.diag(covariance), 0.0))


def _block_losses(rows: OutletRows, knots: np.ndarray, values: np.ndarray, prior: OutletPrior) -> np.ndarray:
    """Half the mean weighted squares of each block of time, (n_block,)."""
    at, m = _linear(rows, knots, values, prior), len(knots)
    shares = hats(placed_among(knots, rows.travel.ravel()), m).reshape(*rows.travel.shape, m)
    size = np.abs(_mean_over(shares, at.root) @ values - at.target) / at.sd
    _, block = np.unique(rows.block, return_inverse=True)
    weighed = np.where(size <= HUBER, 0.5 * size * size, HUBER * (size - 0.5 * HUBER))
    return np.bincount(block, weighed) / np.bincount(block)


def _promising(rows: OutletRows, knots: np.ndarray, now: _Solution) -> float | None:
    """Where one more knot promises most, by the slopes over its height, less what the others can do of the same."""
    gaps = np.diff(knots)
    at = np.concatenate([knots[:-1] + share * gaps for share in _SHARES])
    at = at[np.abs(at[:, None] - knots).min(axis=1) >= _CLOSEST]
    if not len(at):
        return None
    right = np.searchsorted(knots, at)
    tents = np.stack(
        [
            np.interp(rows.travel, [knots[k - 1], x, knots[k]], [0.0, 1.0, 0.0])
            for k, x in zip(right.tolist(), at.tolist(), strict=True)
        ],
        axis=-1,
    )
    new = _mean_over(tents, now.at.root) / now.at.sd[:, None]
    h = (now.slopes * now.robust[:, None]).T @ now.slopes + now.known
    cross, own = (now.slopes * now.robust[:, None]).T @ new, np.sum(new * new * now.robust[:, None], axis=0)
    g = new.T @ (now.robust * now.off)
    rest = own - np.sum(cross * np.linalg.solve(h, cross), axis=0)
    promise = np.where(rest > 1e-6 * own, g * g / np.maximum(rest, 1e-300), 0.0)
    best = int(np.argmax(promise))
    return float(at[best]) if promise[best] > 0.0 else None
