"""Rows that follow each other without a gap: spans of a log, blocks of them, and lagged signals at their rows."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from polydraulic.errors import InputError

Span = tuple[int, int]  # first row, and the row after the last

_MOST_STRETCHES = 10  # spans that count as stretches of their own
_ABOUT = 0.5  # of the mean length, that each of these has at least


def spans_of(segments: Any, known: np.ndarray) -> list[Span]:
    """Rows that follow each other without a gap.

    Parameters
    ----------
    segments : (n_row,) array-like or None
        A new segment begins where the label changes; None for one segment.
    known : (n_row,) array of bool
        A row that is not known ends a segment, too.
    """
    n = len(known)
    labels = np.zeros(n) if segments is None else np.asarray(segments)
    if labels.shape != (n,):
        raise InputError(f"segments has shape {labels.shape}; it must hold one label for each of the {n} rows")
    begins = np.ones(n, dtype=bool)
    begins[1:] = (labels[1:] != labels[:-1]) | ~known[:-1]
    first = np.flatnonzero(begins & known)
    stops = np.flatnonzero(np.append((begins | ~known)[1:], True) & known) + 1
    return list(zip(first.tolist(), stops.tolist(), strict=True))


def without(spans: Sequence[Span], left_out: Sequence[Span]) -> list[Span]:
    """What is left of `spans` where parts of them are left out."""
    rest = list(spans)
    for low, high in left_out:
        pieces = [piece for a, b in rest for piece in ((a, min(b, low)), (max(a, high), b))]
        rest = [(a, b) for a, b in pieces if a < b]
    return rest


def blocks_of(spans: Sequence[Span], n_block: int) -> list[list[Span]]:
    """Cut rows into `n_block` blocks of equally many rows that follow each other in time."""
    total = sum(b - a for a, b in spans)
    edges = np.linspace(0, total, n_block + 1).astype(int).tolist()
    found: list[list[Span]] = [[] for _ in range(n_block)]
    passed = 0
    for a, b in spans:
        for block, (low, high) in zip(found, pairwise(edges), strict=True):
            begin, end = max(a, a + low - passed), min(b, a + high - passed)
            if begin < end:
                block.append((begin, end))
        passed += b - a
    return found


def stretches_of(spans: Sequence[Span], n_block: int, logs: np.ndarray | None = None) -> list[list[Span]]:
    """Parts of a log that may be of different days: each of several logs, however many gaps it has.

    Of one log these are its spans if they are a few of about the same length, else blocks of them.

    Parameters
    ----------
    spans : sequence of (start, stop)
        None reaches across the end of a log.
    n_block : int
        Blocks of equally many rows, where spans of one log are one, many, or of very different lengths.
    logs : (n_row,) array, optional
        Which log each row is of; one log if not given.
    """
    if logs is not None:
        of_log: dict[Any, list[Span]] = {}
        for span in spans:
            of_log.setdefault(logs[span[0]], []).append(span)
        if len(of_log) > 1:
            return list(of_log.values())
    sizes = [b - a for a, b in spans]
    if 1 < len(spans) <= _MOST_STRETCHES and min(sizes) * len(spans) >= _ABOUT * sum(sizes):
        return [[span] for span in spans]
    return blocks_of(spans, n_block)


def answered(spans: Sequence[Span], warm_up: int) -> list[Span]:
    """Spans without their first rows, which a model only reads."""
    return [(a + warm_up, b) for a, b in spans if a + warm_up < b]


def rows_of(spans: Sequence[Span]) -> np.ndarray:
    """Numbers of all rows of spans."""
    return np.concatenate([np.zeros(0, dtype=np.int64), *(np.arange(a, b) for a, b in spans)])


def lagged(signals: np.ndarray, reads: Sequence[tuple[int, int]], rows: np.ndarray) -> np.ndarray:
    """Regressors at some rows: columns of `signals` this many steps ago, from pairs (column, steps); (n_row, n_lag)."""
    return np.column_stack([signals[rows - steps, column] for column, steps in reads])
