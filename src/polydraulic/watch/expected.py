"""What is to be expected of a healthy machine: noise of its sensors, errors of its model, and how these go together in time.

The machine of a file is not quite the real one. What healthy blocks show of each fault's direction is taken for an offset that stays, and a jitter from
block to block: a Gaussian model whose two numbers for each direction are found by expectation and maximisation. A fault is then a jitter
that stays.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from polydraulic.watch.directions import Scores
from polydraulic.watch.kernels.scores import room_of_scores, whiten

_PASSES = 30
_FIRST_JITTER, _FIRST_WEIGHT = 0.1, 5.0  # of a direction, before any block is seen, and how many blocks that counts for
_OFFSET = 0.5  # standard deviation of an offset before any block is seen
_TOGETHER = 10  # blocks whose sum tells how far they go together
_FEW_SUMS = 6
_STRETCH, _STRETCHES = 60, 12  # blocks of a stretch at most, and how many there are at least
_RARE = 0.2
_MOST_SLOW = 100.0  # beyond which a direction tells nothing anyway


class Expected(NamedTuple):
    """Learnt from healthy blocks.

    Attributes
    ----------
    noise : dict from column to float
        Standard deviations of white noise, SI.
    scales : tuple of (float, float)
        Of each channel: variance beyond the sensors', and by how much residuals of a block go together.
    offset, jitter : (n_direction,) array
        In sizes that count; jitter as a variance.
    together : (n_direction,) array
        By how much the variance of sums over blocks is larger than if they did not depend on each other.
    slow : (n_direction,) array
        Variance of the offset from one stretch of work to the next, at most; in sizes that count.
    longest : dict from column to int
        Most blocks in succession in which a sensor does not move although its function works.
    blocks : int
        That it was learnt from.
    """

    noise: dict[str, float]
    scales: tuple[tuple[float, float], ...]
    offset: np.ndarray
    jitter: np.ndarray
    together: np.ndarray
    slow: np.ndarray
    longest: dict[str, int]
    blocks: int


class Whitened(NamedTuple):
    """Scores whose variance is their information if the machine is healthy: pull (n_block, n_direction), information the same of each alone."""

    pull: np.ndarray
    information: np.ndarray


def whitened(scores: Scores, offset: np.ndarray, jitter: np.ndarray) -> Whitened:
    """Scores of blocks less what is to be expected, weighted by how well a block tells it from the jitter."""
    n_block, n = scores.pull.shape
    work, found = np.empty(room_of_scores(n)), Whitened(np.empty((n_block, n)), np.empty((n_block, n)))
    for k in range(n_block):
        work[:n], work[n : n + n * n] = scores.pull[k], scores.information[k].ravel()
        whiten(offset, jitter, work, n, 0)
        found.pull[k], found.information[k] = work[n + n * n :][: 2 * n].reshape(2, n)
    return found


def learn_jitter(scores: Scores) -> tuple[np.ndarray, np.ndarray]:
    """Offset and jitter of each direction, (n_direction,) each, from healthy blocks."""
    n_block, n = scores.pull.shape
    offset, jitter = np.zeros(n), np.full(n, _FIRST_JITTER**2)
    for _ in range(_PASSES):
        left = np.eye(n) + scores.information * jitter[None, None, :]
        right = np.concatenate([scores.pull[:, :, None], scores.information], axis=2)
        solved = np.linalg.solve(left, right)
        offset = np.linalg.solve(solved[:, :, 1:].sum(axis=0) + np.eye(n) / _OFFSET**2, solved[:, :, 0].sum(axis=0))
        off = solved[:, :, 0] - solved[:, :, 1:] @ offset  # of what was expected, whitened
        middle = jitter * off
        spread = jitter - jitter * np.einsum("bii->bi", solved[:, :, 1:]) * jitter
        jitter = ((middle**2 + np.maximum(spread, 0.0)).sum(axis=0) + _FIRST_WEIGHT * _FIRST_JITTER**2) / (
            n_block + _FIRST_WEIGHT
        )
    return offset, jitter


def togetherness(white: Whitened) -> np.ndarray:
    """By how much sums over some blocks scatter more than their information says, (n_direction,); at least 1."""
    whole = len(white.pull) // _TOGETHER
    if whole < _FEW_SUMS:
        return np.full(white.pull.shape[1], 2.0)
    pull, information = (part[: whole * _TOGETHER].reshape(whole, _TOGETHER, -1).sum(axis=1) for part in white)
    squares = pull**2 / np.maximum(information, 1e-300)
    counts = information > 0.0
    return np.maximum(np.where(counts, squares, 0.0).sum(axis=0) / np.maximum(counts.sum(axis=0), 1), 1.0)


def slow_variance(white: Whitened, together: np.ndarray) -> np.ndarray:
    """Variance of the offset from one stretch of work to the next, at most, (n_direction,).

    What one log shows of it is little, since stretches are few; so it is not the variance that fits best but the largest that leaves means of
    stretches as even as they are in one case of `_RARE` (limit by Cochran's Q, Viechtbauer 2007). Of a direction that shows in fewer than six
    stretches nothing is learnt, and nothing assumed.
    """
    blocks, n = white.pull.shape
    long = max(_TOGETHER, min(_STRETCH, blocks // _STRETCHES))
    whole = blocks // long
    pull, information = (part[: whole * long].reshape(whole, long, -1).sum(axis=1) for part in white)
    strays = [_strays(pull[:, k], information[:, k], float(together[k])) for k in range(n)]
    return np.minimum(strays, _MOST_SLOW)


def _strays(pull: np.ndarray, information: np.ndarray, together: float) -> float:
    """The same of one direction, from sums over stretches, (n_stretch,)."""
    known = information > 0.0
    degrees = int(known.sum()) - 1
    if degrees < _FEW_SUMS - 1:
        return 0.0
    mean, own = pull[known] / information[known], together / information[known]
    allowed = float(chdtri(degrees, 1.0 - _RARE))

    def uneven(slow: float) -> float:
        weights = 1.0 / (own + slow)
        return float((weights * (mean - (weights @ mean) / weights.sum()) ** 2).sum())

    low, high = 0.0, float(mean.var()) * len(mean) / allowed + 1e-300
    if uneven(low) <= allowed:
        return 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if uneven(middle) > allowed else (low, middle)
    return high
