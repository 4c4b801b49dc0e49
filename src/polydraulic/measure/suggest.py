"""A first channel map for a log: what can be seen in the log is filled in, what only its owner knows is asked for."""

import re
from collections.abc import Sequence
from math import ceil, floor, inf, log10
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.columns.timestamps import ORDERS
from polydraulic.errors import InputError
from polydraulic.measure.channels import LONGEST, SHORTEST
from polydraulic.measure.checks.channel_check import NO_VALUE
from polydraulic.measure.checks.clock import day_zero
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.campaign import expand
from polydraulic.measure.formats.log import Log, Signal, by_reason
from polydraulic.measure.formats.logs import open_log
from polydraulic.measure.log_units import ATMOSPHERE, conversion, says_pressure
from polydraulic.progress import Progress, quiet
from polydraulic.units import unit_kind

_TIME_NAME = re.compile(
    r"(?i)^([\w.\[\]]+\.)?"  # structures that it is in
    r"((elapsed|relative|absolute|system|utc|local|log|sample|rel|abs)[ _]?)?"
    r"(time|t|tout|timestamps?|time[ _]?stamp|date[ _]?time|zeit|zeitstempel|uhrzeit|zeitpunkt|epoch|datum|date)"
    r"([ _]?(?P<unit>s|sec|ms|us|µs|ns))?$"
)
_DIFFERENCE = re.compile(r"(?i)Δ|δ|delta|diff|(^|[^a-z])dp([^a-z]|$)")  # in names of pressures that may be negative
_UNITS = {"sec": "s"}
_UNIT_NAME = re.compile(
    r"(?i)^(?P<s>s|secs?|seconds?|sekunden?)$|^(?P<ms>ms|msec|millis|milliseconds|millisekunden)$|^(?P<us>us|µs|micros|microseconds)$"
)
_X_NAME = re.compile(r"(?i)^x[ _-]?(value|axis)$")  # of the first column, as LabVIEW and oscilloscopes call the time
_COUNTER = re.compile(r"(?i)^(column 1|unnamed: \d+|index|row|no\.?|nr\.?|#|samples?|scan|record|point|n|count|id)$")
_EVEN, _EVEN_ROWS = 0.1, 20  # share by which steps of a time may differ, and of those that differ more; rows that tell
# 7.8 s; steps below it are days, where the numbers can be: as s they were more than 10,000 rows a second, which no log has
_LEAST_DAY = 9e-5
_SINCE_1970 = ((1e11, "ms"), (1e14, "us"), (1e17, "ns"))  # from which number on it can only be this unit
# how names end in units where the log has no place for them; those that could be something else (p_A, x_in) are left out
_ENDINGS = {
    unit: unit
    for unit in "bar barg bara psi Pa kPa MPa mm cm m deg rad rpm lpm gpm V mV mA N kN MN Nm kg Hz degC".split()
}
_ENDINGS |= {"rps": "rev/s", "l_min": "l/min", "pct": "%", "percent": "%"}
_ENDINGS |= {
    f"{unit}{per}": f"{unit}/s"
    for unit in ("deg", "rad", "mm", "m")
    for per in ("_s", "_per_s", "_per_sec", "ps", "/s")
}
_HOLD = 0.6  # share of samples like the one before, from which on a channel is a held one
_ROUND = (1.0, 2.0, 5.0)
_ALIKE = 1e-8  # of ends of ranges that need all their digits
_OTHER_SIGN = 0.05  # of the larger values: less to the other side of 0 is noise, or an offset

_HEAD = """\
# A first channel map, made from what the log shows. Go through it:
# - role: what is to be predicted is an "output", what it is predicted from an "input"; "ignore" leaves a channel out. A log does not
#   tell: flows are outputs here and all else is an input, so choose.
# - unit: of the numbers in the log; the table will be in SI. Pressures are gauge pressures; from bar(a), psia and the like an
#   atmosphere is taken: put atmosphere = "1.013 bar" at the top.
# - range: what was seen in all channels of that unit, half as much on either side, and symmetric where both signs were seen; values
#   beyond it are taken as missing, so put what is physically possible; no pressure here goes below a vacuum. Angles have none: they
#   may add up turn by turn.
# - between: "linear" or "hold", what is true between two samples. sign = -1 turns a channel round.
# - name: the column in the table, such as "boom.p_a"; the source if not given.
"""


