"""Outlet curves of a valve: rises that are never negative, from what leaves the actuator and the pressure behind it.

The flow is conductance times the root of the pressure drop, so that a curve on given knots is a linear problem: non-negative least squares.
Rows are weighted by what noise of spool, pressure and flow makes of the flow, with the drop that the flow takes: by the measured drop, noise would choose
them. Rows that are far off count less. Knots are added where an outlet bends and inlet and bypass do not.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.identification.equations.fit.held_out import huber, surely_better
from polydraulic.identification.equations.fit.uncertainty import at_travel
from polydraulic.identification.equations.fit.valve_curves import Place, at_place, between, placed_among, rising
from polydraulic.identification.equations.fit.weighing import (
    HUBER,
    LEAST_DROP,
    add_squares,
    linearise_outlet,
    over_knots,
)
from polydraulic.identification.equations.numbers.estimates import unhidden
from polydraulic.identification.equations.observations import Balance, mean_weights
from polydraulic.identification.equations.sensors import Signals

_PASSES, _CHOICES = 4, 2
_PIECES, _LEAST_ROWS = 10, 20  # of the log for each number, and rows of one at least
_CLOSEST = 1e-4  # m, between two knots
_STEPS, _NEAREST, _LITTLE = 8, 0.3, 1e-5  # over places of knots: how many, shares of a gap, and what a last one gains
_LEAD = 0.02  # s, by which clocks of sensors may be apart
_SHARES = (0.2, 0.35, 0.5, 0.65, 0.8)  # of the way between two knots, where one more may be


class OutletRows(NamedTuple):
    """What says something of one outlet: travels, drops and how fast these change in the rows of each window, and mean flows."""

    travel: np.ndarray  # (n_window, n_long) m
    drop: np.ndarray  # (n_window, n_long) Pa, as if nothing held the return line
    rate: np.ndarray  # (n_window, n_long) Pa/s
    q_out: np.ndarray  # (n_window,) m3/s
    block: np.ndarray  # (n_window,)
    noise_travel: float
    noise_pressure: float
    noise_flow: float
    noise_scale: float = 0.0  # of travel, relative, in all rows alike

    def some(self, keep: np.ndarray) -> "OutletRows":
        """Those windows."""
        return self._replace(
            **{name: getattr(self, name)[keep] for name in ("travel", "drop", "rate", "q_out", "block")}
        )


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
    by_lead: np.ndarray  # (n_window,) m3/s2


class _Solution(NamedTuple):
    """A curve and what it leaves: residuals in standard deviations, their slopes over its rises and the lead, and what was known before of these."""

    values: np.ndarray
    lead: float  # s, by which sensors of pressure are behind that of flow
    slopes: np.ndarray  # (n_window, m)
    by_place: np.ndarray  # (n_window, m), over the places of knots
    off: np.ndarray  # (n_window,)
    at: _Linear
    known: np.ndarray  # (m, m)

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
    *,
    rates: bool,
) -> OutletRows:
    """Windows in which the valve is open to one side, `forward` that of positive spools; `rates` of pressures count, or are zero."""
    spool, port = s.values["spool"][b.rows], "p_b" if forward else "p_a"
    side = (spool > 0.0) if forward else (spool <= 0.0)
    p_out, rate = s.values[port][b.rows], s.rates[port][b.rows]
    travel = np.abs(spool)
    keep = b.known_out & side.all(axis=1) & (travel.max(axis=1) > 0.8 * opens)
    return OutletRows(
        travel[keep],
        p_out[keep],
        rate[keep] if rates else np.zeros_like(rate[keep]),
        b.q_out[keep],
        block[b.rows[keep, 0]],
        s.noise["spool"],
        s.noise[port],
        b.noise_out,
        s.scale,
    )


def fit_outlet(rows: OutletRows, knots: np.ndarray, prior: OutletPrior, places: np.ndarray | None = None) -> OutletFit:
    """Curve on given knots.

    Parameters
    ----------
    rows : OutletRows
    knots : (m,) array, m
    prior : OutletPrior
    places : (m,) array, m, optional
        Standard errors of the knots' places as other curves gave them; infinite where these rows did. Known if not given.
    """
    hold = rows.block % 5 == 4
    learnt = _solved(rows.some(~hold), knots, prior)
    held = rows.some(hold)
    left = (predicted_out(held, knots, learnt.values, prior.p_return, learnt.lead) - held.q_out)[
        _speaks(held, knots, learnt.values)
    ]
    found, finer = _solved(rows, knots, prior), between(knots)
    bent = _solved(rows, finer, prior).values
    places = np.zeros(len(knots)) if places is None else places
    errors = np.hypot(_errors(found, knots, places, rows.noise_scale), np.interp(knots, finer, bent) - found.values)
    held_out = float(np.sqrt(np.mean(left**2))) if left.size else np.nan
    return OutletFit(found.values, errors, held_out, float(huber(found.off).sum()), len(rows.q_out))


def bent_knots(rows: OutletRows, knots: np.ndarray, prior: OutletPrior, most: int) -> np.ndarray:
    """Knots, at most so many, with those that the outlet needs besides: one more at a time, while blocks held out get better."""
    first = _solved(rows.some(rows.block % 5 != 4), knots, prior)
    rows = rows.some(_speaks(rows, knots, first.values))
    hold = rows.block % 5 == 4
    learn, held = rows.some(~hold), rows.some(hold)
    if not len(held.q_out):
        return knots
    now, first_knots = _solved_on(learn, knots, prior, first.values, first.lead), knots
    off = _left_over(held, knots, now, prior)
    while len(knots) < most:
        at = _promising(learn, knots, now)
        if at is None:
            break
        more = np.sort(np.append(knots, at))
        wider = _solved_on(learn, more, prior, np.interp(more, knots, now.values), now.lead)
        more, wider = _placed(learn, more, ~np.isin(more, first_knots), prior, wider)
        trial = _left_over(held, more, wider, prior)
        if not surely_better(off, trial, held.block):
            break
        knots, now, off = more, wider, trial
    return knots


def _placed(
    rows: OutletRows, knots: np.ndarray, free: np.ndarray, prior: OutletPrior, now: _Solution
) -> tuple[np.ndarray, _Solution]:
    """Those knots that are free where the rows have them, and the curve on these: damped steps over their places together with the curve."""
    damping, m = 1e-3, len(knots)
    for _ in range(_STEPS):
        slopes = np.column_stack([now.slopes, now.by_place[:, free]])
        weighed = slopes * now.robust[:, None]
        h = weighed.T @ slopes
        h[:m, :m] += now.known
        unit = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
        damped = h * unit[:, None] * unit + damping * np.eye(len(h))
        step = np.zeros(m)
        step[free] = -(np.linalg.solve(damped, (weighed.T @ now.off) * unit) * unit)[m:]
        gaps = np.diff(knots)
        step[1:-1] = np.clip(step[1:-1], -_NEAREST * gaps[:-1], _NEAREST * gaps[1:])
        trial = knots + step
        there = _solved_on(rows, trial, prior, np.interp(trial, knots, now.values), now.lead)
        gained = huber(now.off).sum() - huber(there.off).sum()
        if np.diff(trial).min() >= _CLOSEST and gained > 0.0:
            if gained < _LITTLE * huber(now.off).sum():
                return trial, there
            knots, now, damping = trial, there, 0.2 * damping
        else:
            damping *= 16.0
    return knots, now


def predicted_out(
    rows: OutletRows, knots: np.ndarray, values: np.ndarray, p_return: float, lead: float = 0.0
) -> np.ndarray:
    """Mean flows out, (n_window,)."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    return (k * np.sqrt(np.maximum(rows.drop + lead * rows.rate - p_return, 0.0))) @ mean_weights(rows.travel.shape[1])


