"""From a log to a table: block by block, with everything that is wrong on the way noted.

The table has the columns ``time``, ``segment`` and one for each input and output, in SI, on one raster. It holds rows where all of
them are known, or, if asked for, where any is, and declares the others as missing; rows of one segment follow each other without a gap.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np

from polydraulic.ahead import done_later
from polydraulic.display import DEFAULT, shown_unit
from polydraulic.errors import InputError
from polydraulic.files import check_apart
from polydraulic.measure.channels import Channel, ChannelMap
from polydraulic.measure.checks.channel_check import ChannelCheck
from polydraulic.measure.checks.clock import Clock, ClockedRows
from polydraulic.measure.checks.excerpt import Excerpt
from polydraulic.measure.findings import Findings
from polydraulic.measure.flows import FlowStream
from polydraulic.measure.formats.campaign import expand, open_campaign
from polydraulic.measure.formats.log import Log, by_reason
from polydraulic.measure.log_units import conversion
from polydraulic.measure.resample import Resampler
from polydraulic.progress import Progress, quiet
from polydraulic.tables import MISSING, Table, table_ending, table_writer
from polydraulic.unit_table import ATMOSPHERE
from polydraulic.units import Conversion, unit_kind

STEPS = 1000  # of the progress
_ROUNDING = 1e-6  # of a raster that was found


@dataclass(frozen=True)
class Imported:
    """What came of a log.

    Attributes
    ----------
    source : Path
    channels : ChannelMap
    findings : Findings
    checks : list of ChannelCheck
        Statistics of each channel.
    span : (float, float), s
        First and last time of the log.
    n_row, n_segment : int
        Of the table.
    too_short : int
        Rows of segments in which no flow or rate could be made.
    excerpt : Table
        Rows from all over the table in which all is known, or all of them if they are few.
    began : float, s since 1970
        When the log's time was zero; 0 if that is not known, or its times count from 1970 themselves.
    missing : dict from column to int, or None
        In how many rows of a partial table each has no value; None for a table of whole rows.
    """

    source: Path
    channels: ChannelMap
    findings: Findings
    checks: list[ChannelCheck]
    span: tuple[float, float]
    n_row: int
    n_segment: int
    too_short: int
    excerpt: Table
    began: float = 0.0
    missing: dict[str, int] | None = None

    def shown(self, units: str = DEFAULT) -> dict[str, Conversion]:
        """How the columns convert to the units that people read: those of `units`, or of the log where that system has none."""
        found = {c.name: self.channels.conversion(c) for c in self.channels.used}
        found |= {name: conversion(si) for name, si in self.channels.made().items()}
        for name, own in found.items():
            read = shown_unit(own.si, units)
            if units == "si":
                found[name] = Conversion(1.0, 0.0, own.si, own.si)
            elif read != own.si:
                found[name] = conversion(read)
        return found


def import_log(
    path: str | Path | Sequence[str | Path],
    channels: ChannelMap,
    out: str | Path,
    *,
    dbc: Sequence[str | Path] = (),
    partial: bool = False,
    progress: Progress = quiet,
) -> Imported:
    """Read a log, or several files of one campaign, through a channel map and write the table that comes of it.

    Parameters
    ----------
    path : str, Path or sequence of them
        A log; see `open_log`. Several files, or patterns such as ``day1_*.csv``, are joined in the order of their times; gaps between
        them stay gaps. Rows are counted on from file to file.
    channels : ChannelMap
        From `load_channels`.
    out : str or Path
        Table to write, ``.parquet`` or ``.csv``; not written if no row comes of the log.
    dbc : sequence of str or Path, optional
        CAN databases (DBC) of a bus log.
    partial : bool
        Keep rows in which any channel is known, and declare the others as missing there (`Table.partial`); whole rows only if not given.
    progress : Progress, optional

    Returns
    -------
    Imported
        For `write_quality`, which says what is wrong with the log.

    Raises
    ------
    InputError
        A file that is not a log, a channel that it does not have, a place that cannot be written or is that of the log itself.
    """
    table_ending(out)
    check_apart(out, expand(path))
    findings = Findings()
    with _opened(path, channels, dbc, findings) as log:
        groups = _groups(log, channels)
        _names_and_units(log, channels, findings)
        resampler = Resampler(channels.raster, [c.between for c in channels.used], partial=partial)
        flows = FlowStream([c.name for c in channels.used], (*channels.flows, *channels.rates), channels.raster)
        units = {"time": "s", "segment": "1", **{c.name: channels.conversion(c).si for c in channels.used}}
        units |= channels.made()
        info = {
            "source": log.path.name,
            "raster": channels.raster,
            "inputs": channels.of_role("input"),
            "outputs": channels.of_role("output"),
        }
        info |= {"began": log.began} if log.began else {}
        rows_of = _Rows(units, partial)
        merged = _Merged(log, channels, groups, findings, resampler)
        try:
            with table_writer(out, rows_of.units, info) as write, done_later(write) as write_later:
                for done in merged:
                    for rows in resampler.rows(done.until):
                        for time, segment, columns in flows.add(*rows):
                            write_later(rows_of.of([time, segment, *columns]))
                    progress(log.path.name, int(STEPS * done.share), STEPS)
                for time, segment, columns in flows.end():
                    write_later(rows_of.of([time, segment, *columns]))
                _check_windows(channels, merged.checks)
                if rows_of.n_row == 0:
                    raise _NoRowsError
        except _NoRowsError:
            findings.add("no rows", "", _apart(merged.checks))
    merged.compare_rasters(channels.raster)
    for check in merged.checks:
        check.end()
    _copies(merged.checks, findings)
    return Imported(
        log.path, channels, findings, merged.checks, merged.span,
        rows_of.n_row, resampler.segment + 1, flows.too_short, rows_of.excerpt.table(), log.began, rows_of.missing,
    )  # fmt: skip


def missing_in_words(missing: dict[str, int]) -> str:
    """Columns of a partial table that lack values, and in how many rows: ``"boom.p_a 50, speed 1"``."""
    return ", ".join(f"{name} {count}" for name, count in missing.items() if count) or "none"


class _Rows:
    """Rows on their way to the table: counted, and those in which all is known kept for the excerpt."""

    def __init__(self, units: dict[str, str], partial: bool) -> None:
        self.units = units | ({MISSING: "1"} if partial else {})
        self.excerpt = Excerpt(units)
        self.n_row = 0
        self.missing = dict.fromkeys(list(units)[2:], 0) if partial else None
        self._lacking = 0

    def of(self, columns: list[np.ndarray]) -> list[np.ndarray]:
        """Columns as the table has them."""
        self.n_row += len(columns[0])
        if self.missing is None:
            self.excerpt.add(columns)
            return columns
        lacks = [np.isnan(values) for values in columns[2:]]
        for name, own in zip(self.missing, lacks, strict=True):
            self.missing[name] += int(np.count_nonzero(own))
        count = np.zeros(len(columns[0]))
        for own in lacks:
            count += own
        whole = count == 0.0
        # a number of its own for each piece without a row that lacks something
        piece = columns[1] + self._lacking + np.cumsum(~whole)
        self._lacking += int(np.count_nonzero(~whole))
        self.excerpt.add([values[whole] for values in (columns[0], piece, *columns[2:])])
        return [*columns, count]


class _NoRowsError(Exception):
    """Nothing came of a log: the table is not written."""


@dataclass(frozen=True)
class _Done:
    until: float  # s, up to which all samples are there
    share: float


class _Merged:
    """Groups of a log side by side: always the one that is behind is read, so that little waits in memory."""

    def __init__(
        self, log: Log, channels: ChannelMap, groups: dict[int, list[Channel]], findings: Findings, resampler: Resampler
    ) -> None:
        time = channels.time
        source = None if log.own_clock or time is None else time.source
        kind = log.signal(source).kind if source is not None else ""
        factor = 1.0 if source is None or time is None or kind else conversion(time.unit).factor
        declared = None if log.own_clock or time is None else time.raster
        self.resampler = resampler
        self.place = {c.source: n for n, c in enumerate(channels.used)}
        self.checks: list[ChannelCheck] = []
        self.clocks: list[Clock] = []
        self.of_group: list[list[ChannelCheck]] = []
        self.sources: list[Iterator[ClockedRows]] = []
        for group, members in groups.items():
            name = source or (f"group {group}" if len(groups) > 1 else "")
            clock = Clock(name, factor, declared, channels.interval, findings, kind == "stamp")
            checks = [ChannelCheck(c, channels.conversion(c), clock, findings) for c in members]
            self.clocks.append(clock)
            self.of_group.append(checks)
            self.checks += checks
            self.sources.append(clock.rows(log.read(group, [c.source for c in members], source, findings)))
        self.checks.sort(key=lambda check: self.place[check.channel.source])

    @property
    def span(self) -> tuple[float, float]:
        """First and last time, s."""
        begun = [clock for clock in self.clocks if np.isfinite(clock.first)]
        return min((c.first for c in begun), default=0.0), max((c.last for c in begun), default=0.0)

    def compare_rasters(self, table: float) -> None:
        """Compare the fastest clock with the raster of the table."""
        if (fastest := self._fastest()) is not None:
            fastest.compare_table(table)

    def _fastest(self) -> Clock | None:
        begun = [clock for clock in self.clocks if np.isfinite(clock.raster)]
        return min(begun, key=lambda clock: clock.raster, default=None)

    def __iter__(self) -> Iterator[_Done]:
        reading = dict(enumerate(self.sources))
        shares = [0.0] * len(self.sources)
        while reading:
            behind = min(reading, key=lambda n: self.clocks[n].last)
            rows = next(reading[behind], None)
            if rows is None:
                del reading[behind]
                shares[behind] = 1.0
            else:
                shares[behind] = rows.done
                for check in self.of_group[behind]:
                    samples = check.samples(rows)
                    self.resampler.tracks[self.place[check.channel.source]].add(samples, check.raster)
            reach = max(track.reach for track in self.resampler.tracks)
            until = min((self.clocks[n].last for n in reading), default=inf) - reach
            fastest = self._fastest()
            if until > -inf and fastest is not None:  # all groups have begun, and no row is written yet
                fastest.check_table(self.resampler.raster)
            yield _Done(until, float(np.mean(shares)))


def _groups(log: Log, channels: ChannelMap) -> dict[int, list[Channel]]:
    """Channels by the group of the log that they are in."""
    groups: dict[int, list[Channel]] = {}
    for channel in channels.used:
        groups.setdefault(log.signal(channel.source).group, []).append(channel)
    if log.own_clock:
        return groups
    if channels.time is not None:
        of_time = log.signal(channels.time.source).group
        other = next((c for g, members in groups.items() if g != of_time for c in members), None)
        if other is not None:
            raise InputError(
                f"{log.path}: channel {other.source!r} has another length than the time {channels.time.source!r}; "
                "import it in a call of its own"
            )
    elif channels.interval is None:
        raise InputError(
            f"{log.path}: the map has no channel with the role 'time'; name one, or give the interval between rows "
            'as interval = "10 ms"'
        )
    return groups


def _opened(
    path: str | Path | Sequence[str | Path], channels: ChannelMap, dbc: Sequence[str | Path], findings: Findings
) -> Log:
    time = channels.time
    factor = 1.0 if time is None else conversion(time.unit).factor
    dates = None if time is None else time.dates
    return open_campaign(expand(path), None if time is None else time.source, factor, dates, findings, dbc)


def _names_and_units(log: Log, channels: ChannelMap, findings: Findings) -> None:
    if log.left_out:
        findings.add("not read", "", by_reason(log.left_out))
    used = [*channels.used, *([channels.time] if channels.time is not None and not log.own_clock else [])]
    for channel in used:
        if channel.source in log.duplicates:
            others = [s.name for s in log.signals if s.name.endswith(f"/{channel.source}")]
            findings.add(
                "duplicate", channel.source, f"others are {', '.join(map(repr, others[:5]))}" if others else ""
            )
        _compare_units(log, channels, channel, findings)


def _compare_units(log: Log, channels: ChannelMap, channel: Channel, findings: Findings) -> None:
    """Note what the units of log and map say of a channel; a pressure of the log may not become anything else."""
    signal, found = log.signal(channel.source), channels.conversion(channel)
    given = "" if channel is channels.time and signal.kind else signal.unit  # times as dates or texts come in s
    try:
        of_log = channels.conversion(channel, given) if given else found
    except InputError:
        of_log = None
    allowed = [of_log] if not signal.other_unit else [of_log, channels.conversion(channel, signal.other_unit)]
    if all(one is None or one[:3] != found[:3] for one in allowed):
        findings.add("unit", channel.source, f"the log says {given!r}, the map {channel.unit!r}")
    if of_log is not None and of_log.si == "Pa" != found.si and channel.kind != found.si:
        raise InputError(
            f"{log.path}: channel {channel.source!r} is a pressure in {given!r}, but the map's unit {channel.unit!r} measures "
            f"{unit_kind(found.si).name}: give a unit of pressure, or what is measured as kind = {unit_kind(found.si).name!r}"
        )
    if found.absolute and channels.atmosphere is None:
        findings.add("atmosphere", channel.source, f"{ATMOSPHERE / 1e5:g} bar were subtracted from {channel.unit!r}")


def _check_windows(channels: ChannelMap, checks: list[ChannelCheck]) -> None:
    """Refuse rates over windows that hold hardly any samples of what is differentiated."""
    rasters = {check.channel.name: check.raster for check in checks}
    for rate in channels.rates:
        if rate.window < 3.0 * rasters[rate.of] * (1.0 - _ROUNDING):
            raise InputError(
                f"window of derivative {rate.name!r} = {rate.window:g} s: {rate.of!r} has a sample every {rasters[rate.of]:.3g} s only; "
                f"{3.0 * rasters[rate.of]:.3g} s at least"
            )


def _apart(checks: list[ChannelCheck]) -> str:
    """Which of two channels that are never known together begins when the other one has ended; empty if none does."""
    known = [check for check in checks if check.count]
    if not known:
        return ""
    late, early = max(known, key=lambda check: check.first), min(known, key=lambda check: check.last)
    if late.first <= early.last:
        return ""
    return (
        f"{late.channel.source!r} begins at {late.first:.10g} s, when {early.channel.source!r} has ended at {early.last:.10g} s: look at their "
        "clocks, or import them apart"
    )


def _copies(checks: list[ChannelCheck], findings: Findings) -> None:
    first: dict[tuple[int, int], str] = {}
    for check in checks:
        key, source = (check.crc, check.given), check.channel.source
        if check.given < 10 or check.low == check.high:
            continue
        if key in first:
            findings.add("copy", source, f"of {first[key]!r}")
        else:
            first[key] = source