class _Seen(NamedTuple):
    low: float
    high: float
    n: int
    raster: float
    held: float


def suggest_channels(
    path: str | Path | Sequence[str | Path], *, dbc: Sequence[str | Path] = (), progress: Progress = quiet
) -> str:
    """Text of a first channel map for a log, as TOML.

    Parameters
    ----------
    path : str, Path or sequence of them
        A log; see `open_log`. It is read once, for the ranges; of several files, which hold the same channels, all of them.
    dbc : sequence of str or Path, optional
        CAN databases (DBC) of a bus log.
    progress : Progress, optional

    Raises
    ------
    InputError
        A file that is not a log.
    """
    paths = expand(path)
    with open_log(paths[0], dbc=dbc) as log:
        time = None if log.own_clock else _time_of(log)
        unit = "s" if time is None else _unit_of_time(log, time)
        in_doubt = time is not None and any(s.doubt for s in log.signals if s.name in (time.name, time.beside))
        if in_doubt:  # intervals are the same in either order, but for midnights
            with open_log(paths[0], dates=ORDERS[0]) as either:
                seen = _look(either, time, unit, progress)
        else:
            seen = _look(log, time, unit, progress)
        for more in paths[1:]:
            with open_log(more, dates=ORDERS[0] if in_doubt else None, dbc=dbc) as another:
                again = _look(another, time, unit, progress)
            seen = {name: _wider(old, again.get(name)) for name, old in seen.items()}
        lines_of_time = [] if time is None else _time_lines(log, time, unit)
    used = [
        s
        for s in log.signals
        if s is not time
        and not s.kind
        and seen[s.name].n
        and seen[s.name].low < seen[s.name].high
        and not _counts_rows(s, seen[s.name])
    ]
    rasters = [seen[s.name].raster for s in used if SHORTEST <= seen[s.name].raster <= LONGEST]
    units = {s.name: _unit(s) for s in used}
    ranges = _ranges(units, seen)
    lines = [_HEAD, f"raster = {_text(_span(min(rasters, default=0.01)))}  # of the table"]
    if time is None and not log.own_clock:
        lines.append('interval = "10 ms"  # between rows: the log does not tell, so correct it')
    for signal in log.signals:
        lines += ["", "[[channel]]", f"source = {_text(signal.name)}"]
        if signal is time:
            lines += lines_of_time
            continue
        if time is not None and signal.name == time.beside:
            lines += ['role = "ignore"  # read together with the time']
            continue
        found = seen[signal.name]
        if signal not in used:
            why = "it holds times" if signal.kind else "it holds no numbers" if not found.n else "it is constant"
            why = "it counts the rows" if _counts_rows(signal, found) else why
            lines += [f'role = "ignore"  # {why}']
            continue
        role = "output" if _known(units[signal.name].unit) == "m3/s" else "input"
        lines += [f"role = {_text(role)}", *units[signal.name].lines]
        if SHORTEST <= found.raster <= LONGEST:
            lines.append(f"raster = {_text(_span(found.raster))}")
        lines.append(f"between = {_text('hold' if found.held > _HOLD else 'linear')}")
        if signal.name in ranges:
            low, high = ranges[signal.name]
            low = max(low, _least(signal, units[signal.name].unit, found.low))
            ends = f"{low:.10g}, {high:.10g}"
            lines.append(f"range = [{ends if high - low > _ALIKE * abs(low) else f'{low!r}, {high!r}'}]")
        if signal.name in log.duplicates:
            lines.append("# the log has this name more than once: this is the first")
    if log.left_out:
        lines += ["", "# Not read: " + by_reason(log.left_out).encode("unicode_escape").decode()]
    if not used:
        raise InputError(f"{log.path}: no channel holds numbers that vary; there is nothing to import")
    return "\n".join(lines) + "\n"


def _counts_rows(signal: Signal, found: _Seen) -> bool:
    """Whether a column without a name of its own, or with that of a counter, rises by one from row to row, as pandas writes an index."""
    return bool(_COUNTER.match(signal.name.strip())) and found.n > 1 and found.high - found.low == found.n - 1


