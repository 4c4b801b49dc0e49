"""MDF logs, versions 3 and 4: groups of channels, each group with a clock of its own."""

import re
from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from datetime import UTC
from io import StringIO
from pathlib import Path
from traceback import walk_tb
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import Log, LogBlock, Signal
from polydraulic.measure.formats.mdf.conversion import Physical, physical
from polydraulic.measure.formats.mdf.formula import Formula, take_formulas
from polydraulic.measure.formats.mdf.links import circular
from polydraulic.measure.formats.named import GroupName, in_groups
from polydraulic.measure.formats.status_text import StatusNotes
from polydraulic.measure.log_units import conversion, need

_HEAD = 64 + 104  # bytes of the two blocks that every file begins with
_FRAGMENT = 4 << 20  # bytes of a block
_MASTERS = {2: "an angle", 3: "a distance", 4: "an index"}  # kinds of master that are no time
_BEYOND = "lies beyond the end of its rows: the file is damaged"
_TOO_MANY = "says that it has more rows than the file can hold: the file is damaged"
_PACKED = 1100  # bytes that one byte of a compressed block can stand for, at most
_CAN = re.compile(r"CAN_(Data|Remote|Error|Overload)Frame(\.|$)")
_BUS = re.compile(r"(CAN|LIN|FLX|ETH|MOST|KLINE|USB)_\w+")  # names that the standard of bus logging gives


def open_mdf(path: Path) -> Log:
    """Open an MDF log; see `polydraulic.measure.formats.logs.open_log`."""
    file, formulas, close = mdf_file(path)
    version = mdf_version(file)
    found: list[Signal] = []
    place: list[int] = []  # index in the group of each signal
    names: list[GroupName] = []
    left_out: dict[str, str] = {}
    factors: dict[int, float] = {}
    reasons: dict[str, None] = {}
    try:
        for number, group in enumerate(file.groups):
            master = file.masters_db.get(number)
            names.append(_group_name(group, number))
            reason = _no_rows(group, names[-1], master, version)
            if not reason and master is not None and (number, master) in formulas:
                reason = f"the time of group {names[-1].label!r} cannot be read: {formulas[number, master].reason}"
            if not reason and not rows_fit(group, path.stat().st_size, version):
                reason = f"group {names[-1].label!r} {_TOO_MANY}"
            if not reason and not within_rows(group.channels[master], group, version):
                reason = f"the time of group {names[-1].label!r} {_BEYOND}"
            if reason:
                reasons[reason] = None
            else:
                factors[number] = _seconds(group.channels[master])
            for index, channel in enumerate(group.channels):
                if index == master:
                    continue
                formula = formulas.get((number, index))
                why = reason or ("" if formula is None or formula.of is not None else formula.reason)
                why = why or ("" if within_rows(channel, group, version) else _BEYOND)
                if why:
                    left_out.setdefault(channel.name, why)
                else:
                    found.append(Signal(channel.name, _unit(channel), number))
                    place.append(index)
    except InputError:
        close()
        raise
    except Exception as error:  # asammdf raises errors of many kinds on damaged files
        close()
        raise InputError(f"{path}: cannot be read as an MDF log ({error})") from error
    if not found:
        close()
        why = "; ".join(list(reasons)[:5])
        raise InputError(f"{path}: the log has no channels with a clock and rows" + (f": {why}" if why else ""))
    signals, twice, also, origin = in_groups(found, names)
    left_out = {name: reason for name, reason in left_out.items() if name not in origin}

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        members = file.groups[group]
        indices = [file.masters_db[group], *(place[origin[name]] for name in wanted)]
        channels = [members.channels[index] for index in indices]
        fragments = _fragments(file, members)
        notes = [StatusNotes(name, findings) for name in ("", *wanted)]
        begun, total = 0, int(members.channel_group.cycles_nr)
        while begun < total:
            values: dict[str, np.ndarray] = {}
            text: dict[str, np.ndarray] = {}
            try:
                with redirect_stdout(StringIO()):  # asammdf prints its speed now and then
                    fragment = next(fragments)
                    read_now: list[Any] = [
                        file.get(
                            group=group,
                            index=index,
                            samples_only=True,
                            raw=True,
                            ignore_invalidation_bits=True,
                            data=fragment,
                        )
                        for index in indices
                    ]
                    found_now = [
                        _physical(raw, c, formulas.get((group, index)), version)
                        for (raw, _), c, index in zip(read_now, channels, indices, strict=True)
                    ]
            except Exception as error:
                raise InputError(f"{path}: damaged after row {begun} of group {group} ({error})") from error
            clock = found_now[0].values
            if clock is None:
                raise InputError(f"{path}: the time of group {names[group].label!r} is not a number")
            rows = np.arange(begun, begun + len(clock)) + 1
            begun += len(rows)
            for name, one, note, (_, invalid) in zip(wanted, found_now[1:], notes[1:], read_now[1:], strict=True):
                there = np.full(len(rows), np.nan) if one.values is None else one.values
                text[name] = np.arange(len(rows) if one.values is None else 0)
                values[name] = there if invalid is None else np.where(np.asarray(invalid, dtype=bool), np.nan, there)
                note.add(rows, one.said)
            yield LogBlock(rows, clock * factors[group], values, text, begun / total)

    return Log(path, signals, True, read, twice, close, mdf_began(file), also=also, left_out=left_out)


def _fragments(file: Any, group: Any) -> Iterator[Any]:
    """Rows of a group as they are in the file, in pieces; `iter_get` would read and unpack them once for every channel."""
    inner = getattr(file, "_mdf", file)
    return iter(inner._load_data(group))


