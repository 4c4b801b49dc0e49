"""What a block says of every direction, and how much of it is news beyond offset and jitter of healthy work.

Scores stand in `work` one behind the other: pull and information of all directions together, then whitened pull and information of each alone,
and room for their elimination.
"""

from math import inf

import numpy as np

from polydraulic._kernel import driver
from polydraulic.watch.kernels.signals import is_known


def room_of_scores(n: int) -> int:
    """Numbers that scores of n directions take, with room for elimination or, after it, for a diagnosis."""
    return 3 * n + n * n + max(n * (2 * n + 1), 4 * n)


@driver
def score(ints: np.ndarray, scales: np.ndarray, work: np.ndarray, n: int, at_scores: int, s: int) -> None:
    """Sums of S r / v and S S' / v over all residuals r of a block, of effects S of n directions and variances v.

    From `s` on `ints` holds how many channels and where in `work` effects have room; of each channel where residual and variance begin,
    how many they are, how many directions touch it, and of each of those its number and where the residual of its machine begins.
    """
    channels, room, at = ints[s], ints[s + 1], s + 2
    pull, information = at_scores, at_scores + n
    for k in range(n + n * n):
        work[pull + k] = 0.0
    for channel in range(channels):
        own, variance, count, touched = ints[at], ints[at + 1], ints[at + 2], ints[at + 3]
        at += 4
        more, together = scales[2 * channel], scales[2 * channel + 1]
        for i in range(count):
            r, v = work[own + i], (work[variance + i] + more) * together
            fine = v < inf and is_known(r)
            for t in range(touched):
                effect = r - work[ints[at + 2 * t + 1] + i]
                work[room + t] = effect
                fine = fine and is_known(effect)
            if not fine:
                continue
            for t in range(touched):
                k_own, weighted = ints[at + 2 * t], work[room + t] / v
                work[pull + k_own] += weighted * r
                for u in range(t + 1):
                    work[information + k_own * n + ints[at + 2 * u]] += weighted * work[room + u]
        at += 2 * touched
    for k in range(n):
        for j in range(k):
            work[information + j * n + k] = work[information + k * n + j]


@driver
def whiten(offset: np.ndarray, jitter: np.ndarray, work: np.ndarray, n: int, at_scores: int) -> None:
    """(1 + F J)^-1 (p - F o) and the diagonal of (1 + F J)^-1 F, by elimination with pivots.

    F is the information, p the pull, J the jitter, o the offset; of n rows of 2 n + 1 numbers.
    """
    m = 2 * n + 1
    information, white = at_scores + n, at_scores + n + n * n
    room = white + 2 * n
    for i in range(n):
        left = work[at_scores + i]
        for j in range(n):
            f = work[information + i * n + j]
            work[room + i * m + j] = f * jitter[j] + (1.0 if i == j else 0.0)
            work[room + i * m + n + 1 + j] = f
            left -= f * offset[j]
        work[room + i * m + n] = left
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            best = i if abs(work[room + i * m + k]) > abs(work[room + best * m + k]) else best
        if best != k:
            for j in range(k, m):
                kept = work[room + k * m + j]
                work[room + k * m + j] = work[room + best * m + j]
                work[room + best * m + j] = kept
        for i in range(k + 1, n):
            share = work[room + i * m + k] / work[room + k * m + k]
            if share != 0.0:
                for j in range(k + 1, m):
                    work[room + i * m + j] -= share * work[room + k * m + j]
    # of the matrix that is solved for only the diagonal is asked for, and of each row what that takes: columns up to its own
    for back in range(n):
        last = n - 1 - back
        asked = n + 2 + last
        for i in range(last + 1, n):
            factor = work[room + last * m + i]
            if factor != 0.0:
                for j in range(n, asked):
                    work[room + last * m + j] -= factor * work[room + i * m + j]
        for j in range(n, asked):
            work[room + last * m + j] = work[room + last * m + j] / work[room + last * m + last]
        work[white + last] = work[room + last * m + n]
        work[white + n + last] = max(work[room + last * m + n + 1 + last], 0.0)