def _time_of(log: Log) -> Signal | None:
    """The channel of the time: by its name, by dates or times of day that it holds, or as the first column by its unit; by a name that is such a unit."""
    named = [s for s in log.signals if _TIME_NAME.match(s.name.strip()) and _known(s.unit or "s") == "s"]
    typed = [s for s in log.signals if s.kind]
    units = [s for s in log.signals if _UNIT_NAME.match(s.name.strip()) and _known(s.unit or "s") == "s"]
    units = units or [s for s in log.signals[:1] if _known(s.unit) == "s" or _X_NAME.match(s.name.strip())]
    both = [s for s in named if s.kind] or named or typed or units or _rising(log)
    # of a date and a time of day that stand side by side the second one is named
    return next((s for s in both if not (s.beside and s.kind == "stamp")), both[0] if both else None)


def _says_time(signal: Signal) -> bool:
    """Whether a signal is the time by its name."""
    name = signal.name.strip()
    return any(pattern.match(name) for pattern in (_TIME_NAME, _UNIT_NAME, _X_NAME))


def _rising(log: Log) -> list[Signal]:
    """The first column, if it rises by about the same from row to row and does not count the rows; MAT and Parquet may have it anywhere."""
    first = log.signals[0]
    block = next(iter(log.read(first.group, [first.name], None, Findings())), None)
    value = np.zeros(0) if block is None else block.values[first.name]
    steps = np.diff(value)
    counts = first.name != "column 1" and _COUNTER.match(first.name.strip())
    if steps.size < _EVEN_ROWS or not (steps > 0.0).all() or counts:
        return []
    even = np.abs(steps - np.median(steps)) <= _EVEN * np.median(steps)
    return [first] if even.mean() > 1.0 - _EVEN and not (steps == 1.0).all() else []


def _unit_of_time(log: Log, time: Signal) -> str:
    """Unit of numbers of time: as the log says, as the name ends, or as only times since 1970 can be."""
    if _known(time.unit) == "s":
        return time.unit
    if time.kind:
        return "s"
    match, alone = _TIME_NAME.match(time.name.strip()), _UNIT_NAME.match(time.name.strip())
    unit = match["unit"] if match else alone.lastgroup if alone else None
    if unit:
        return _UNITS.get(unit.lower(), unit.lower())
    block = next(iter(log.read(time.group, [time.name], None, Findings())), None)
    first = block.values[time.name] if block is not None else np.zeros(0)
    first = np.abs(first[np.isfinite(first)])
    usual = float(np.median(first)) if first.size else 0.0
    steps = np.abs(np.diff(first))
    if day_zero(usual) and steps.size and float(np.median(steps)) < _LEAST_DAY:
        return "d"
    return next((unit for least, unit in reversed(_SINCE_1970) if usual >= least), "s")


def _time_lines(log: Log, time: Signal, unit: str) -> list[str]:
    lines = ['role = "time"', f"unit = {_text(unit)}"]
    if time.kind:
        lines[1] += "  # the log has " + {"stamp": "dates", "clock": "times of day", "elapsed": "durations"}[time.kind]
    elif _known(time.unit) != "s" and unit == "s":
        seen = "" if _says_time(time) else "taken as the time, as it rises evenly; "
        lines.append(f"# {seen}the log does not tell the unit: look whether rasters come out right")
    date = time if time.doubt else next((s for s in log.signals if s.name == time.beside and s.doubt), None)
    if date is not None:
        lines.append(f"# {_text(date.doubt)} can be read in two ways; say which:")
        lines += [f"# dates = {_text(order)}" for order in ORDERS]
    return lines


def _look(log: Log, time: Signal | None, unit: str, progress: Progress) -> dict[str, _Seen]:
    groups: dict[int, list[str]] = {}
    for signal in log.signals:
        if signal is not time and (time is None or log.own_clock or signal.group == time.group):
            groups.setdefault(signal.group, []).append(signal.name)
    seen = {s.name: _Seen(inf, -inf, 0, np.nan, 0.0) for s in log.signals}
    factor = 1.0 if time is None or time.kind else conversion(unit).factor
    for number, (group, names) in enumerate(groups.items()):
        for block in log.read(group, names, None if time is None else time.name, Findings()):
            clock = None if block.time is None else block.time * factor
            for name in names:
                seen[name] = _merge(seen[name], clock, block.values[name])
            progress(log.path.name, int(1000 * (number + block.done) / len(groups)), 1000)
    return seen


