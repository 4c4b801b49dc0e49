"""The clock of a log: rows in the order of their times, and all that is wrong with these."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import LogBlock

JOIN = 2.5  # samples at most so many rasters apart belong together; farther apart is a gap
_IRREGULAR = 0.25  # of the raster
_SHARE = 0.01  # of the intervals that may be irregular
_FROM, _TO = 315_532_800.0, 4_102_444_800.0  # s since 1970: 1980 and 2100
_DAY = 86_400.0  # s
_ZEROS = (25_569.0, 719_529.0, 2_440_587.5)  # days before 1970 from which spreadsheets, MATLAB and astronomers count
_BEFORE = -86_400.0  # s: more than a day before the zero of a clock that is none of dates
_FAR = 1e12  # s: beyond it no rows can be counted
_OTHER = 0.2  # difference of rasters that is worth a word
_MOST_ROWS = 1e4  # of a table between two samples: us read as s make a million, which fill a disk
# numbers after which counters begin anew: of 16, 24 and 32 bits, and of us and ms in 32 bits as larger units
_COUNTERS = (2.0**16, 2.0**24, 2.0**32, 2.0**32 / 1e3, 2.0**32 / 1e6)
_FALLING = 0.5  # share of the steps of a log that runs backwards
_ANOTHER_UNIT = 500.0  # times the raster of a table, or that part of it: s and ms are a thousand apart


class ClockedRows(NamedTuple):
    """Rows of a block whose times rise.

    Attributes
    ----------
    rows : (n_row,) array of int
    time : (n_row,) array, s
    values : dict from name to (n_row,) array
    text : dict from name to (n_row,) array of bool
    after_gap : (n_row,) array of bool
        Whether more than `JOIN` rasters lie before the row.
    done : float
    """

    rows: np.ndarray
    time: np.ndarray
    values: dict[str, np.ndarray]
    text: dict[str, np.ndarray]
    after_gap: np.ndarray
    done: float


def day_zero(day: float) -> float:
    """Days before 1970 from which a time in days counts: 0 where it can be of no other calendar."""
    return next((zero for zero in _ZEROS if _FROM <= (day - zero) * _DAY <= _TO), 0.0)


class Clock:
    """Checks the times of one group, block by block.

    Parameters
    ----------
    name : str
        For findings.
    factor : float
        Of the log's unit of time, in s.
    raster : float, s, or None
        As the map says.
    interval : float, s, or None
        Between rows of a log without a clock.
    findings : Findings
    dates : bool
        Whether times are dates, in s since 1970.
    """

    def __init__(
        self,
        name: str,
        factor: float,
        raster: float | None,
        interval: float | None,
        findings: Findings,
        dates: bool = False,
    ) -> None:
        self.name, self.factor, self.declared, self.interval, self.findings = name, factor, raster, interval, findings
        self.dates = dates
        self.raster = np.nan
        self.first = np.nan
        self.last = -np.inf
        self.gaps, self.lost = 0, 0.0
        self._digits = 0  # gaps that a time of day in one number, hhmmss, has behind every minute
        self._zero: float | None = None  # of times in days
        self._behind = False
        # the last row, if it lies behind: the next ones say whether it is alone
        self._alone = np.zeros(0, dtype=np.int64)
        self._n_interval = self._n_irregular = 0
        self._n_row = self._n_same = 0
        self._n_fall = 0
        self._fell = ""
        # the last number as the log has it, its usual step, and what later ones are larger by
        self._counted, self._usual, self._wrapped = np.nan, 0.0, 0.0
        self._irregular: list[int] = []

    def rows(self, blocks: Iterator[LogBlock]) -> Iterator[ClockedRows]:
        """Rows in order; a row of each block waits for the next, since a jump is seen by the row after it."""
        waiting: LogBlock | None = None
        for block in blocks:
            if not len(block.rows):
                continue
            block = self._beyond_counters(block)
            joined = block if waiting is None else _join(waiting, block)
            if len(joined.rows) > 1:
                yield self._check(_part(joined, slice(None, -1)), self._times(_part(joined, slice(-1, None)))[0])
            waiting = _part(joined, slice(-1, None))
        if waiting is not None:
            yield self._check(waiting, np.nan)
        self._end()

    def _beyond_counters(self, block: LogBlock) -> LogBlock:
        """Times that go on where a counter has begun anew: a step later than its last number, as near as makes no difference."""
        if block.time is None:
            return block
        place = np.flatnonzero(np.isfinite(block.time))
        given = block.time[place]
        steps = np.diff(given, prepend=self._counted)
        self._counted = float(given[-1]) if given.size else self._counted
        rising, falling = steps[steps > 0.0], np.flatnonzero(steps < 0.0)
        self._usual = float(np.median(rising)) if rising.size else self._usual
        for size in _COUNTERS if falling.size else ():
            beyond = steps[falling] + size
            anew = falling[(beyond > 0.0) & (beyond <= JOIN * self._usual)]
            if anew.size:
                self.findings.add_rows(
                    "counter", self.name, block.rows[place[anew]], f"after {size:.10g} it begins anew"
                )
                later = np.zeros(len(given))
                later[anew] = size
                given = given + np.cumsum(later)
                break
        added = given + self._wrapped
        self._wrapped += float(given[-1] - block.time[place[-1]]) if given.size else 0.0
        if np.array_equal(added, block.time[place]):
            return block
        time = block.time.copy()
        time[place] = added
        return block._replace(time=time)

    def _times(self, block: LogBlock) -> np.ndarray:
        if block.time is None:
            assert self.interval is not None
            return (block.rows - 1) * self.interval
        if self.factor != _DAY:
            return block.time * self.factor
        if self._zero is None:
            known = block.time[np.isfinite(block.time)]
            self._zero = day_zero(float(known[0])) if known.size else None
        return (block.time - (self._zero or 0.0)) * _DAY

    def _check(self, block: LogBlock, following: float) -> ClockedRows:
        time, rows, f = self._times(block), block.rows, self.findings
        good = np.isfinite(time)
        f.add_rows("no time", self.name, rows[~good])
        self._impossible(rows[good], time[good])
        place = np.flatnonzero(good & (np.abs(time) < _FAR))
        t = time[place]
        before = np.concatenate([[self.last], t[:-1]])
        after = np.concatenate([t[1:], [following]])
        jump = (t > after) & (after > before) & (t > before)  # goes ahead of its neighbours alone
        f.add_rows("clock jump", self.name, rows[place[jump]])
        place, t = place[~jump], t[~jump]
        highest = np.maximum.accumulate(np.concatenate([[self.last], t]))[:-1]
        behind, same = t < highest, t == highest
        f.add_rows("time repeats", self.name, rows[place[same]])
        self._n_row, self._n_same = self._n_row + t.size, self._n_same + int(same.sum())
        self._n_fall += int((np.diff(t) < 0.0).sum())
        if behind.any() and not self._fell:
            k = int(np.flatnonzero(behind)[0])
            self._fell = f"in row {rows[place][k]} the time falls from {highest[k]:.10g} to {t[k]:.10g} s"
        self._note_behind(rows[place], behind)
        keep = ~behind & ~same
        place, t = place[keep], t[keep]
        after_gap = self._intervals(rows[place], t)
        if len(place) == len(rows):
            text = {name: _marks(places, len(rows)) for name, places in block.text.items()}
            return ClockedRows(rows, t, block.values, text, after_gap, block.done)
        text = {name: _marks(places, len(rows))[place] for name, places in block.text.items()}
        return ClockedRows(rows[place], t, {k: v[place] for k, v in block.values.items()}, text, after_gap, block.done)

    def _impossible(self, rows: np.ndarray, t: np.ndarray) -> None:
        """Note times that no log of a machine has; a clock that shows a date of our days once shows dates."""
        self.dates = self.dates or bool(((t > _FROM) & (t < _TO)).any())
        strange = (t < (_FROM if self.dates else _BEFORE)) | (t > _TO)
        if strange.any():
            self.findings.add_rows("impossible time", self.name, rows[strange], f"such as {t[strange][0]:.10g} s")

    def _note_behind(self, rows: np.ndarray, behind: np.ndarray) -> None:
        """Single rows that lie behind are jumps, several in a row are an overlap."""
        if behind.size == 0:
            return
        if self._alone.size:
            self.findings.add_rows("overlap" if behind[0] else "clock jump", self.name, self._alone)
            self._alone = self._alone[:0]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], behind, [False]]).astype(np.int8)))
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            goes_on = start == 0 and self._behind
            if end - start == 1 and not goes_on and end == len(behind):
                self._alone = rows[start:end]
            else:
                kind = "overlap" if end - start > 1 or goes_on else "clock jump"
                self.findings.add_rows(kind, self.name, rows[start:end])
        self._behind = bool(behind[-1])

    def _intervals(self, rows: np.ndarray, t: np.ndarray) -> np.ndarray:
        if t.size == 0:
            return np.zeros(0, dtype=bool)
        if not np.isfinite(self.first):
            self.first = float(t[0])
        steps = np.diff(np.concatenate([[self.last], t]))
        self.last = float(t[-1])
        real = np.isfinite(steps)
        if not np.isfinite(self.raster) and real.any():
            self.raster = float(np.median(steps[real]))
            self.compare(self.name, self.declared, self.raster)
        gap = real & (steps > JOIN * self.raster)
        if gap.any():
            self.gaps += int(gap.sum())
            self.lost += float(steps[gap].sum())
            self._digits += int(_minutes_begin(t[gap] - steps[gap], t[gap], JOIN * self.raster).sum())
            detail = f"{self.gaps} gap(s), {self.lost:.4g} s in all; the row after each is named"
            if self._digits == self.gaps:
                detail += (
                    "; all lie between 59 and 100 of a hundred: hours, minutes and seconds in one number, such as 135959, are no seconds; "
                    "write 13:59:59"
                )
            self.findings.add_rows("gap", self.name, rows[gap], detail)
        odd = real & ~gap & (np.abs(steps - self.raster) > _IRREGULAR * self.raster)
        self._n_interval += int((real & ~gap).sum())
        self._n_irregular += int(odd.sum())
        self._irregular += rows[odd][: max(0, 20 - len(self._irregular))].tolist()
        return gap

    def compare(self, name: str, declared: float | None, found: float) -> None:
        """Note a raster that is not the map's."""
        if declared is not None and abs(found - declared) > _OTHER * declared:
            detail = f"found {found:.4g} s, the map says {declared:.4g} s: check the unit of time, or the map"
            self.findings.add("raster", name, detail)

    def check_table(self, raster: float) -> None:
        """Refuse samples between which a table would have thousands of rows."""
        if self.declared is None and self.raster > _MOST_ROWS * raster:
            raise InputError(
                f"raster = {raster:g} s: samples come every {self.raster:.4g} s, and the table would have {self.raster / raster:.0f} rows from one to the "
                "next: check the unit of time, or give a raster nearer to that"
            )

    def compare_table(self, raster: float) -> None:
        """Note rows that come so much more, or less, often than those of the table that the unit of time may be wrong."""
        if self.declared is None and not raster / _ANOTHER_UNIT <= self.raster <= raster * _ANOTHER_UNIT:
            detail = f"found {self.raster:.4g} s, the table has a row every {raster:.4g} s: check the unit of time"
            self.findings.add("raster", self.name, detail)

    def _end(self) -> None:
        self.findings.add_rows("clock jump", self.name, self._alone)
        if self.findings.of("overlap", self.name):
            advice = "if recordings were put one behind the other, cut the file there, and import the files together"
            if self._n_fall > _FALLING * self._n_row:
                advice = "times fall from row to row: turn the rows of the log round, the last one first"
            self.findings.add("overlap", self.name, f"{self._fell}; {advice}")
        if self._n_same > 0.5 * self._n_row:
            detail = (
                "the clock ticks more slowly than rows come: leave it out, and give the interval between rows instead"
            )
            self.findings.add("time repeats", self.name, detail)
        if self._n_irregular > max(5, _SHARE * self._n_interval):
            found = self.findings.add("irregular", self.name, f"usual interval {self.raster:.4g} s")
            found.count = self._n_irregular
            found.rows = [(row, row) for row in self._irregular]


