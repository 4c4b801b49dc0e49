"""The rate of a joint: what the openings of its valve do, alone and changed by what else a log shows.

Coefficients are those with which the travel over short windows of rows fits best. What differs from one piece of work to the next (soil, payload,
oil that has not warmed up) makes an error that adds up, so that squared errors of long runs are those of a few stretches; over short windows a
log holds many of them, and one that fits badly counts by its size, not by its square. More factors have to earn their place on blocks held out,
there over as many rows as runs are meant to go on.

A log of several days shows several machines: a joint that is a tenth slower than the day before would smear the shape of its rate. So each stretch of
a log has a strength of its own for each of the joint's openings, one in the mean, which is fitted along and then left out. How much stretches differ, each by
a rate that the others made, is what a model knows of strengths.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.networks.dynamic.free_run import pieces
from polydraulic.networks.dynamic.joint_strength import STRONGEST, WEAKEST, learn_strength, windows_of
from polydraulic.networks.dynamic.lagged_terms import Frame, Terms, run_terms
from polydraulic.networks.dynamic.spans import Span, blocks_of, rows_of, stretches_of, without
from polydraulic.networks.model.lags import JointStrength

_SCALE = 0.01  # of the joint's range: errors of the travel beyond it count by their size
_REWEIGHED = 16  # times
_RIDGE = 1e-3  # weight of what changes an opening, as a part of the openings' own; the openings themselves are held by next to nothing
_OWN_RIDGE = 1e-6
_ENOUGH = 0.03  # of the error, that a further factor has to gain
# of the joint's range, travelled: what counts as much as the belief that a stretch is as strong as the mean
_TO_ONE = 0.1
_OVERLAP = 4  # windows begin every so many parts of their length
_LONGER = 2  # windows that show a strength are so many times as long as those that rates are fitted to
_FEWEST = 50  # windows away from stops, with fewer of which those at stops stay in


class Factors(NamedTuple):
    """What the rate of a joint is made of: places of lagged values.

    Attributes
    ----------
    own : tuple of int
        Openings of the joint's valve: every term holds one, so that the joint stands still where all of them are zero.
    known : tuple of int
        What each opening is multiplied by in any case.
    offered : tuple of int
        What else it may be multiplied by.
    """

    own: tuple[int, ...]
    known: tuple[int, ...]
    offered: tuple[int, ...]


class Rate(NamedTuple):
    """What is learnt of a joint.

    Attributes
    ----------
    terms : Terms
    error : float
        Mean size of errors of runs through blocks held out as a part of the standard deviation.
    strength : JointStrength or None
        How its strength differs; None where no stretch of the log can be judged by the others. The frame's unit is that of its noise.
    """

    terms: Terms
    error: float
    strength: JointStrength | None


def learn_rate(
    frame: Frame, factors: Factors, spans: Sequence[Span], away: np.ndarray, window: int, horizon: int, n_blocks: int, most: int,
    logs: np.ndarray | None = None,
) -> Rate:  # fmt: skip
    """What the openings of a joint's valve do to it, how well that runs, and how much it differs from one stretch of a log to another.

    Parameters
    ----------
    frame : Frame
        The joint is its only output.
    factors : Factors
    spans : sequence of (start, stop)
        Rows to learn from.
    away : (n_row,) array of bool
        Where the joint is away from its stops: at one it does not follow its valve.
    window : int
        Rows over which travel is fitted.
    horizon : int
        Rows of the runs that judge.
    n_blocks : int
        Blocks of rows, each held out once.
    most : int
        Factors beside those that are known, at most.
    logs : (n_row,) array, optional
        Which log each row is of; one log if not given.
    """
    blocks = [(without(spans, block), pieces(block, horizon)) for block in blocks_of(spans, n_blocks)]
    stretch = np.zeros(len(frame.signals), dtype=np.int64)
    parts = stretches_of(spans, n_blocks, logs)
    for n, part in enumerate(parts):
        for a, b in part:
            stretch[a:b] = n

    def errors_with(chosen: Sequence[int]) -> np.ndarray:
        """Of runs through each block by a rate that the others made."""
        total = np.cumsum(_design(frame, factors.own, chosen), axis=0)
        found = []
        for rest, runs in blocks:
            coef = _fitted(frame, total, _windows(rest, away, window), stretch, len(factors.own))
            terms = _terms(frame, factors.own, chosen, coef)
            found.append(
                np.abs(np.concatenate([errors for errors, _ in run_terms(frame, terms, runs, slopes=False)])).mean()
            )
        return np.array(found)

    chosen, offered = list(factors.known), list(factors.offered)
    best = errors_with(chosen)
    for _ in range(min(most, len(offered))):
        errors = [errors_with([*chosen, place]) for place in offered]
        gains = [best.mean() - one.mean() if (one < best).all() else 0.0 for one in errors]
        if not max(gains) > _ENOUGH * best.mean():
            break
        best = errors[int(np.argmax(gains))]
        chosen.append(offered.pop(int(np.argmax(gains))))
    design = _design(frame, factors.own, chosen)
    total = np.cumsum(design, axis=0)
    coef = _fitted(frame, total, _windows(spans, away, window), stretch, len(factors.own))
    seen = []
    for part in parts:
        rest = _windows(without(spans, part), away, window)
        if len(rest) >= _FEWEST:
            rates = design @ _fitted(frame, total, rest, stretch, len(factors.own))
            seen += [windows_of(rates, frame.signals[:, -1], away, a, b, _LONGER * window) for a, b in part]
    strength = learn_strength(seen, _LONGER * window, horizon, float(np.ptp(frame.signals[rows_of(spans), -1])))
    return Rate(_terms(frame, factors.own, chosen, coef), float(best.mean()), strength)


def _terms(frame: Frame, own: Sequence[int], chosen: Sequence[int], coef: np.ndarray) -> Terms:
    """The joint's own angle, one row ago, and what a design adds to it."""
    pairs = [(1 + place, 0) for place in own] + [
        (1 + max(place, other), 1 + min(place, other)) for other in chosen for place in own
    ]
    weighs = [(a, b, 0) for (a, b), value in zip(pairs, coef, strict=True) if value != 0.0]
    every = np.array([(len(frame.column), 0, 0), *weighs], dtype=np.int64)
    return Terms(every, np.zeros(len(every), dtype=np.int64), np.append(1.0, coef[coef != 0.0]))


