"""Angles whose sensors begin anew after a full turn, as motions that go on: between 359 and 1 degrees lies no 180."""

import numpy as np

_JUMP = 0.75  # of a turn, from one sample to the next: no joint goes as far
_ONE = 1.01  # of a turn: what reads more than one does not begin anew after it


class Turns:
    """Continues the readings of one angle, block by block.

    Parameters
    ----------
    turn : float
        A full turn in the unit of the readings.
    """

    def __init__(self, turn: float) -> None:
        self.turn = turn
        self._low, self._high, self._last, self._whole = np.inf, -np.inf, np.nan, 0.0

    def add(self, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Readings that go on, and places of those that began anew, both of (n_row,) readings in order of time."""
        if value.size == 0:
            return value, np.zeros(0, dtype=np.int64)
        self._low, self._high = min(self._low, float(value.min())), max(self._high, float(value.max()))
        step = np.diff(value, prepend=self._last)
        self._last = float(value[-1])
        anew = np.flatnonzero(np.abs(step) > _JUMP * self.turn)
        if self._high - self._low > _ONE * self.turn:
            return value + self.turn * self._whole, anew[:0]
        whole = np.zeros(len(value))
        whole[anew] = -np.sign(step[anew])
        whole = self._whole + np.cumsum(whole)
        self._whole = float(whole[-1])
        return value + self.turn * whole if self._whole or anew.size else value, anew
