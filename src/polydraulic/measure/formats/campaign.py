"""Several files of one campaign as one log: in the order of their times, what lies between them stays a gap."""

import hashlib
from collections.abc import Iterator, Sequence
from glob import glob, has_magic
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import Log, LogBlock
from polydraulic.measure.formats.logs import open_log

_APART = 60.0  # s between files whose times begin anew: nobody knows how long it was
_ANEW = 0.05  # of the shorter file: files that begin so close to each other have clocks that begin anew
_COMPARED, _ENOUGH = 8, 20_000  # signals, and samples of each, by which files that overlap are compared
_SAME = 0.1  # of the spread, up to which values of two files at the same time are the same
_DATES = 315_532_800.0  # s since 1970: from 1980 on numbers are dates


class _Part(NamedTuple):
    """A file: its first and last time in s, how many rows it has, and what its times are shifted by."""

    log: Log
    first: float
    last: float
    n_row: int
    shift: float = 0.0


def expand(paths: str | Path | Sequence[str | Path]) -> list[Path]:
    """Files that are named, or match a pattern such as ``logs/*.csv``.

    Raises
    ------
    InputError
        A pattern that matches no file.
    """
    found: list[Path] = []
    for path in [paths] if isinstance(paths, str | Path) else paths:
        if has_magic(str(path)) and not Path(path).exists():
            matching = sorted(Path(p) for p in glob(str(path)))
            if not matching:
                raise InputError(f"{path}: no file matches")
            found += matching
        else:
            found.append(Path(path))
    if not found:
        raise InputError("no log is given; name at least one file")
    return found


def open_campaign(
    paths: Sequence[Path],
    time: str | None,
    factor: float,
    dates: str | None,
    findings: Findings,
    dbc: Sequence[str | Path] = (),
) -> Log:
    """Open files of one campaign as one log; one file is opened as it is.

    Parameters
    ----------
    paths : sequence of Path
    time : str or None
        Signal of the time, of logs that have no clock of their own.
    factor : float
        Of the numbers of the time, in s.
    dates : str or None
        As for `open_log`.
    dbc : sequence of str or Path, optional
        As for `open_log`.
    findings : Findings
        Takes ``file repeats``, ``files overlap``, ``files begin anew`` and units that differ.

    Raises
    ------
    InputError
        A file that is not a log, or that has not the channels of the first one.
    """
    if len(paths) == 1:
        return open_log(paths[0], dates=dates, dbc=dbc)
    logs = []
    try:
        for path in _different(paths, findings):
            logs.append(open_log(path, dates=dates, dbc=dbc))
        if len(logs) == 1:
            return logs[0]
        return _joined(logs, time, factor, findings)
    except BaseException:
        for log in logs:
            log.close()
        raise


def _joined(logs: list[Log], time: str | None, factor: float, findings: Findings) -> Log:
    clocks = {(log.own_clock, "" if log.own_clock or not time else log.signal(time).kind) for log in logs}
    if len(clocks) > 1:
        raise InputError(
            f"{logs[0].path} and files with it have clocks of different kinds; import those of one kind together"
        )
    parts = [_span(log, time, factor) for log in logs]
    dated = [p._replace(first=p.first + p.log.began, last=p.last + p.log.began) for p in parts]
    dated.sort(key=lambda p: p.first)
    if all(log.own_clock and log.began for log in logs):
        parts = _by_start(parts, dated, findings)
    else:
        parts = _in_order(parts, time, findings)
    first = parts[0].log
    _units(parts, findings)

    def read(group: int, wanted: Sequence[str], source: str | None, found: Findings) -> Iterator[LogBlock]:
        offset = 0
        for number, part in enumerate(parts):
            here = _group(part.log, wanted)
            last = 0
            for block in part.log.read(here, wanted, source, found):
                at = (
                    None
                    if block.time is None
                    else block.time + part.shift / (1.0 if _in_seconds(first, source) else factor)
                )
                last = int(block.rows[-1]) if len(block.rows) else last
                yield block._replace(rows=block.rows + offset, time=at, done=(number + block.done) / len(parts))
            offset += last if _timed(first, source) else last + 10

    def close() -> None:
        for part in parts:
            part.log.close()

    names = Path(", ".join(part.log.path.name for part in parts))
    left_out = {name: reason for part in reversed(parts) for name, reason in part.log.left_out.items()}
    return Log(names, first.signals, first.own_clock, read, first.duplicates, close, first.began, first.also, left_out)