def _speaks(rows: OutletRows, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Windows whose flow needs a drop well above the pressure's noise; by the measured drop, noise would choose them."""
    k = at_place(values, placed_among(knots, rows.travel.ravel())).reshape(rows.travel.shape)
    drop = np.square(rows.q_out / np.maximum(k.mean(axis=1), 1e-12))
    return np.asarray((drop > LEAST_DROP * rows.noise_pressure) | (k.max(axis=1) < 1e-9))


def _solved(rows: OutletRows, knots: np.ndarray, prior: OutletPrior) -> _Solution:
    values, lead = np.interp(knots, prior.knots, prior.values), 0.0
    for _ in range(_CHOICES):
        found = _solved_on(rows.some(_speaks(rows, knots, values)), knots, prior, values, lead)
        values, lead = found.values, found.lead
    return found


def _solved_on(rows: OutletRows, knots: np.ndarray, prior: OutletPrior, values: np.ndarray, lead: float) -> _Solution:
    from scipy.optimize import nnls

    m = len(knots)
    to_values, before = np.zeros((m + 1, m)), np.interp(knots, prior.knots, prior.values)
    to_values[:m, :-1], to_values[m, -1] = rising(m), 1.0
    place = _placed_rows(rows, knots)
    width = (prior.spread * np.maximum(before, 0.1 * before.max()))[1:]
    known, known_target = np.zeros((m, m)), np.append(before[1:] / width, 0.0)
    known[:-1, :-1], known[-1, -1] = to_values[1:m, :-1] / width[:, None], 1.0 / _LEAD
    used = np.empty(m + 1, dtype=np.int64)
    for _ in range(_PASSES):
        at, now = _linear(rows, knots, values, lead, prior), np.append(values, lead)
        slopes = _slopes(place, at, m)
        target = at.target / at.sd
        gradient, curvature = np.zeros(m + 1), np.zeros((m + 1, m + 1))
        add_squares(slopes @ now - target, slopes, gradient, curvature, used)
        curvature += np.tril(curvature, -1).T
        gram = to_values.T @ curvature @ to_values + known.T @ known
        moment = to_values.T @ (curvature @ now - gradient) + known.T @ known_target
        unit = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-300))
        gram, moment = gram * unit[:, None] * unit, moment * unit
        # the lead has no bound: what it takes of the rest comes off first
        rest = gram[:-1, :-1] - np.outer(gram[:-1, -1], gram[-1, :-1])
        lower = np.linalg.cholesky(rest + 1e-12 * np.eye(m - 1))
        rises = nnls(lower.T, np.linalg.solve(lower, moment[:-1] - gram[:-1, -1] * moment[-1]))[0]
        values = to_values[:m, :-1] @ (rises * unit[:-1])
        lead = float((moment[-1] - gram[-1, :-1] @ rises) * unit[-1])
    steep = (np.diff(values) / np.diff(knots))[place.left]
    by_place = -_over_knots(place, at.root * steep / at.sd[:, None], m)
    off = slopes @ np.append(values, lead) - target
    return _Solution(values, lead, slopes @ to_values, by_place, off, at, known.T @ known)


