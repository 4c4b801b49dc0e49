"""Polynomials of lagged signals that run on their own, and how their answers move with every coefficient.

A term is a coefficient times up to three lagged values. While a run goes on, the derivatives of its answers by the coefficients
go on with it: what a coefficient changes now changes what the polynomial reads later.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.dynamic.refine_free_run import spread
from polydraulic.networks.dynamic.spans import Span, lagged, rows_of

_BATCH = 4_000_000  # derivatives in memory at a time


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


@driver
def _run(
    frame: Frame, terms: Terms, start: np.ndarray, stop: np.ndarray, answers: np.ndarray, slopes: np.ndarray,
    value: np.ndarray, inside: np.ndarray, gain: np.ndarray,
) -> None:  # fmt: skip
    """Answers (n_row, n_output) in windows, and their slopes (n_answered, n_output, n_term) if there is room for them."""
    n_output, n_lag, n_slope = answers.shape[1], frame.column.shape[0], slopes.shape[2]
    first = frame.signals.shape[1] - n_output
    at = 0
    value[0] = 1.0
    for w in range(start.shape[0]):
        for t in range(start[w], stop[w]):
            for i in range(n_lag):
                row, c = t - frame.steps[i], frame.column[i]
                x = answers[row, c - first] if c >= first and row >= start[w] else frame.signals[row, c]
                value[i + 1] = min(max(x, frame.low[i]), frame.high[i])
                inside[i + 1] = value[i + 1] == x
            for k in range(n_output):
                answers[t, k] = 0.0
                for i in range(n_lag + 1):
                    gain[k, i] = 0.0
                for p in range(n_slope):
                    slopes[at, k, p] = 0.0
            for p in range(terms.coef.shape[0]):
                a, b, d, k = terms.factors[p, 0], terms.factors[p, 1], terms.factors[p, 2], terms.output[p]
                product = value[a] * value[b] * value[d]
                if n_slope > 0:
                    slopes[at, k, p] = product
                if terms.coef[p] != 0.0:
                    answers[t, k] += terms.coef[p] * product
                    gain[k, a] += terms.coef[p] * value[b] * value[d]
                    gain[k, b] += terms.coef[p] * value[a] * value[d]
                    gain[k, d] += terms.coef[p] * value[a] * value[b]
            for k in range(n_output):
                for i in range(n_lag):
                    j, back = frame.column[i] - first, frame.steps[i]
                    if n_slope > 0 and j >= 0 and t - back >= start[w] and inside[i + 1] and gain[k, i + 1] != 0.0:
                        for p in range(n_slope):
                            slopes[at, k, p] += gain[k, i + 1] * slopes[at - back, j, p]
                bounded = min(max(answers[t, k], frame.y_low[k]), frame.y_high[k])
                if bounded != answers[t, k]:
                    answers[t, k] = bounded
                    for p in range(n_slope):
                        slopes[at, k, p] = 0.0
            at += 1


def run_terms(
    frame: Frame, terms: Terms, windows: Sequence[Span], *, slopes: bool = True, batch: int = _BATCH
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Errors of runs through windows of rows, and their slopes, some windows at a time.

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
    n_output, n_lag = len(frame.y_low), len(frame.column)
    n_slope = len(terms.coef) if slopes else 0
    measured = frame.signals[:, -n_output:]
    work = np.zeros(n_lag + 1), np.zeros(n_lag + 1, dtype=bool), np.zeros((n_output, n_lag + 1))
    for part in _batches(windows, max(1, batch // max(1, n_slope * n_output))):
        ends = np.array(part, dtype=np.int64)
        rows = np.concatenate([np.arange(a, b) for a, b in part])
        answers, found = measured.copy(), np.zeros((len(rows), n_output, n_slope))
        _run(frame, terms, ends[:, 0].copy(), ends[:, 1].copy(), answers, found, *work)
        yield (answers[rows] - measured[rows]).ravel(), found.reshape(len(rows) * n_output, n_slope)


def _batches(windows: Sequence[Span], n_row: int) -> Iterator[list[Span]]:
    """Windows in groups of at most this many rows, or of one window."""
    group: list[Span] = []
    count = 0
    for a, b in windows:
        if group and count + b - a > n_row:
            yield group
            group, count = [], 0
        group.append((a, b))
        count += b - a
    if group:
        yield group