def _timed(log: Log, source: str | None) -> bool:
    """Whether rows have times; otherwise a few rows are left out between files, so that a gap is seen."""
    return log.own_clock or source is not None


def _in_seconds(log: Log, source: str | None) -> bool:
    return log.own_clock or source is None or bool(log.signal(source).kind)


def _different(paths: Sequence[Path], findings: Findings) -> list[Path]:
    """Files without those that hold the same bytes as another one."""
    seen: dict[bytes, Path] = {}
    repeats = []
    for path in paths:
        digest = _digest(path)
        if digest in seen:
            repeats.append(f"{path.name} is {seen[digest].name}")
        else:
            seen[digest] = path
    if repeats:
        findings.add("file repeats", "", ", ".join(repeats))
    return list(seen.values())


def _digest(path: Path) -> bytes:
    """What tells the content of a file, or of the folder of a bag, from that of others."""
    if not path.exists():
        raise InputError(f"{path}: no such file")
    files = (
        sorted(file for file in path.iterdir() if file.is_file() and file.suffix != ".yaml")
        if path.is_dir()
        else [path]
    )
    found = b""
    for one in files:
        with one.open("rb") as file:
            found += hashlib.file_digest(file, "sha256").digest()
    return found


def _span(log: Log, time: str | None, factor: float) -> _Part:
    """First and last time: one pass over the clock alone."""
    if not log.own_clock and time is None:
        return _Part(log, 0.0, 0.0, 0)
    low, high, n_row = np.inf, -np.inf, 0
    factor = 1.0 if _in_seconds(log, time) else factor
    groups = {s.group for s in log.signals} if log.own_clock else {log.signal(str(time)).group}
    for group in groups:
        wanted = [] if log.own_clock else [str(time)]
        for block in log.read(group, wanted, None if log.own_clock else time, Findings()):
            n_row = max(n_row, int(block.rows[-1]) if len(block.rows) else 0)
            at = block.time[np.isfinite(block.time)] * factor if block.time is not None else np.zeros(0)
            if at.size:
                low, high = min(low, float(at.min())), max(high, float(at.max()))
    if not np.isfinite(low):
        raise InputError(f"{log.path}: no row has a readable time; leave the file out, or repair it")
    return _Part(log, low, high, n_row)


def _by_start(parts: list[_Part], dated: list[_Part], findings: Findings) -> list[_Part]:
    """Files that say when they began, in this order; one behind the other where this cannot be true.

    Programs that give a file the time when it was saved make overlaps that are none: two files hold other values at the same time.
    """
    both = _overlapping(dated)
    if all(_agree(a, b) for a, b in both):
        _note_overlap(both, findings)
        return [p._replace(shift=p.log.began - dated[0].log.began) for p in dated]
    _note_overlap(both, findings, "they hold other values at these times, so that the times cannot be right")
    return _behind_each_other(parts, findings)


