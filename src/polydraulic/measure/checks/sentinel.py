"""A sentinel: one number far beyond all others that comes again and again, as loggers write where they have no value."""

from math import inf

import numpy as np

FAR = 3.0  # ranges of the other values that it must lie away from them
_LEAST = 2  # times that it must come
_KEPT = 1000  # rows


class Sentinels:
    """Looks for the number at both ends of a growing signal; 0 is none, since signals rest there."""

    def __init__(self) -> None:
        self._ends = (_End(1.0), _End(-1.0))

    def add(self, value: np.ndarray, rows: np.ndarray) -> None:
        """Add samples and the rows that they stand in."""
        if value.size:
            for end in self._ends:
                end.add(value, rows)

    def found(self) -> list[tuple[float, int, np.ndarray]]:
        """Numbers, how often each came, and the first rows that they stand in."""
        top, bottom = self._ends
        width = top.second + bottom.second  # of what lies between both ends
        return [
            (end.side * end.first, end.count, np.concatenate(end.rows)[:_KEPT])
            for end in self._ends
            if 0.0 < width < inf and end.count >= _LEAST and end.first != 0.0 and end.first - end.second > FAR * width
        ]


class _End:
    """The outermost number of one side, how often it came, and the outermost of all others; both times `side`."""

    def __init__(self, side: float) -> None:
        self.side, self.first, self.second, self.count = side, -inf, -inf, 0
        self.rows: list[np.ndarray] = []

    def add(self, value: np.ndarray, rows: np.ndarray) -> None:
        best = self.side * float(value.max() if self.side > 0.0 else value.min())
        if best < self.first:
            self.second = max(self.second, best)
            return
        there = value == self.side * best
        others = self.side * value[~there]
        self.second = max(self.second, float(others.max(initial=-inf)), self.first if best > self.first else -inf)
        if best > self.first:
            self.first, self.count, self.rows = best, 0, []
        self.count += int(there.sum())
        if sum(map(len, self.rows)) < _KEPT:
            self.rows.append(rows[there])
