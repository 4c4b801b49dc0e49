"""What a block says of every direction, and how much of it is news beyond offset and jitter of healthy work."""

from math import inf

import numpy as np

from polydraulic._kernel import driver
from polydraulic.watch.kernels.signals import is_known


@driver
def score(
    ints: np.ndarray, scales: np.ndarray, work: np.ndarray, pull: np.ndarray, information: np.ndarray, s: int
) -> None:
    """Sums of S r / v and S S' / v over all residuals r of a block, of effects S of directions and variances v.

    From `s` on `ints` holds how many channels and where in `work` effects have room; of each channel where residual and variance begin,
    how many they are, how many directions touch it, and of each of those its number and where the residual of its machine begins.
    """
    channels, room, at = ints[s], ints[s + 1], s + 2
    n = pull.shape[0]
    for k in range(n):
        pull[k] = 0.0
    for k in range(n * n):
        information[k] = 0.0
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
                k, weighted = ints[at + 2 * t], work[room + t] / v
                pull[k] += weighted * r
                for u in range(t + 1):
                    information[k * n + ints[at + 2 * u]] += weighted * work[room + u]
        at += 2 * touched
    for k in range(n):
        for j in range(k):
            information[j * n + k] = information[k * n + j]


@driver
def whiten(
    pull: np.ndarray,
    information: np.ndarray,
    offset: np.ndarray,
    jitter: np.ndarray,
    room: np.ndarray,
    white_pull: np.ndarray,
    white_information: np.ndarray,
) -> None:
    """(1 + F J)^-1 (p - F o) and the diagonal of (1 + F J)^-1 F, by elimination with pivots; F is the information, J the jitter, o the offset.

    `room` holds n rows of 2 n + 1 numbers.
    """
    n = pull.shape[0]
    m = 2 * n + 1
    for i in range(n):
        left = pull[i]
        for j in range(n):
            f = information[i * n + j]
            room[i * m + j] = f * jitter[j] + (1.0 if i == j else 0.0)
            room[i * m + n + 1 + j] = f
            left -= f * offset[j]
        room[i * m + n] = left
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            best = i if abs(room[i * m + k]) > abs(room[best * m + k]) else best
        if best != k:
            for j in range(k, m):
                kept = room[k * m + j]
                room[k * m + j] = room[best * m + j]
                room[best * m + j] = kept
        for i in range(k + 1, n):
            share = room[i * m + k] / room[k * m + k]
            if share != 0.0:
                for j in range(k + 1, m):
                    room[i * m + j] -= share * room[k * m + j]
    for back in range(n):
        k = n - 1 - back
        for i in range(k + 1, n):
            share = room[k * m + i]
            if share != 0.0:
                for j in range(n, m):
                    room[k * m + j] -= share * room[i * m + j]
        for j in range(n, m):
            room[k * m + j] = room[k * m + j] / room[k * m + k]
        white_pull[k] = room[k * m + n]
        white_information[k] = max(room[k * m + n + 1 + k], 0.0)