def _agree(a: _Part, b: _Part) -> bool:
    """Whether two files with times since 1970 hold the same where they overlap; where nothing there varies, nothing says otherwise."""
    low, high = max(a.first, b.first), min(a.last, b.last)
    same = {s.name for s in a.log.signals} & {s.name for s in b.log.signals}
    found = []
    for name in [s.name for s in a.log.signals if s.name in same][:_COMPARED]:
        (t, u), (s, v) = (_stretch(part.log, name, low, high) for part in (a, b))
        inside = (t >= s[0]) & (t <= s[-1]) if len(s) > 1 else np.zeros(len(t), dtype=bool)
        spread = float(np.ptp(u[inside])) if inside.sum() > 2 else 0.0
        if spread > 0.0:
            found.append(float(np.median(np.abs(np.interp(t[inside], s, v) - u[inside]))) < _SAME * spread)
    return not found or sum(found) > 0.5 * len(found)


def _stretch(log: Log, name: str, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Times since 1970 and values of a signal in a stretch of time."""
    times, values = [np.zeros(0)], [np.zeros(0)]
    for block in log.read(log.signal(name).group, [name], None, Findings()):
        at = (block.time if block.time is not None else np.zeros(len(block.rows))) + log.began
        there = (at >= low) & (at <= high) & np.isfinite(block.values[name])
        times.append(at[there])
        values.append(block.values[name][there])
        if sum(map(len, times)) > _ENOUGH:
            break
    order = np.argsort(np.concatenate(times), kind="stable")
    return np.concatenate(times)[order], np.concatenate(values)[order]


def _in_order(parts: list[_Part], time: str | None, findings: Findings) -> list[_Part]:
    """Files by their times; those that restart one behind the other, as they were named."""
    if not parts[0].log.own_clock and time is None:
        findings.add("files begin anew", "", "the logs have no time; " + _names(parts))
        return parts
    of_day = time is not None and not parts[0].log.own_clock and parts[0].log.signal(time).kind == "clock"
    dated = min(part.first for part in parts) > _DATES
    shortest = min(part.last - part.first for part in parts)
    close = max(p.first for p in parts) - min(p.first for p in parts) <= _ANEW * shortest
    if not dated and (close or (of_day and _overlapping(sorted(parts, key=lambda p: p.first)))):
        return _behind_each_other(parts, findings)
    parts = sorted(parts, key=lambda p: p.first)
    _note_overlap(_overlapping(parts), findings)
    return parts


def _behind_each_other(parts: list[_Part], findings: Findings) -> list[_Part]:
    """Files as they were named, each a while behind the one before."""
    found: list[_Part] = []
    end = -np.inf
    for part in parts:
        shift = 0.0 if not found else end + _APART - part.first
        found.append(part._replace(shift=shift))
        end = part.last + shift
    findings.add("files begin anew", "", f"{_names(parts)}, {_APART:g} s apart")
    return found


def _note_overlap(
    both: Sequence[tuple[_Part, _Part]], findings: Findings, what: str = "what was recorded already is left out"
) -> None:
    if both:
        names = "; ".join(f"{b.log.path.name} begins before {a.log.path.name} ends" for a, b in both)
        findings.add("files overlap", "", f"{names}: {what}")


def _overlapping(parts: Sequence[_Part]) -> list[tuple[_Part, _Part]]:
    return [(a, b) for a, b in pairwise(parts) if b.first <= a.last]


def _names(parts: Sequence[_Part]) -> str:
    return ", ".join(part.log.path.name for part in parts)


def _group(log: Log, wanted: Sequence[str]) -> int:
    groups = {log.signal(name).group for name in wanted}
    if len(groups) > 1:
        raise InputError(
            f"{log.path}: {list(wanted)} have not one clock, as in the first file; import it in a call of its own"
        )
    return groups.pop()


def _units(parts: Sequence[_Part], findings: Findings) -> None:
    """Note units that are not those of the first file."""
    first = parts[0].log
    for part in parts[1:]:
        units = {s.name: s.unit for s in part.log.signals}
        for signal in first.signals:
            other = units.get(signal.name, signal.unit)
            if other != signal.unit:
                detail = f"{first.path.name} says {signal.unit!r}, {part.log.path.name} {other!r}"
                findings.add("units of files", signal.name, detail)