def _wider(a: _Seen, b: _Seen | None) -> _Seen:
    """What was seen in two files."""
    return a if b is None else a._replace(low=min(a.low, b.low), high=max(a.high, b.high), n=a.n + b.n)


def _merge(before: _Seen, clock: np.ndarray | None, value: np.ndarray) -> _Seen:
    there = np.abs(value) < NO_VALUE
    count = int(there.sum())
    if count == 0:
        return before
    v = value[there]
    raster, held = before.raster, before.held
    if not np.isfinite(raster) and count > 2:
        held = float(np.mean(np.diff(v) == 0.0))
        if clock is not None:
            steps = np.diff(clock[there])
            steps = steps[np.isfinite(steps) & (steps > 0.0)]
            raster = float(np.median(steps)) if steps.size else np.nan
    low, high = min(before.low, float(v.min())), max(before.high, float(v.max()))
    return _Seen(low, high, before.n + count, raster, held)


class _Unit(NamedTuple):
    unit: str
    lines: list[str]


def _unit(signal: Signal) -> _Unit:
    """Unit that a channel gets, empty if it is not known, and the lines that say so."""
    if not signal.unit:
        guess = _unit_in(signal.name)
        said = "from its name: the log itself does not tell" if guess else "the log does not tell"
        return _Unit(guess, [f"unit = {_text(guess)}  # {said}"])
    pressure = says_pressure(signal.name)
    try:
        found = conversion(signal.unit, kind="Pa" if pressure else "")
    except InputError as error:
        return _Unit("", [f'unit = ""  # the log says {_text(signal.unit)}: {_text(str(error))[1:-1]}'])
    lines = [f"unit = {_text(signal.unit)}" + (f"  # or {signal.other_unit}" if signal.other_unit else "")]
    if pressure and found.si != "Pa":  # a sensor that is logged as it is
        lines.append(f'kind = "{unit_kind(found.si).name}"  # its name says pressure, its unit does not')
    return _Unit(signal.unit, lines)


def _unit_in(name: str) -> str:
    """Unit in which a name ends, such as ``boom_angle_deg``; empty if in none."""
    ends = [ending for ending in _ENDINGS if re.search(rf"[\w)][_ .([]{re.escape(ending)}[)\]]?$", name)]
    return _ENDINGS[max(ends, key=len)] if ends else ""


def _known(unit: str) -> str:
    try:
        return conversion(unit).si
    except InputError:
        return ""


def _span(seconds: float) -> str:
    return f"{seconds:.6g} s" if seconds >= 1.0 else f"{float(f'{1e3 * seconds:.3g}'):g} ms"


def _ranges(units: dict[str, _Unit], seen: dict[str, _Seen]) -> dict[str, tuple[float, float]]:
    """Ranges of channels: one for all of a unit, as another day drives another of them; of its own where the unit is not known."""
    alike: dict[tuple[str, str], list[str]] = {}
    for name, (unit, _) in units.items():
        if _known(unit) != "rad":
            alike.setdefault((unit, "" if unit else name), []).append(name)
    return {
        name: _round_range(min(seen[n].low for n in names), max(seen[n].high for n in names))
        for names in alike.values()
        for name in names
    }


def _round_range(low: float, high: float) -> tuple[float, float]:
    """What was seen and half as much on either side, on round numbers; of both signs as far to either: another day reaches further."""
    step = 10.0 ** floor(log10((high - low) / 10.0))
    step = next(s * step for s in (*_ROUND, 10.0) if s * step * 20.0 >= high - low)
    margin = 0.5 * (high - low)
    below, above = step * floor((low - margin) / step), step * ceil((high + margin) / step)
    most = max(-below, above)
    return (-most, most) if _OTHER_SIGN * max(-low, high) < min(-low, high) else (below, above)


def _least(signal: Signal, unit: str, seen: float) -> float:
    """What a pressure cannot be below, a vacuum, on a round number of its unit; none for differences, and where more was seen."""
    if _known(unit) != "Pa" or _DIFFERENCE.search(signal.name):
        return -inf
    of = conversion(unit, kind="Pa")
    least = 0.0 if of.absolute else float(f"{-ATMOSPHERE / of.factor:.2g}")
    return least if seen >= least else -inf


def _text(text: str) -> str:
    """A TOML string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in escaped) + '"'
