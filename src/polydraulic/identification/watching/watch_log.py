"""A log of a machine, watched for faults: residuals against the machine of a file, and what is to be expected of them, from healthy work."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.display import dated, moment
from polydraulic.errors import InputError
from polydraulic.identification.arguments import PartTimes, table_of, times_of_parts, whole_rows
from polydraulic.identification.doubts.channels import channel_doubts
from polydraulic.identification.log_pieces import raster_of, segment_column
from polydraulic.identification.noise import noise_level
from polydraulic.identification.plausible import UNITS, check_plausible, check_units
from polydraulic.identification.watching.fault_networks import networks_ending, networks_for
from polydraulic.pages.text import text_table
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table, began
from polydraulic.watch.blocks import BlockShape, piece_ends, starts_of
from polydraulic.watch.channels import pump_columns
from polydraulic.watch.expected import Expected
from polydraulic.watch.learning import FALSE_ALARMS, learn_expected
from polydraulic.watch.naming import FaultNetworks, Opinion
from polydraulic.watch.sequential import check_rate
from polydraulic.watch.watch import FREEZE, Alarm, FaultWatch, Outlook
from polydraulic.watch.watched import Watched, watched

_MOST_LEARNT, _RUN = 1800, 60  # blocks that are learnt from, since memory grows with them; of a run
ALARM_HEADS = ("since", "seen", "until", "what", "sure", "or else")
_OWN_SHARE, _OWN_MOST = 1.0 / 3.0, 600.0  # of a log that is taken for healthy if none is given, and s
_AT_ONCE = 64  # blocks between two words of progress
_RASTERS = 0.01  # by which two of them may differ
_NAMED = 6
_SHORT = 0.05  # min, which nobody asks about: beginning and end of a log without gaps


@dataclass(frozen=True, eq=False)
class WatchedLog:
    """What a log says of a machine; ``str()`` says it in words.

    Attributes
    ----------
    of : Watched
        Machine, sensors and faults that were watched.
    alarms : list of Alarm
    findings : list of Outlook
        Of every fault: whether the smallest size that counts would have shown.
    expected : Expected
    healthy : str
        Where that was learnt from, in words.
    source : str
        Name of the log.
    rate : float
        False alarms per hour that the tests were set to.
    time : (n_block,) array, s
        When each block ends.
    evidence : (n_block, n_direction) array
        Of each direction, as a share of the threshold.
    began : float, s since 1970
        When the log's time was zero; 0 if that is not known, or its times are dates themselves.
    parts : tuple of PartTimes
        Of several logs, which times are of which.
    not_judged : str
        How much of the log was not judged, and why; empty if next to nothing.
    doubts : tuple of str
        Channels of the log, or of the healthy one, that contradict each other: nothing that is learnt from them is to be trusted.
    """

    of: Watched
    alarms: list[Alarm]
    findings: list[Outlook]
    expected: Expected = field(repr=False)
    healthy: str
    source: str
    rate: float
    time: np.ndarray = field(repr=False)
    evidence: np.ndarray = field(repr=False)
    began: float = 0.0
    parts: tuple[PartTimes, ...] = ()
    not_judged: str = ""
    doubts: tuple[str, ...] = ()

    @property
    def faulty(self) -> bool:
        """Whether there is an alarm that is not of unusual work alone, or a contradiction between channels."""
        return bool(self.doubts) or any(not (alarm.suspects and alarm.suspects[0].harmless) for alarm in self.alarms)

    def text(self) -> str:
        """What was found, and what could not be told."""
        minutes = len(self.time) * self.of.shape.seconds / 60.0
        lines = [
            f"{self.source}: {minutes:.1f} min of {self.of.machine.title} watched by {len(self.of.columns)} sensors, "
            f"{len(self.findings)} faults; what is to be expected from {self.healthy}"
        ]
        lines += [f"warning: {doubt}" for doubt in self.doubts]
        if self.not_judged:
            lines.append(f"not judged: {self.not_judged}")
        if self.alarms:
            lines += text_table(alarm_heads(self.alarms), alarm_rows(self.alarms, self.began, self.parts))
        else:
            lines.append(f"no alarm (set to {self.rate:g} false ones per hour)")
        shown = [f for f in self.findings if f.could_show]
        unsure = [f.name for f in self.findings if not f.could_show]
        lines.append(f"{len(shown)} of {len(self.findings)} faults would have shown in their smallest sizes")
        if unsure:
            lines.append(f"cannot tell: {', '.join(unsure)}")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.text()


def named_by(alarm: Alarm) -> list[str]:
    """Faults that an alarm is of: the most likely one, or all sensors that stay."""
    names = [suspect.name for suspect in alarm.suspects]
    return names if names and names[0].endswith(FREEZE) else names[:1]


def alarm_heads(alarms: Sequence[Alarm]) -> tuple[str, ...]:
    """What stands over `alarm_rows`: what networks say only if there were some."""
    return (*ALARM_HEADS, "networks") if any(alarm.opinion for alarm in alarms) else ALARM_HEADS


def alarm_rows(alarms: Sequence[Alarm], zero: float = 0.0, parts: Sequence[PartTimes] = ()) -> list[list[str]]:
    """Texts under `alarm_heads`; times are dates where time zero, in s since 1970, is known, those of joined logs are of the log they are in."""

    def times(alarm: Alarm) -> list[str]:
        found, before = [], ""
        for t in alarm[:3]:
            own = next((part for part in reversed(parts) if part.begins <= t), None)
            shown = moment(t + zero) if dated(t + zero) else f"{t - (own.shift if own else 0.0):.1f} s"
            found.append(f"{shown} of {own.name}" if own and own.name != before else shown)
            before = own.name if own else ""
        return found

    def networks(alarm: Alarm) -> list[str]:
        if len(alarm_heads(alarms)) == len(ALARM_HEADS):
            return []
        return ["-" if alarm.opinion is None else opinion_words(alarm.opinion)]

    rows = []
    for alarm in alarms:
        if not alarm.suspects:
            rows.append(
                [*times(alarm), "something that no fault of the catalogue explains", "-", "-", *networks(alarm)]
            )
            continue
        first, *others = alarm.suspects
        what = f"{first.title} (no fault: unusual work)" if first.harmless else first.title
        if first.name.endswith(FREEZE):  # each for itself, whatever the others do
            what, others = " and ".join(s.title for s in alarm.suspects), []
        more = "; ".join(f"{s.name} ({s.probability:.0%})" for s in others) or "-"
        rows.append([*times(alarm), what, f"{min(first.probability, 0.99):.0%}", more, *networks(alarm)])
    return rows


def opinion_words(opinion: Opinion) -> str:
    """What networks say, and how sure that is."""
    doubt = "" if opinion.known else ", unlike what was learnt"
    return f"{opinion.kind.replace('_', ' ')} ({min(opinion.certainty, 0.99):.0%}{doubt})"


def watch_log(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine | str | Path,
    *,
    healthy: Table | str | Path | Sequence[Table | str | Path] | None = None,
    sensors: Sequence[str] | None = None,
    rate: float = FALSE_ALARMS,
    networks: FaultNetworks | str | Path | None = None,
    progress: Progress = quiet,
) -> WatchedLog:
    """Watch a machine through its log.

    Parameters
    ----------
    log : Table, str, Path or sequence of them
        Imported, in SI: ``time`` and what sensors there are of ``NAME.voltage``, ``.spool``, ``.p_a``, ``.p_b``, ``.q_in``, ``.q_out``,
        ``.angle`` (``.position`` of a joint that slides), and of circuits ``NAME.p_pump``.
    machine : LayoutMachine, str or Path
        The healthy machine: identified from a log of its own, or as it is described.
    healthy : as log, optional
        From which noise of sensors and errors of the machine are learnt; without, the first third of the log, ten minutes at most, counts as
        healthy and is not judged.
    sensors : sequence of str, optional
        Patterns of columns that are read (``*.p_?``); all if not given.
    rate : float
        False alarms per hour of all tests together that they are set to.
    networks : FaultNetworks, str or Path, optional
        Abductive networks that name the kind of a fault as well. Of a file (``.json``) that is not there yet they are learnt, from simulated
        faults of the machine, and written.
    progress : Progress, optional

    Returns
    -------
    WatchedLog

    Raises
    ------
    InputError
        Columns that are missing, not in SI or of no such machine; too little healthy work; another raster; sensors by which nothing can be
        watched; networks of another machine or other sensors.
    """
    check_rate(rate)
    if isinstance(networks, str | Path):
        networks_ending(networks)
    plant = as_machine(machine)
    every, source = _checked(log, plant)
    columns = watched_columns(plant, every, source, sensors)
    table = _rows_of(every, columns)
    doubts = [doubt.text for doubt in channel_doubts(plant, table)]
    raster = raster_of(table)
    of = watched(plant, columns, raster)
    progress("learn", 0, 1)
    of_healthy = _own_beginning(table) if healthy is None else _given_healthy(healthy, plant, columns, raster, source)
    try:
        expected = learnt_from(of, of_healthy.table, of_healthy.rows, rate)
    except InputError as error:
        raise InputError(f"{of_healthy.words}: {error}") from error
    first = int(of_healthy.rows.sum()) if healthy is None else 0
    starts = starts_of(table["time"][first:], segment_column(table)[first:], of.shape) + first
    if not len(starts):
        raise InputError(f"{source}: no piece of {of.shape.rows * raster:.3g} s without a gap is left to be watched")
    named = None if networks is None else networks_for(networks, of, expected, progress)
    watch, seen = FaultWatch(of, expected, rate, named), np.empty((len(starts), len(of.directions)))

    def note() -> None:
        seen[watch.blocks - 1] = watch.shares

    for k in range(0, len(starts), _AT_ONCE):
        progress("watch", k, len(starts))
        part = starts[k : k + _AT_ONCE]
        watch.judge(log_blocks(of, table, part), table["time"][part + of.shape.before], note)
    ends = table["time"][starts + of.shape.before] + of.shape.seconds
    return WatchedLog(
        of,
        watch.alarms,
        watch.findings(),
        expected,
        of_healthy.words,
        source,
        rate,
        ends,
        seen,
        began(table),
        times_of_parts(table),
        _not_judged(table, first, len(starts), of.shape, len(every) - len(table)),
        (*doubts, *of_healthy.doubts),
    )


class _Healthy(NamedTuple):
    """Rows that are taken for healthy, (n_row,) of bool of a table, what they are called, and what contradicts what there."""

    table: Table
    rows: np.ndarray
    words: str
    doubts: Sequence[str] = ()


def _own_beginning(table: Table) -> _Healthy:
    """The beginning of the log itself."""
    after = table["time"] - table["time"][0]
    rows = after < min(_OWN_SHARE * float(after[-1]), _OWN_MOST)
    return _Healthy(table, rows, f"its first {after[max(int(rows.sum()) - 1, 0)]:.0f} s, taken for healthy")


def _given_healthy(
    log: Table | str | Path | Sequence[Table | str | Path],
    machine: LayoutMachine,
    columns: Sequence[str],
    raster: float,
    source: str,
) -> _Healthy:
    """Another log, read by the same sensors on the same raster as the one that is watched, which is called `source`."""
    given, name = _checked(log, machine)
    if missing := [c for c in columns if c not in given.names]:
        raise InputError(
            f"{name}: no column {', '.join(map(repr, missing[:_NAMED]))}, which {source} has; watch both by the same sensors"
        )
    table = _rows_of(given, columns)
    if abs(raster_of(table) / raster - 1.0) > _RASTERS:
        raise InputError(
            f"{name} has a row every {raster_of(table):g} s, {source} every {raster:g} s: import both on one raster"
        )
    doubts = [f"{name}: {doubt.text}" for doubt in channel_doubts(machine, table)]
    return _Healthy(table, np.ones(len(table), dtype=bool), f"{len(table)} rows of {name}", doubts)


def _not_judged(table: Table, first: int, blocks: int, shape: BlockShape, silent: int = 0) -> str:
    """How much of a log whose rows are judged from `first` on is in no block, and why, in words; `silent` rows lack a sensor."""
    minutes = shape.raster / 60.0
    own, left = first * minutes, (len(table) - first - blocks * shape.inside) * minutes
    pieces = len(piece_ends(table["time"][first:], segment_column(table)[first:], shape.raster)) + 1
    reasons = [f"{own:.1f} min are what is taken for healthy"] if first else []
    if silent:
        reasons.append(f"{silent * minutes:.1f} min are rows in which a sensor that is watched has no value")
    if left >= _SHORT:
        each = f"each of {pieces} pieces" if pieces > 1 else "the one piece"
        reasons.append(
            f"{left:.1f} min are, of {each} without a gap, the first {shape.before * shape.raster:.3g} s and the last "
            f"{shape.after * shape.raster:.3g} s, which filters need, and what fills no block of {shape.seconds:.3g} s"
        )
    lost = silent * minutes
    whole = f"{own + left + lost:.1f} of the {len(table) * minutes + lost:.1f} min that the rows last"
    return f"{whole}: {'; '.join(reasons)}" if reasons else ""


def _checked(log: Table | str | Path | Sequence[Table | str | Path], machine: LayoutMachine) -> tuple[Table, str]:
    table, source = table_of(log, partial=True)
    if "time" not in table.names:
        raise InputError(f"{source}: no column 'time'; a machine is watched by an imported log")
    check_units(table)
    check_plausible(machine, table)
    return table, source


def _rows_of(table: Table, columns: Sequence[str]) -> Table:
    """Rows in which all sensors that are watched have a value."""
    return whole_rows(table, ["time", *(name for name in table.names if name == "segment"), *columns])


def watched_columns(
    machine: LayoutMachine, table: Table, source: str, sensors: Sequence[str] | None
) -> tuple[str, ...]:
    """Columns of sensors of the machine's functions that are to be read."""
    known = []
    for f in machine.functions:
        place = position_column(machine, f)
        known += [f"{f.name}.{what}" for what in UNITS if what not in ("angle", "position", "p_pump")] + [place]
    known += pump_columns(machine)
    found = [name for name in known if name in table.names]
    if not found:
        raise InputError(
            f"{source}: no column is of a sensor of {machine.title!r}, such as {', '.join(known[:_NAMED])}; it has {', '.join(table.names)}"
        )
    if sensors is None:
        return tuple(found)
    if isinstance(sensors, str):
        raise InputError(f"sensors = {sensors!r}: must be a list, for example [{sensors!r}]")
    for pattern in sensors:
        if not any(fnmatchcase(name, pattern) for name in found):
            raise InputError(
                f"--sensors {pattern!r}: no column of {source} is called so; it has {', '.join(found) or 'none'}"
            )
    return tuple(name for name in found if any(fnmatchcase(name, pattern) for pattern in sensors))


def log_blocks(of: Watched, table: Table, starts: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of blocks of a log that begin at these rows, (n_block, n_row) each."""
    rows = starts[:, None] + np.arange(of.shape.rows)
    return {name: table[name][rows] for name in of.columns}


def learnt_from(of: Watched, table: Table, rows: np.ndarray, rate: float) -> Expected:
    """What is to be expected, from the rows of a log that are healthy, (n_row,) of bool."""
    values = {name: table[name][rows] for name in of.columns}
    time, segment = table["time"][rows], segment_column(table)[rows]
    starts = starts_of(time, segment, of.shape)
    if len(starts) > _MOST_LEARNT:  # whole runs from all over, so that what goes together in time stays together
        runs = np.array_split(starts, len(starts) // _RUN)
        chosen = np.linspace(0.0, len(runs) - 1.0, _MOST_LEARNT // _RUN).astype(int)
        starts = np.concatenate([runs[k] for k in chosen])
    at = starts[:, None] + np.arange(of.shape.rows)
    noise = {name: noise_level(column, segment) for name, column in values.items()}
    return learn_expected(of, {name: column[at] for name, column in values.items()}, noise, rate)
