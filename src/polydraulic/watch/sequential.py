"""Sequential tests: for each direction, and each way that it goes, the evidence for a fault since it may have begun (CUSUM, Page 1954).

The evidence of a block is the logarithm of the likelihood ratio between the smallest fault that counts and none; negative sums begin anew. By
Wald's identity the mean time to a false alarm is at least exp(threshold) blocks for each test (Lorden 1971), which gives the threshold for a
stated rate. No block counts for more than a share of the threshold, so that none decides alone.
"""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.watch.expected import Whitened
from polydraulic.watch.kernels.evidence import gather, room_of_evidence


class Limits(NamedTuple):
    """When a test alarms.

    Attributes
    ----------
    threshold : float
        Of the evidence.
    together : (n_direction,) array
        What evidence is divided by.
    slow : (n_direction,) array
        Variance of the offset from one stretch of work to the next.
    ways : (n_direction, 2) array of bool
        Which ways a direction goes: up, down.
    """

    threshold: float
    together: np.ndarray
    slow: np.ndarray
    ways: np.ndarray


class Since(NamedTuple):
    """Sums over the blocks since one: whitened pull and information, squares of pull over information, (n_direction,) each; how many blocks."""

    pull: np.ndarray
    information: np.ndarray
    squares: np.ndarray
    blocks: int


def check_rate(rate: float) -> None:
    """Refuse false alarms per hour that are not above 0."""
    if not 0.0 < rate < np.inf:
        raise InputError(f"rate = {rate:g} false alarms per hour: must be above 0")


def threshold_for(rate: float, tests: int, seconds: float) -> float:
    """Threshold at which so many tests give together at most `rate` false alarms per hour, of blocks of so many seconds.

    Raises
    ------
    InputError
        A rate that is not above 0.
    """
    check_rate(rate)
    return float(np.log(max(tests * 3600.0 / seconds / rate, np.e)))


class EvidenceSums:
    """Evidence of all tests, block by block, in memory that does not grow.

    Parameters
    ----------
    limits : Limits

    Attributes
    ----------
    count : int
        Blocks so far.
    sums : (n_direction, 2) array
    began : (n_direction, 2) array of int
        Block at which each sum began.
    showing : (n_direction,) array
        Evidence that the smallest fault would have given by now.
    """

    def __init__(self, limits: Limits) -> None:
        n = len(limits.together)
        self.limits, self.count = limits, 0
        self._live, self._began = np.zeros(room_of_evidence(n)), np.zeros(2 * n, dtype=np.int64)
        self._down = limits.ways[:, 1].astype(np.int64)
        self.sums, self.began = self._live[: 2 * n].reshape(n, 2), self._began.reshape(n, 2)
        self.showing = self._live[2 * n : 3 * n]

    def add(self, pull: np.ndarray, information: np.ndarray) -> None:
        """Take a block, (n_direction,) each of its whitened scores."""
        limits = self.limits
        self.count += 1
        white = np.concatenate([pull, information])
        gather(
            white, 0, limits.together, limits.slow, self._down, limits.threshold, self.count, self._live, 0, self._began, 0
        )  # fmt: skip

    @property
    def alarms(self) -> np.ndarray:
        """Which tests are beyond their threshold, (n_direction, 2) of bool."""
        return self.sums >= self.limits.threshold


def highest(white: Whitened, limits: Limits) -> np.ndarray:
    """Most evidence that each test gathers over blocks, (n_direction,)."""
    evidence, most = EvidenceSums(limits), np.zeros(len(limits.together))
    for pull, information in zip(*white, strict=True):
        evidence.add(pull, information)
        most = np.maximum(most, evidence.sums.max(axis=1))
    return most
