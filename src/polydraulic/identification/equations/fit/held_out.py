"""Whether a model with one more knot is better where it was not fitted, and not by chance.

Where a knot is missing, few rows may show it, and those by far: the spread of what is saved from block to block would call that chance. What is
chance is the noise that the better model leaves: rows saved `before off` less `after off` of it, of which noise alone makes `after off` times the difference.
"""

import numpy as np

from polydraulic.identification.equations.fit.weighing import HUBER

BETTER = 5e-4  # share of the squares of the rows held out that a knot must save
SURE = 2.0  # standard deviations of what noise may save, by which it must
_PIECES = 10  # of a block, whose rows may err together


def huber(off: np.ndarray) -> np.ndarray:
    """Half the squares of what is left over in standard deviations, those far off counting less."""
    size = np.abs(off)
    return np.asarray(np.where(size <= HUBER, 0.5 * off * off, HUBER * (size - 0.5 * HUBER)))


def surely_better(before: np.ndarray, after: np.ndarray, block: np.ndarray) -> bool:
    """Whether rows held out are nearer to one model than to another by more than noise makes them.

    Parameters
    ----------
    before, after : (n_row,) or (n_row, n) array
        What the models leave over, in standard deviations.
    block : (n_row,) array of int
        Blocks of time.
    """
    saved = float(np.sum(huber(before) - huber(after)))
    by_noise = np.clip(after, -HUBER, HUBER) * (before - after)
    pieces = _pieces_of(block)
    sums = np.bincount(pieces, by_noise.reshape(len(block), -1).sum(axis=1))
    return bool(saved > max(BETTER * float(np.sum(huber(before))), SURE * float(np.linalg.norm(sums))))


def _pieces_of(block: np.ndarray) -> np.ndarray:
    """Number of the piece of each row, (n_row,): each block has so many, of equally many rows."""
    _, number, count = np.unique(block, return_inverse=True, return_counts=True)
    order = np.argsort(number, kind="stable")
    place = np.empty(len(block), dtype=np.int64)
    place[order] = np.arange(len(block)) - np.repeat(np.cumsum(count) - count, count)
    return np.asarray(number * _PIECES + place * _PIECES // count[number])
