"""Polynomials of lagged signals that run on their own, and how their answers move with every coefficient.

A term is a coefficient times up to three lagged values. While a run goes on, the derivatives of its answers by the coefficients
go on with it: what a coefficient changes now changes what the polynomial reads later. Windows run side by side, so that all arithmetic is
along lanes, one for each window.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.dynamic.refine_free_run import spread
from polydraulic.networks.dynamic.spans import Span, lagged, rows_of

_BATCH = 4_000_000  # derivatives in memory at a time
# windows side by side at most; with more slopes than this, which then stay in the cache
_LANES, _FEW_LANES, _MANY_SLOPES = 64, 16, 64


class Frame(NamedTuple):
    """Signals of a log in normalized units, and what polynomials may read of them."""

    signals: np.ndarray  # (n_row, n_signal), inputs first, then the outputs
    column: np.ndarray  # (n_lag,) int64: signal of each lagged value
    steps: np.ndarray  # (n_lag,) int64: and how long ago
    low: np.ndarray  # (n_lag,) lagged values are moved into their range
    high: np.ndarray
    y_low: np.ndarray  # (n_output,) and so are answers
    y_high: np.ndarray
    mean: np.ndarray  # (n_signal,) in their own units
    scale: np.ndarray


def frame_of(
    signals: np.ndarray,
    n_output: int,
    reads: Sequence[tuple[int, int]],
    spans: Sequence[Span],
    margin: float,
    *,
    n_raw: int = 0,
) -> Frame:
    """Signals normalized by what rows to answer hold.

    Parameters
    ----------
    signals : (n_row, n_signal) array
        Inputs, then outputs.
    n_output : int
    reads : sequence of (column, steps)
        Lagged values that may be read.
    spans : sequence of (start, stop)
        Rows to answer; as many rows as the longest lag stand before each start.
    margin : float
        Share of their range, by which answers may leave it.
    n_raw : int
        So many of the first signals stay as they are.
    """
    rows = rows_of(spans)
    mean, scale = signals[rows].mean(axis=0), spread(signals[rows])
    mean[:n_raw], scale[:n_raw] = 0.0, 1.0
    normal = (signals - mean) / scale
    read, y = lagged(normal, reads, rows), normal[rows, -n_output:]
    wider = margin * np.ptp(y, axis=0)
    column, steps = np.array(reads, dtype=np.int64).T.copy()
    return Frame(
        normal, column, steps, read.min(axis=0), read.max(axis=0), y.min(axis=0) - wider, y.max(axis=0) + wider,
        mean, scale,
    )  # fmt: skip


class Terms(NamedTuple):
    """Terms of all outputs."""

    factors: np.ndarray  # (n_term, 3) int64: 1 + place of a lagged value, largest first; 0 is no factor
    output: np.ndarray  # (n_term,) int64: of which output's polynomial
    coef: np.ndarray  # (n_term,)

    def and_also(self, factors: np.ndarray, output: np.ndarray) -> "Terms":
        """Return these and more terms, with coefficients of zero."""
        return Terms(
            np.vstack([self.factors, factors]),
            np.append(self.output, output),
            np.append(self.coef, np.zeros(len(output))),
        )


def averaged(members: Sequence[Terms], weights: np.ndarray) -> Terms:
    """The mean of polynomials, which is a polynomial."""
    total: dict[tuple[int, ...], float] = {}
    for terms, weight in zip(members, (weights / weights.sum()).tolist(), strict=True):
        for *factors, k, coef in zip(
            *terms.factors.T.tolist(), terms.output.tolist(), terms.coef.tolist(), strict=True
        ):
            total[k, *factors] = total.get((k, *factors), 0.0) + weight * coef
    keys = np.array(sorted(total), dtype=np.int64)
    return Terms(keys[:, 1:].copy(), keys[:, 0].copy(), np.array([total[key] for key in sorted(total)]))


class Links(NamedTuple):
    """How outputs follow from earlier ones: what polynomials with coefficients read of outputs, once each."""

    output: np.ndarray  # (n_link,) int64: whose polynomial reads
    lag: np.ndarray  # (n_link,) int64: which lagged value
    of_factor: np.ndarray  # (n_term, 3) int64: link of each factor, -1 where it is none
    reached: np.ndarray  # (n_output, n_output) bool: whether a term of the first output moves the second one


def _links(frame: Frame, terms: Terms) -> Links:
    n_output = len(frame.y_low)
    first = frame.signals.shape[1] - n_output
    found: dict[tuple[int, int], int] = {}
    of_factor = np.full(terms.factors.shape, -1, dtype=np.int64)
    reached = np.eye(n_output, dtype=np.bool_)
    for p in np.flatnonzero(terms.coef).tolist():
        k = int(terms.output[p])
        for place, factor in enumerate(terms.factors[p].tolist()):
            if factor and (j := int(frame.column[factor - 1]) - first) >= 0:
                of_factor[p, place] = found.setdefault((k, factor - 1), len(found))
                reached[j, k] = True
    for _ in range(n_output):  # what moves an output that moves another moves that one, too
        reached = (reached.astype(np.int64) @ reached) > 0
    pairs = np.array(list(found), dtype=np.int64).reshape(-1, 2)
    return Links(pairs[:, 0].copy(), pairs[:, 1].copy(), of_factor, reached)


def _read_only(frame: Frame, terms: Terms) -> tuple[Frame, Terms]:
    """The frame without lagged values that no term reads."""
    used = np.unique(terms.factors[terms.factors > 0]) - 1
    if len(used) == len(frame.column):
        return frame, terms
    place = np.zeros(len(frame.column) + 1, dtype=np.int64)
    place[used + 1] = 1 + np.arange(len(used))
    lags = {name: getattr(frame, name)[used] for name in ("column", "steps", "low", "high")}
    return frame._replace(**lags), terms._replace(factors=place[terms.factors])


@driver
def _run(
    frame: Frame, terms: Terms, links: Links, start: np.ndarray, stop: np.ndarray, block: np.ndarray, errors: np.ndarray,
    slopes: np.ndarray, value: np.ndarray, inside: np.ndarray, gain: np.ndarray, kept: np.ndarray,
) -> None:  # fmt: skip
    """Errors (n_step, n_output, n_lane) in windows side by side, and their slopes (n_term, n_step, n_output, n_lane) if there is room.

    `block` (n_before + n_step, n_signal, n_lane) holds the signals of each window, in which answers take the place of measured outputs.
    After the end of a window its errors and slopes are zero.
    """
    n_step, n_output, n_lane = errors.shape
    n_lag, n_slope, n_link, n_signal = frame.column.shape[0], slopes.shape[0], links.lag.shape[0], block.shape[1]
    first, before = n_signal - n_output, block.shape[0] - n_step
    for lane in range(n_lane):
        last = max(stop[lane] - 1, start[lane])
        for r in range(block.shape[0]):
            row = min(start[lane] - before + r, last)
            for c in range(n_signal):
                block[r, c, lane] = frame.signals[row, c]
    value[0] = 1.0
    for s in range(n_step):
        for i in range(n_lag):
            read, v, free = block[before + s - frame.steps[i], frame.column[i]], value[i + 1], inside[i]
            low, high = frame.low[i], frame.high[i]
            for lane in range(n_lane):
                x = read[lane]
                v[lane] = min(max(x, low), high)
                free[lane] = 1.0 if v[lane] == x else 0.0
        for n in range(n_link):
            own = gain[n]
            for lane in range(n_lane):
                own[lane] = 0.0
        for k in range(n_output):
            answer = errors[s, k]
            for lane in range(n_lane):
                answer[lane] = 0.0
        for p in range(terms.coef.shape[0]):
            k, coef = terms.output[p], terms.coef[p]
            a, b, d = value[terms.factors[p, 0]], value[terms.factors[p, 1]], value[terms.factors[p, 2]]
            if n_slope > 0:
                for other in range(n_output):
                    if other != k:
                        slope = slopes[p, s, other]
                        for lane in range(n_lane):
                            slope[lane] = 0.0
                slope = slopes[p, s, k]
                for lane in range(n_lane):
                    slope[lane] = a[lane] * b[lane] * d[lane]
            if coef != 0.0:
                answer = errors[s, k]
                for lane in range(n_lane):
                    answer[lane] += coef * (a[lane] * b[lane] * d[lane])
                if links.of_factor[p, 0] >= 0:
                    own = gain[links.of_factor[p, 0]]
                    for lane in range(n_lane):
                        own[lane] += coef * b[lane] * d[lane]
                if links.of_factor[p, 1] >= 0:
                    own = gain[links.of_factor[p, 1]]
                    for lane in range(n_lane):
                        own[lane] += coef * a[lane] * d[lane]
                if links.of_factor[p, 2] >= 0:
                    own = gain[links.of_factor[p, 2]]
                    for lane in range(n_lane):
                        own[lane] += coef * a[lane] * b[lane]
        if n_slope > 0:
            for n in range(n_link):
                i, k = links.lag[n], links.output[n]
                j, back = frame.column[i] - first, frame.steps[i]
                if s >= back:
                    own, free = gain[n], inside[i]
                    for lane in range(n_lane):
                        own[lane] *= free[lane]
                    for p in range(n_slope):
                        if links.reached[terms.output[p], j]:
                            slope, earlier = slopes[p, s, k], slopes[p, s - back, j]
                            for lane in range(n_lane):
                                slope[lane] += own[lane] * earlier[lane]
        for k in range(n_output):
            answer, measured = errors[s, k], block[before + s, first + k]
            low, high = frame.y_low[k], frame.y_high[k]
            n_kept = 0
            for lane in range(n_lane):
                bounded, running = min(max(answer[lane], low), high), s < stop[lane] - start[lane]
                kept[lane] = 1 if running and bounded == answer[lane] else 0
                n_kept += kept[lane]
                answer[lane] = bounded - measured[lane] if running else 0.0
                measured[lane] = bounded
            if n_kept < n_lane:
                for p in range(n_slope):
                    slope = slopes[p, s, k]
                    for lane in range(n_lane):
                        slope[lane] = slope[lane] if kept[lane] else 0.0


def run_side_by_side(
    frame: Frame, terms: Terms, windows: Any, *, slopes: bool = True, batch: int = _BATCH
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Errors of runs through windows of rows, and their slopes, some windows at a time; parameters as `run_terms`.

    Yields
    ------
    errors : (n_step, n_output, n_lane) array
        Answers less what was measured; zero after the end of a window, and in lanes without one.
    slopes : (n_term, n_step, n_output, n_lane) array
        Derivatives of the errors by the coefficients; none if not needed.
    """
    frame, terms = _read_only(frame, terms)
    links = _links(frame, terms)
    n_output, n_lag, n_signal = len(frame.y_low), len(frame.column), frame.signals.shape[1]
    n_slope, before = len(terms.coef) if slopes else 0, int(frame.steps.max(initial=0))
    ends = np.asarray(windows, dtype=np.int64).reshape(-1, 2)
    longest = int((ends[:, 1] - ends[:, 0]).max(initial=1))
    most = _LANES if n_slope <= _MANY_SLOPES else _FEW_LANES
    n_lane = min(most, max(1, batch // (max(1, n_slope) * n_output * longest)), len(ends))
    value, inside, gain = (np.zeros((n, n_lane)) for n in (n_lag + 1, n_lag, len(links.lag)))
    kept = np.zeros(n_lane, dtype=np.int64)
    for at in range(0, len(ends), n_lane):
        part = np.repeat(ends[at : at + 1, :1], n_lane, axis=0).repeat(2, axis=1)  # lanes without a window have no rows
        part[: len(ends) - at] = ends[at : at + n_lane]
        start, stop = np.ascontiguousarray(part.T)
        n_step = int((stop - start).max())
        block = np.empty((before + n_step, n_signal, n_lane))
        errors, found = np.empty((n_step, n_output, n_lane)), np.empty((n_slope, n_step, n_output, n_lane))
        _run(frame, terms, links, start, stop, block, errors, found, value, inside, gain, kept)
        yield errors, found


def run_terms(
    frame: Frame, terms: Terms, windows: Sequence[Span], *, slopes: bool = True, batch: int = _BATCH
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Errors of runs through windows of rows, and their slopes, window after window, some at a time.

    Parameters
    ----------
    frame : Frame
    terms : Terms
    windows : sequence of (start, stop)
        Each begins from measured outputs and goes on by itself.
    slopes : bool
        Whether they are needed.
    batch : int
        Derivatives in memory at a time; one window at least.

    Yields
    ------
    errors : (n,) array
        Answers less what was measured, all outputs of a row after each other.
    slopes : (n, n_term) array
        Derivatives of the errors by the coefficients; (n, 0) if not needed.
    """
    left, n_output = list(windows), len(frame.y_low)
    for errors, found in run_side_by_side(frame, terms, windows, slopes=slopes, batch=batch):
        lanes, left = left[: errors.shape[2]], left[errors.shape[2] :]
        rows = [(slice(b - a), slice(None), lane) for lane, (a, b) in enumerate(lanes)]
        by_window = [
            np.moveaxis(found[:, *own], 0, 2).reshape((b - a) * n_output, len(found))
            for own, (a, b) in zip(rows, lanes, strict=True)
        ]
        yield np.concatenate([errors[own].ravel() for own in rows]), np.concatenate(by_window)
