"""The values of one channel: which of them are any, and all that is wrong with them."""

import zlib
from math import inf, pi
from typing import Any

import numpy as np

from polydraulic.measure.channels import Channel
from polydraulic.measure.checks.clock import JOIN, Clock, ClockedRows
from polydraulic.measure.checks.envelope import Envelope
from polydraulic.measure.checks.run_lengths import ValueRuns
from polydraulic.measure.checks.sentinel import Sentinels
from polydraulic.measure.checks.turns import Turns
from polydraulic.measure.findings import Findings
from polydraulic.measure.log_units import conversion, same_kind
from polydraulic.units import Conversion

# A spike within the usual range may be a pressure peak between two samples, so that it must be larger.
_SPIKE, _SPIKE_WITHIN, _SPIKE_NOISE = 0.1, 0.3, 10.0  # of the range, of the range, of the usual difference
_MOST, _NEARLY_ALL = 0.5, 0.95
_PEAK = 1.0  # of the range: what is no farther beyond it may be a peak that the range cuts
_KEPT = 20_000  # values kept to try other units on
# nothing at a machine is as large; loggers write 9.91E+37 or the largest float where they have no value
NO_VALUE = 1e30


class Samples:
    """Samples of a channel that can be used: SI, in order of time."""

    def __init__(self, time: np.ndarray, values: np.ndarray) -> None:
        self.time, self.values = time, values