def _physical(raw: np.ndarray, channel: Any, formula: Formula | None, version: int) -> Physical:
    bits = getattr(channel, "bit_count", None)
    found = physical(raw, channel.conversion, version=version, unit=_unit(channel), bits=bits)
    if formula is None or formula.of is None or found.values is None:
        return found
    return Physical(formula.of(found.values), found.said)


def mdf_version(file: Any) -> int:
    """First number of the version of the format."""
    return int(str(file.version)[0])


def mdf_file(path: Path) -> tuple[Any, dict[tuple[int, int], Formula], Any]:
    """Open a file with asammdf, in fragments: the file, formulas taken out of its channels, and a function that closes it."""
    library = need("asammdf")
    raw = path.open("rb")  # a path would be mapped into memory as a whole

    def close() -> None:
        file.close()
        raw.close()

    head = raw.read(_HEAD)
    if not (len(head) == _HEAD and head[:8] in (b"MDF     ", b"UnFinMF ") and head[64:68].strip(b"#")[:2] == b"HD"):
        raw.close()
        raise InputError(f"{path}: cannot be read as an MDF log (it does not begin like one)")
    if int.from_bytes(head[28:30], "little") >= 400 and circular(raw):
        raw.close()
        raise InputError(f"{path}: cannot be read as an MDF log (its lists of blocks have no end: the file is damaged)")
    raw.seek(0)
    try:
        file = library.MDF(raw, process_bus_logging=False)  # which would read values, before formulas are taken out
        file.configure(read_fragment_size=_FRAGMENT)
        _ = file.groups, file.masters_db
        formulas = take_formulas(file, mdf_version(file))
    except Exception as error:  # asammdf raises errors of many kinds on damaged files
        raw.close()
        _let_go(error)
        raise InputError(f"{path}: cannot be read as an MDF log ({error})") from error
    return file, formulas, close


def _let_go(error: Exception) -> None:
    """Give what asammdf left half made the parts that it wants to delete, or it writes a traceback of its own."""
    for frame, _ in walk_tb(error.__traceback__):
        half = frame.f_locals.get("self")
        if type(half).__module__.startswith("asammdf.blocks.mdf_v"):
            for part in ("header", "identification"):
                if not hasattr(half, part):
                    setattr(half, part, None)


def _group_name(group: Any, number: int) -> GroupName:
    name = str(getattr(group.channel_group, "acq_name", "") or "").strip("\0 ")
    comment = str(group.channel_group.comment or "").strip("\0 ")
    comment = "" if "<" in comment or "\n" in comment else comment
    others = tuple(o for o in (comment, f"group {number}") if o)
    return GroupName(name or f"group {number}", others)


def bus_events(group: Any) -> bool:
    """Whether the rows of a group are frames or events of a bus, not samples of channels: a structure with its parts."""
    names = {channel.name for channel in group.channels}
    if any(_CAN.match(name) for name in names):
        return True
    return any(_BUS.fullmatch(name) and any(n.startswith(f"{name}.") for n in names) for name in names)


def bus_frames(group: Any) -> dict[str, int]:
    """Places of the parts of CAN data frames in a group; none where it has no such frames."""
    begin = "CAN_DataFrame."
    return {c.name[len(begin) :]: n for n, c in enumerate(group.channels) if c.name.startswith(begin)}


def _no_rows(group: Any, name: GroupName, master: int | None, version: int) -> str:
    """Why a group has no rows with a time; empty if it has."""
    if bus_events(group):
        return (
            f"group {name.label!r} is a raw bus log (frames with identifiers and data bytes, no decoded signals); "
            "decode it with --dbc FILE"
        )
    if master is None:
        return f"group {name.label!r} has no time"
    channel = group.channels[master]
    kind = int(channel.sync_type) if version >= 4 else 1
    if kind != 1 and not (kind == 0 and _si(_unit(channel)) == "s"):
        what = _MASTERS.get(kind, "of no known kind")
        unit = _unit(channel)
        return (
            f"group {name.label!r} is over {channel.name!r}" + (f" [{unit}]" if unit else "") + f", {what} and no time"
        )
    return "" if group.channel_group.cycles_nr else f"group {name.label!r} has no rows"


def within_rows(channel: Any, group: Any, version: int) -> bool:
    """Whether the bits of a channel are in the rows of its group; asammdf reads what lies behind them in memory."""
    rows = group.channel_group
    if version < 4:
        begin, size = channel.start_offset + 8 * getattr(channel, "additional_byte_offset", 0), rows.samples_byte_nr
    else:
        begin, size = 8 * channel.byte_offset + channel.bit_offset, rows.samples_byte_nr + rows.invalidation_bytes_nr
    return bool(0 <= begin <= begin + channel.bit_count <= 8 * size)


def rows_fit(group: Any, size: int, version: int) -> bool:
    """Whether a file of this many bytes can hold the rows that a group is said to have."""
    rows = group.channel_group
    return bool(rows.cycles_nr * rows.samples_byte_nr <= size * (_PACKED if version >= 4 else 1))


def _seconds(channel: Any) -> float:
    """Seconds in one of a time's unit; it is seconds unless the file says so."""
    unit = _unit(channel)
    return conversion(unit).factor if _si(unit) == "s" else 1.0


def _si(unit: str) -> str:
    try:
        return conversion(unit).si if unit else ""
    except InputError:
        return ""


def mdf_began(file: Any) -> float:
    """When the recording began, in s since 1970 by the clock on the wall; 0 where the file holds no time that is any."""
    try:
        return float(file.start_time.replace(tzinfo=UTC).timestamp())
    except (OSError, OverflowError, ValueError):
        return 0.0


def _unit(channel: Any) -> str:
    unit = channel.unit or (channel.conversion.unit if channel.conversion else "")
    return str(unit or "").strip("\0 ")