def _placed_rows(rows: OutletRows, knots: np.ndarray) -> Place:
    """Where travels lie among knots, (n_window, n_long) each."""
    return Place(*(x.reshape(rows.travel.shape) for x in placed_among(knots, rows.travel.ravel())))


def _over_knots(place: Place, factor: np.ndarray, count: int) -> np.ndarray:
    """Means of windows of a factor in each row over the values at knots, (n_window, count)."""
    found = np.zeros((len(factor), count))
    over_knots(place.left, place.share, factor * mean_weights(factor.shape[1]), found)
    return found


def _slopes(place: Place, at: _Linear, count: int) -> np.ndarray:
    """Of mean flows in standard deviations, over the values at knots and the lead, (n_window, count + 1)."""
    return np.column_stack([_over_knots(place, at.root / at.sd[:, None], count), at.by_lead / at.sd])


def _linear(rows: OutletRows, knots: np.ndarray, values: np.ndarray, lead: float, prior: OutletPrior) -> _Linear:
    """The problem around a curve and a lead.

    The root of a noisy drop is a noisy factor of the conductance: too small in the mean, and skewed. Where the flow is known better, the drop that it takes
    is the factor, and what the measured drop is off from that is the noise. Elsewhere the flow is put right: the root is too small by an eighth of
    the square of the drop's relative noise, and its square, by which it is divided, is not. Windows are left as they are.
    """
    place, shape = _placed_rows(rows, knots), rows.travel.shape
    at = _Linear(np.empty(shape), *np.empty((3, len(rows.q_out))))
    linearise_outlet(
        place.left, place.share, rows.drop, rows.rate, rows.q_out, mean_weights(shape[1]), values, np.diff(values) / np.diff(knots), lead, prior.p_return,
        np.array([rows.noise_travel, rows.noise_pressure, rows.noise_flow]), at.root, at.target, at.sd, at.by_lead,
    )  # fmt: skip
    return at