class ChannelCheck:
    """Checks one channel, block by block; `conversion` is that of its unit.

    Attributes
    ----------
    raster : float, s
        Between its samples, as the map says or as found.
    first, last : float, s
        Times of its first and last value that can be used; nan and -inf where there is none.
    count, low, high, mean, square : float
        Of the values that can be used, in the channel's unit.
    """

    def __init__(self, channel: Channel, conversion: Conversion, clock: Clock, findings: Findings) -> None:
        self.channel, self.conversion, self.clock, self.findings = channel, conversion, clock, findings
        self.raster = channel.raster or np.nan
        self.count, self.low, self.high, self.mean, self.square = 0, inf, -inf, 0.0, 0.0
        self.farthest = 0.0  # beyond the range
        self.given, self.implausible, self.seen = 0, 0, 0
        self.envelope, self.runs = Envelope(), ValueRuns()
        self.sentinels = Sentinels()
        self.turns = Turns(2.0 * pi / conversion.factor) if conversion.si == "rad" else None
        self.crc = 0
        self.lost = 0.0
        self._kept: list[np.ndarray] = []
        self.first, self.last = np.nan, -inf
        self._gaps_seen = 0
        self._compared = False

    def samples(self, rows: ClockedRows) -> Samples:
        """Check a block and return what of it can be used."""
        c, f = self.channel, self.findings
        raw, name = rows.values[c.source], c.source
        f.add_rows("text", name, rows.rows[rows.text[name]])
        there = np.flatnonzero(np.abs(raw) < NO_VALUE)
        if len(there) < len(raw):
            f.add_rows("infinite", name, rows.rows[np.abs(raw) >= NO_VALUE])
        given = raw if len(there) == len(raw) else raw[there]
        value = c.sign * given if c.sign != 1 else given
        self.given += len(value)
        self.seen += len(raw)
        self.crc = zlib.crc32(np.ascontiguousarray(given).data, self.crc)
        if sum(map(len, self._kept)) < _KEPT:
            self._kept.append(value[:: max(1, len(value) // 2000)].copy())
        if value.size and not (c.low <= value.min() and value.max() <= c.high):
            there, value = self._within(rows, there, value)
        if self.turns is not None:
            value, anew = self.turns.add(value)
            f.add_rows("turns", name, rows.rows[there[anew]])
        self.runs.add(value, _taken(rows.rows, there))
        if c.between == "linear":
            alone = _spikes(value)
            if alone.any():
                f.add_rows("spike", name, rows.rows[there[alone]])
                there, value = there[~alone], value[~alone]
        self.sentinels.add(value, _taken(rows.rows, there))
        self._count(value)
        time = _taken(rows.time, there)
        self._spacing(rows, there, time)
        self.envelope.add(time, value)
        return Samples(time, self.conversion.to_si(value))

    def _within(self, rows: ClockedRows, there: np.ndarray, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places and values within the plausible range; the others are noted."""
        c = self.channel
        outside = (value < c.low) | (value > c.high)
        self.implausible += int(outside.sum())
        detail = f"range [{c.low:g}, {c.high:g}] {c.unit}, such as {value[outside][0]:.6g}"
        self.farthest = max(self.farthest, float(np.max(np.maximum(c.low - value[outside], value[outside] - c.high))))
        if self.farthest <= _PEAK * (c.high - c.low):
            detail += "; none is far beyond it: if these are peaks of the signal, the range is too narrow: widen it"
        self.findings.add_rows("implausible", c.source, rows.rows[there[outside]], detail)
        return there[~outside], value[~outside]

    def _count(self, value: np.ndarray) -> None:
        if value.size == 0:
            return
        n, mean = len(value), float(value.mean())
        total, shift = self.count + n, mean - self.mean
        beside = value - mean
        self.square += float((beside * beside).sum()) + shift * shift * self.count * n / total
        self.mean += shift * n / total
        self.count = total
        self.low, self.high = min(self.low, float(value.min())), max(self.high, float(value.max()))

    def _spacing(self, rows: ClockedRows, there: np.ndarray, time: np.ndarray) -> None:
        """Find the raster; note where samples are farther apart than they may, but rows are not."""
        if time.size == 0:
            return
        self.first = float(time[0]) if np.isnan(self.first) else self.first
        past = np.concatenate([[self.last], time])
        steps = past[1:] - past[:-1]
        if not self._compared and np.isfinite(steps).sum() > 2:
            self._compared = True
            found = float(np.median(steps[np.isfinite(steps)]))
            if self.channel.between == "linear":  # a held channel may be written only when it changes
                self.clock.compare(self.channel.source, self.channel.raster, found)
            self.raster = self.raster if np.isfinite(self.raster) else found
        far = steps > JOIN * self.raster
        if far.any():
            gaps = np.cumsum(rows.after_gap)[there] + (self.clock.gaps - int(rows.after_gap.sum()))
            same = np.diff(np.concatenate([[self._gaps_seen], gaps])) == 0
            lost = far & same & np.isfinite(steps)
            if lost.any():
                self.lost += float(steps[lost].sum())
                detail = f"{self.lost:.4g} s in all"
                self.findings.add_rows("dropout", self.channel.source, rows.rows[there[lost]], detail)
        self.last = float(time[-1])
        self._gaps_seen = self.clock.gaps - int(rows.after_gap[there[-1] + 1 :].sum())

    def end(self) -> None:
        """Note what is known only when all rows have been seen."""
        c, f = self.channel, self.findings
        if self.given == 0:
            if self.seen:  # rows without a time were not looked at
                f.add("empty", c.source)
            return
        if self.implausible > _MOST * self.given:
            self._wrong_unit(np.concatenate(self._kept))
        if self.count and self.low == self.high:
            f.add("constant", c.source, f"{self.low:.6g} {c.unit}")
            return
        clipped: set[float] = set()
        for kind, runs, detail in self.runs.findings() if c.between == "linear" else ():
            f.add(kind, c.source, f"{detail} {c.unit}".strip())
            clipped |= {run.value for run in runs} if kind == "clipped" else set()
            for run in runs:
                f.add_span(kind, c.source, run.first, run.last, run.length)
        for number, count, at in self.sentinels.found() if self.runs.many else ():
            if number not in clipped:  # the end of a range, and named as such
                f.add_rows("sentinel", c.source, at, f"{number:.6g} {c.unit}".strip())
                f.add("sentinel", c.source).count += count - len(at)

    def _wrong_unit(self, value: np.ndarray) -> None:
        c = self.channel

        def fits(values: np.ndarray) -> bool:
            return bool(np.mean((values >= c.low) & (values <= c.high)) > _NEARLY_ALL)

        if fits(-value):
            self.findings.add("sign", c.source, f"the map has sign = {c.sign}")
            return
        others = [u for u in same_kind(c.unit) if fits(self.conversion.from_si(conversion(u).to_si(value)))]
        if others:
            self.findings.add("unit by values", c.source, f"the map says {c.unit!r}; it could be {' or '.join(others)}")


def value_in(check: ChannelCheck, unit: Conversion, value: Any) -> Any:
    """A value of a channel, in the unit of the log, in another one."""
    return unit.from_si(check.conversion.to_si(value))


def _spikes(v: np.ndarray) -> np.ndarray:
    """Values that stand alone: far from both neighbours, which are close to theirs and to each other."""
    found = np.zeros(len(v), dtype=bool)
    if len(v) < 20:
        return found
    d = v[1:] - v[:-1]
    moved = np.abs(d)
    size = np.minimum(moved[1:-2], moved[2:-1])  # of places 2 to n - 3
    around = np.maximum(np.maximum(moved[:-3], moved[3:]), np.abs(d[1:-2] + d[2:-1]))
    alone = (d[1:-2] * d[2:-1] < 0.0) & (around < 0.25 * size)
    if not alone.any():
        return found
    largest = float(size[alone].max())
    if 2 * np.count_nonzero(_SPIKE_NOISE * moved >= largest) > len(moved):  # the usual difference is too large for any
        return found
    low, high = np.quantile(v, [0.005, 0.995])
    digit = float(np.min(moved, where=moved > 0.0, initial=np.inf))
    beyond = np.maximum(v[2:-2] - high, low - v[2:-2]) > _SPIKE * (high - low)
    share = np.where(beyond, _SPIKE, _SPIKE_WITHIN) * (high - low)
    least = np.maximum(share, max(_SPIKE_NOISE * float(np.median(moved)), 3.0 * digit))
    found[2:-2] = alone & (size > least)
    return found


def _taken(values: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Values at rising places; no copy where these are all of them."""
    return values if len(there) == len(values) else values[there]
