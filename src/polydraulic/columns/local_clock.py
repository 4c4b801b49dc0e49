"""Times of local clocks as times that go on: past midnight, past twelve o'clock, and where the clock was changed by an hour."""

from typing import Protocol

import numpy as np

from polydraulic.columns.timestamps import DAY

HOUR = 3600.0  # s
_NEAR = 60.0  # s that a change by an hour may be off: rows are missing, too
_HALF = 0.5 * DAY  # s: a clock of twelve hours that does not say which half of the day falls by it at one o'clock
_FALL = 1.5 * HOUR  # from which on a time of day that falls, and stays there, is one of the next day


class Notes(Protocol):
    """Where things that are wrong with rows are noted."""

    def add(self, kind: str, channel: str = "", detail: str = "") -> object:
        """Note something that is not about single rows."""
        ...

    def add_rows(self, kind: str, channel: str, rows: np.ndarray, detail: str = "") -> None:
        """Note rows (their numbers, rising)."""
        ...

    def expect(self, kind: str, channel: str, detail: str) -> None:
        """Keep the detail of a finding that may come."""
        ...


class LocalClock:
    """Continues local times, block by block.

    Parameters
    ----------
    name : str
        Of the column, for notes.
    of_day : bool
        Times of day, without a date.
    notes : Notes
    """

    def __init__(self, name: str, of_day: bool, notes: Notes) -> None:
        self.name, self.of_day, self.notes = name, of_day, notes
        self._past = np.full(2, np.nan)
        self._shift = 0.0

    def times(self, given: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Seconds that go on where the clock was changed or passed midnight; a row that is off alone stays as it is."""
        place = np.flatnonzero(np.isfinite(given))
        if place.size == 0:
            return given
        t = given[place]
        past = np.concatenate([self._past, t])
        before, earlier = past[1:-1], past[:-2]
        after = np.concatenate([t[1:], t[-1:]])  # of the last row nothing is known yet
        self._past = past[-2:]
        fall, stays = before - t, before - after
        falls = (fall > _FALL) & (stays > _FALL)
        half = falls & (np.abs(fall - _HALF) < _NEAR) & (before % DAY >= _HALF) & (before % DAY < _HALF + HOUR)
        midnight = self.of_day & falls & ~half & (before < DAY)
        back = (np.abs(fall - HOUR) < _NEAR) & (stays > 0.5 * HOUR) & (stays < _FALL)
        ahead = (np.abs(fall + HOUR) < _NEAR) & (after - before > 0.5 * HOUR) & ~(t - earlier < 0.5 * HOUR)
        self.notes.add_rows("midnight", self.name, rows[place[midnight]])
        told = "12:59 is followed by 01:00, and no AM or PM says which half of the day it is: taken to go on"
        self.notes.add_rows("twelve hours", self.name, rows[place[half]], told)
        told = "set back by an hour: what follows is taken an hour later"
        self.notes.add_rows("clock change", self.name, rows[place[back]], told)
        told = "an hour ahead: the clock was changed, or an hour is missing; it stays a gap"
        self.notes.add_rows("clock change", self.name, rows[place[ahead]], told)
        steps = np.where(midnight, DAY, 0.0) + np.where(half, _HALF, 0.0) + np.where(back, HOUR, 0.0)
        found = given.copy()
        found[place] = t + self._shift + np.cumsum(steps)
        self._shift += float(steps.sum())
        return found