def _errors(found: _Solution, knots: np.ndarray, places: np.ndarray, scale: float) -> np.ndarray:
    """Standard errors of the curve at the travels of its knots, from how pieces of the log pull at a solution.

    Knots that these rows placed err with it; those that others placed err as they were said to, and make it give way. Bounds are left out, so that
    what lies flat is not taken for known.
    """
    n, m = found.slopes.shape
    free = np.isinf(places)
    slopes = np.column_stack([found.slopes, found.by_place[:, free]])
    weighed = slopes * found.robust[:, None]
    known = np.zeros((slopes.shape[1], slopes.shape[1]))
    known[:m, :m] = found.known
    known[m:, m:] = np.eye(int(free.sum())) * float(knots[-1]) ** -2  # no knot lies beyond the travel
    h = weighed.T @ slopes + known
    unit = 1.0 / np.sqrt(np.maximum(np.diag(h), 1e-300))
    bread = np.linalg.pinv(h * unit[:, None] * unit, rcond=1e-12) * unit[:, None] * unit
    pieces = max(min(_PIECES * m, n // _LEAST_ROWS), 1)
    pulls = np.zeros((pieces, slopes.shape[1]))
    np.add.at(pulls, np.arange(n) * pieces // max(n, 1), weighed * found.off[:, None])
    meat = pulls.T @ pulls * unhidden(pieces, float(np.trace(bread @ (h - known))))
    by_given = bread @ weighed.T @ found.by_place[:, ~free]
    given = np.square(places[~free])
    to_values, to_places = np.zeros((2, m, slopes.shape[1]))
    to_values[:, : m - 1] = rising(m)
    to_places[np.flatnonzero(free), np.arange(m, slopes.shape[1])] = 1.0
    values_by_given, places_by_given = -to_values @ by_given, -to_places @ by_given
    places_by_given[np.flatnonzero(~free), np.arange(len(given))] += 1.0
    own = bread @ (meat + known) @ bread
    of_values, of_both, of_places = (
        a @ own @ b.T + (by_a * given) @ by_b.T
        for a, by_a, b, by_b in (
            (to_values, values_by_given, to_values, values_by_given),
            (to_values, values_by_given, to_places, places_by_given),
            (to_places, places_by_given, to_places, places_by_given),
        )
    )
    return at_travel(of_values, of_both, of_places, knots, found.values, knots * scale)


def _left_over(rows: OutletRows, knots: np.ndarray, of: _Solution, prior: OutletPrior) -> np.ndarray:
    """In standard deviations, (n_window,)."""
    at = _linear(rows, knots, of.values, of.lead, prior)
    slopes = _slopes(_placed_rows(rows, knots), at, len(knots))
    return np.asarray(slopes @ np.append(of.values, of.lead) - at.target / at.sd)


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
    new = np.einsum("wlm,wl->wm", tents, now.at.root * mean_weights(rows.travel.shape[1])) / now.at.sd[:, None]
    h = (now.slopes * now.robust[:, None]).T @ now.slopes + now.known
    cross, own = (now.slopes * now.robust[:, None]).T @ new, np.sum(new * new * now.robust[:, None], axis=0)
    g = new.T @ (now.robust * now.off)
    rest = own - np.sum(cross * np.linalg.solve(h, cross), axis=0)
    promise = np.where(rest > 1e-6 * own, g * g / np.maximum(rest, 1e-300), 0.0)
    best = int(np.argmax(promise))
    return float(at[best]) if promise[best] > 0.0 else None
