"""Channels with rasters of their own -> rows on one raster, where all of them are known, or any; gaps stay gaps.

A channel is known between two of its samples that lie no more than `JOIN` of its rasters apart: on the line between them, or at the
value of the earlier one. A row of the table exists where every channel is known, of a partial table where any is; rows without a break
between them form a segment.
"""

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import chain, takewhile
from math import inf
from operator import itemgetter

import numpy as np

from polydraulic.measure.checks.channel_check import Samples
from polydraulic.measure.checks.clock import JOIN

_ROWS = 1 << 15  # of one block that is given
_ROUNDING = 1e-6  # of a raster: a sample on the raster stays on it


class Track:
    """One channel's samples that are still needed."""

    def __init__(self, between: str) -> None:
        self.hold = between == "hold"
        self.raster = np.nan
        self.time, self.value = np.zeros(0), np.zeros(0)

    def add(self, samples: Samples, raster: float) -> None:
        """Add samples, which follow those before."""
        self.raster = raster
        self.time = np.concatenate([self.time, samples.time])
        self.value = np.concatenate([self.value, samples.values])

    @property
    def reach(self) -> float:
        """Time that samples may be apart; 0 s while no raster is known."""
        return JOIN * self.raster if np.isfinite(self.raster) else 0.0

    def pieces(self, raster: float, first: int, end: int) -> list[tuple[int, int]]:
        """Spans of places on the table's raster, from `first` to before `end`, where the channel is known."""
        if self.time.size == 0:
            return []
        cuts = np.flatnonzero(np.diff(self.time) > self.reach * (1.0 + _ROUNDING))
        starts = self.time[np.concatenate([[0], cuts + 1])]
        ends = self.time[np.concatenate([cuts, [len(self.time) - 1]])]
        if self.hold and np.isfinite(self.raster):  # the last value before a gap holds for a raster
            ends = ends + self.raster * (1.0 - 1e-3)
        low = np.ceil(np.maximum(starts / raster, first) - _ROUNDING).astype(np.int64)
        high = np.floor(np.minimum(ends / raster, end) + _ROUNDING).astype(np.int64) + 1
        high = np.minimum(high, end)
        return [(a, b) for a, b in zip(low.tolist(), high.tolist(), strict=True) if a < b]

    def at(self, time: np.ndarray, raster: float) -> np.ndarray:
        """Values at times at which the channel is known."""
        if not self.hold:
            return np.interp(time, self.time, self.value)
        place = np.searchsorted(self.time, time + _ROUNDING * raster, side="right") - 1
        return self.value[np.maximum(place, 0)]

    def forget(self, before: float) -> None:
        """Drop samples that no later time needs."""
        place = max(0, int(np.searchsorted(self.time, before, side="right")) - 1)
        self.time, self.value = self.time[place:], self.value[place:]


class Resampler:
    """Rows of the table from the samples of all channels.

    Parameters
    ----------
    raster : float, s
    between : sequence of str
        ``"linear"`` or ``"hold"`` for each channel.
    partial : bool
        Whether rows come in which any channel is known, with NaN for the others.
    """

    def __init__(self, raster: float, between: Sequence[str], *, partial: bool = False) -> None:
        self.raster, self.partial = raster, partial
        self.tracks = [Track(kind) for kind in between]
        self.segment = -1
        self.n_row = 0
        self._next: float = -inf
        self._last = -inf

    def rows(self, until: float) -> Iterator[tuple[np.ndarray, np.ndarray, list[np.ndarray]]]:
        """Time, segment and values of all rows before the time up to which all samples are there.

        Yields
        ------
        time : (n_row,) array, s
        segment : (n_row,) array
        values : list of (n_row,) arrays, one per channel
        """
        if until == -inf:
            return
        begun = [track for track in self.tracks if track.time.size]
        if not begun or (len(begun) < len(self.tracks) and not self.partial):
            for track in self.tracks:  # what has no sample so far is not known before `until`
                track.forget(until)
            return
        starts = [track.time[0] for track in begun]
        earliest = (min if self.partial else max)(starts)
        first = int(max(self._next, np.ceil(earliest / self.raster - _ROUNDING)))
        latest = min(until, max(t.time[-1] for t in begun) + max(t.reach for t in begun))
        end = int(np.floor(latest / self.raster)) + 1
        if end <= first:
            return
        pieces = [track.pieces(self.raster, first, end) for track in self.tracks]
        for begin, stop in _union(pieces) if self.partial else reduce(_overlap, pieces, [(first, end)]):
            self.segment += begin != self._last + 1
            self._last = stop - 1
            for start in range(begin, stop, _ROWS):
                last = min(start + _ROWS, stop)
                time = np.arange(start, last) * self.raster
                self.n_row += len(time)
                yield time, np.full(len(time), float(self.segment)), self._values(time, start, last, pieces)
        self._next = end
        for track in self.tracks:
            track.forget(min(end * self.raster, until))

    def _values(self, time: np.ndarray, start: int, last: int, pieces: list[list[tuple[int, int]]]) -> list[np.ndarray]:
        """Values of all channels at rows from `start` to before `last`, NaN where one is not known."""
        if not self.partial:
            return [track.at(time, self.raster) for track in self.tracks]
        found = []
        for track, own in zip(self.tracks, pieces, strict=True):
            values = np.full(len(time), np.nan)
            behind = bisect_right(own, start, key=itemgetter(1))  # pieces that end before
            for begin, stop in takewhile(lambda piece: piece[0] < last, own[behind:]):
                inside = slice(max(begin - start, 0), min(stop, last) - start)
                values[inside] = track.at(time[inside], self.raster)
            found.append(values)
        return found


def _union(lists: list[list[tuple[int, int]]]) -> list[tuple[int, int]]:
    """Spans that any of some rising lists covers."""
    found: list[tuple[int, int]] = []
    for low, high in sorted(chain.from_iterable(lists)):
        if found and low <= found[-1][1]:
            found[-1] = (found[-1][0], max(high, found[-1][1]))
        else:
            found.append((low, high))
    return found


def _overlap(a: list[tuple[int, int]], b: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Where spans of two rising lists overlap."""
    found, i, j = [], 0, 0
    while i < len(a) and j < len(b):
        low, high = max(a[i][0], b[j][0]), min(a[i][1], b[j][1])
        if low < high:
            found.append((low, high))
        if a[i][1] < b[j][1]:
            i += 1
        else:
            j += 1
    return found
