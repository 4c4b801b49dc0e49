"""Rows that are held out: drawn at random, or every fifth row or block of time.

Neighbours in time are not independent, so that of a log whole blocks are held out.
"""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from sklearn.utils import check_random_state

from polydraulic.errors import InputError

FOLD = 5  # one of so many rows, or blocks of time, is held out
BLOCKS = 20  # of a log, at least: four of them are held out

_MIX = np.uint64(0x9E3779B97F4A7C15)  # odd, and without a pattern in its bits

T = TypeVar("T")


def drawn_rows(n: int, n_held: int, random_state: Any) -> tuple[np.ndarray, np.ndarray]:
    """Rows to learn from, (n - n_held,), and rows to hold out, (n_held,), of `n`, in the order in which they were drawn."""
    order = check_random_state(random_state).permutation(n)
    return order[n_held:], order[:n_held]


def calibration_rows(n: int, share: float, random_state: Any) -> tuple[np.ndarray, np.ndarray]:
    """Rows to learn from, and rows to hold out for intervals, of `n`; both in rising order.

    Raises
    ------
    InputError
        If the share is none.
    """
    if not 0.0 <= share < 1.0:
        raise InputError(f"calibration = {share!r}: must be a share of the rows, at least 0 and below 1")
    held = round(share * n)
    if not held:
        return np.arange(n), np.arange(0)
    learn, hold = drawn_rows(n, held, random_state)
    return np.sort(learn), np.sort(hold)


def held_rows(n: int, blocks: int | None = None, parts: Sequence[int] | None = None) -> np.ndarray:
    """Which of `n` rows are held out, (n,) array of bool: every fifth row, or every fifth of about `blocks` blocks.

    Parameters
    ----------
    n : int
    blocks : int, optional
    parts : sequence of int, optional
        Numbers of rows, `n` in all, of tables that no block goes beyond.
    """
    if blocks is None:
        place = np.arange(n)
    else:
        parts = [n] if parts is None else parts
        counts = blocks_of_parts(blocks, parts)
        before = np.cumsum([0, *counts])
        place = np.concatenate(
            [
                first + np.arange(rows) * count // max(rows, 1)
                for first, rows, count in zip(before, parts, counts, strict=False)
            ]
        )
    return np.asarray(place % FOLD == FOLD - 1)


def held_distinct_rows(values: np.ndarray, fewest: int) -> np.ndarray:
    """Which rows are held out, (n,) array of bool: every fifth of the rows that differ, with all its copies.

    A row that is learnt from says nothing of its copy.

    Parameters
    ----------
    values : (n, n_column) array
        All that is known of the rows.
    fewest : int
        Rows that differ and are not held out: with fewer nothing is learnt, and what is held out would judge another model.

    Raises
    ------
    InputError
        If fewer than `fewest` would be left to learn from, or fewer than two be held out.
    """
    bits = (np.asarray(values, dtype=np.float64) + 0.0).view(np.uint64)  # without a negative zero
    mixed = np.zeros(len(bits), dtype=np.uint64)
    for column in bits.T:
        mixed = (mixed ^ (mixed >> np.uint64(29)) ^ column) * _MIX
    _, first, copy_of = np.unique(mixed, return_index=True, return_inverse=True)
    least = max(2 * FOLD, fewest + (fewest - 1) // (FOLD - 1))
    if len(first) < least:
        differ = "" if len(first) == len(bits) else f", of which {len(first)} differ"
        raise InputError(f"the table has {len(bits)} rows{differ}; fitting and holding out takes {least} or more")
    number = np.argsort(np.argsort(first))  # in the order in which they come
    return np.asarray(number[copy_of] % FOLD == FOLD - 1)


def blocks_of_parts(blocks: int, parts: Sequence[int]) -> list[int]:
    """Into how many blocks each part is cut: by its rows, one at least."""
    total = max(sum(parts), 1)
    return [max(1, round(blocks * rows / total)) for rows in parts]


def held_blocks(blocks: Sequence[T]) -> list[T]:
    """Every fifth of blocks of rows."""
    return list(blocks[FOLD - 1 :: FOLD])