def _minutes_begin(before: np.ndarray, after: np.ndarray, near: float) -> np.ndarray:
    """Which gaps, from times before to times after them, go from a 60 of a hundred to the next hundred, (n_gap,) array of bool."""
    found: np.ndarray = (np.abs(before % 100.0 - 60.0) <= near) & (after % 100.0 <= near) & (before % 100.0 < 60.0)
    return found


def _marks(places: np.ndarray, n: int) -> np.ndarray:
    """Marks at these places of `n`."""
    found = np.zeros(n, dtype=bool)
    found[places] = True
    return found


def _part(block: LogBlock, part: slice) -> LogBlock:
    n = len(block.rows)
    text = {
        name: np.flatnonzero(_marks(places, n)[part]) if len(places) else places for name, places in block.text.items()
    }
    time = None if block.time is None else block.time[part]
    return LogBlock(block.rows[part], time, {k: v[part] for k, v in block.values.items()}, text, block.done)


def _join(a: LogBlock, b: LogBlock) -> LogBlock:
    time = None if a.time is None or b.time is None else np.concatenate([a.time, b.time])
    return LogBlock(
        np.concatenate([a.rows, b.rows]),
        time,
        {k: np.concatenate([a.values[k], b.values[k]]) for k in b.values},
        {k: np.concatenate([a.text[k], b.text[k] + len(a.rows)]) for k in b.text},
        b.done,
    )