def _design(frame: Frame, own: Sequence[int], chosen: Sequence[int]) -> np.ndarray:
    """By row, each opening alone, and then times each of the chosen values; (n_row, n_term)."""
    values = np.ones((len(frame.signals), 1 + len(chosen)))
    for n, place in enumerate(chosen):
        ago = int(frame.steps[place])
        read = frame.signals[:, frame.column[place]]
        read = np.nan_to_num(np.concatenate([read[:ago], read[: len(read) - ago]]))  # what is not known is in no window
        values[:, n + 1] = np.clip(read, frame.low[place], frame.high[place])
    opened = frame.signals[:, frame.column[list(own)]]
    return (values[:, :, None] * opened[:, None, :]).reshape(len(values), -1)


def _windows(spans: Sequence[Span], away: np.ndarray, length: int) -> np.ndarray:
    """First row and last of windows, (n, 2), that keep away from stops; all of them if hardly any do. A shorter span is one window."""
    step = max(1, length // _OVERLAP)
    whole = [(s, min(s + length, b - 1)) for a, b in spans for s in range(a, max(a + 1, b - length), step)]
    ends = np.array(whole, dtype=np.int64).reshape(-1, 2)
    at_stop = np.concatenate([[0], np.cumsum(~away)])
    off = at_stop[ends[:, 1] + 1] == at_stop[ends[:, 0]]
    return ends[off] if off.sum() >= _FEWEST else ends


def _travelled(total: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """Sums of a design over the rows of windows but the first."""
    found: np.ndarray = total[windows[:, 1]] - total[windows[:, 0]]
    return found


def _travel(frame: Frame, windows: np.ndarray) -> np.ndarray:
    """How far the joint moves in windows."""
    return _travelled(frame.signals[:, -1], windows)


def _fitted(frame: Frame, total: np.ndarray, windows: np.ndarray, stretch: np.ndarray, n_own: int) -> np.ndarray:
    """Coefficients with which the travel in windows fits best, in absolute errors where these are large; (n_term,).

    Each stretch of rows, by its number in `stretch` (n_row,), has strengths of its own, whose mean is one.
    """
    design, travel = _travelled(total, windows), _travel(frame, windows)
    places = frame.signals[windows.ravel(), -1]
    scale = _SCALE * float(np.ptp(places)) + 1e-300 if len(places) else 1.0
    of = stretch[windows[:, 0]]
    opening = np.arange(total.shape[1]) % n_own
    weight, strength = np.ones(len(travel)), np.ones((int(of.max(initial=0)) + 1, n_own))
    coef = np.zeros(total.shape[1])
    held = np.full(total.shape[1], _RIDGE)
    held[:n_own] = _OWN_RIDGE
    for _ in range(_REWEIGHED):
        stronger = design * strength[of][:, opening]
        weighed = stronger * weight[:, None]
        gram = weighed.T @ stronger
        size = float(np.diagonal(gram)[:n_own].mean()) + 1e-12
        coef = np.linalg.solve(gram + size * np.diag(held), weighed.T @ travel)
        weight = 1.0 / np.sqrt(1.0 + ((stronger @ coef - travel) / scale) ** 2)
        by_opening = np.column_stack([(design * coef)[:, opening == k].sum(axis=1) for k in range(n_own)])
        strength = _strengths(by_opening, travel, weight, of, (_TO_ONE / _SCALE * scale) ** 2)
    return coef


def _strengths(
    by_opening: np.ndarray, travel: np.ndarray, weight: np.ndarray, of: np.ndarray, ridge: float
) -> np.ndarray:
    """How much further each opening moves the joint in each stretch than a rate says, over that of all stretches; (n_stretch, n_opening)."""
    n_own = by_opening.shape[1]
    found, share = np.ones((2, int(of.max(initial=0)) + 1, n_own))
    for n in range(len(found)):
        own = by_opening[of == n]
        weighed = own * weight[of == n, None]
        gram, right = weighed.T @ own + ridge * np.eye(n_own), weighed.T @ travel[of == n] + ridge
        found[n] = np.clip(np.linalg.solve(gram, right), WEAKEST, STRONGEST)
        share[n] = np.abs(own).sum(axis=0)
    mean = (found * share).sum(axis=0) / np.maximum(share.sum(axis=0), 1e-300)
    return np.asarray(found / np.where(mean > 0.0, mean, 1.0))
