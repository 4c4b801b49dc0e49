"""A long signal as few intervals with the smallest and largest value in each: what a picture needs."""

import numpy as np

_MOST = 1500


class Envelope:
    """Intervals of a growing signal; when they are too many, neighbours are merged."""

    def __init__(self) -> None:
        self._each = 1
        self._parts: list[np.ndarray] = [np.zeros((4, 0))]  # first and last time, lowest and highest value
        self._n = 0

    def add(self, time: np.ndarray, value: np.ndarray) -> None:
        """Add samples in order of time."""
        if time.size == 0:
            return
        starts = np.arange(0, len(time), self._each)
        ends = np.minimum(starts + self._each, len(time)) - 1
        self._parts.append(
            np.stack([time[starts], time[ends], np.minimum.reduceat(value, starts), np.maximum.reduceat(value, starts)])
        )
        self._n += len(starts)
        while self._n > _MOST:
            whole = np.concatenate(self._parts, axis=1)
            first, second = whole[:, 0:-1:2], whole[:, 1::2]
            merged = np.stack([first[0], second[1], np.minimum(first[2], second[2]), np.maximum(first[3], second[3])])
            rest = whole[:, -1:] if whole.shape[1] % 2 else whole[:, :0]
            self._parts = [np.concatenate([merged, rest], axis=1)]
            self._n = self._parts[0].shape[1]
            self._each *= 2

    def intervals(self) -> np.ndarray:
        """First and last time, lowest and highest value; shape (4, n)."""
        return np.concatenate(self._parts, axis=1)
