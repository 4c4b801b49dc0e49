"""MDF4 logs: groups of channels, each group with a clock of its own."""

from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from datetime import UTC
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import Log, LogBlock, Signal, once
from polydraulic.measure.log_units import need

_FRAGMENT = 4 << 20  # bytes of a block


def open_mdf(path: Path) -> Log:
    """Open an MDF4 log; see `polydraulic.measure.formats.logs.open_log`."""
    library = need("asammdf")
    raw = path.open("rb")  # a path would be mapped into memory as a whole

    def close() -> None:
        file.close()
        raw.close()

    try:
        file = library.MDF(raw)
        file.configure(read_fragment_size=_FRAGMENT)
        found: list[Signal] = []
        place: dict[str, tuple[int, int]] = {}
        for number, group in enumerate(file.groups):
            master = file.masters_db.get(number)
            if not group.channel_group.cycles_nr or master is None:
                continue
            for index, channel in enumerate(group.channels):
                if index != master:
                    found.append(Signal(channel.name, _unit(channel), number))
                    place.setdefault(channel.name, (number, index))
    except Exception as error:  # asammdf raises errors of many kinds on damaged files
        raw.close()
        raise InputError(f"{path}: cannot be read as an MDF log ({error})") from error
    if not found:
        close()
        raise InputError(f"{path}: the log has no channels with a clock and rows")
    signals, twice = once(found)

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        members = file.groups[group]
        indices = [file.masters_db[group], *(place[name][1] for name in wanted)]
        parts = [file.iter_get(group=group, index=index, samples_only=True, raw=True) for index in indices]
        conversions = [members.channels[index].conversion for index in indices]
        begun, total = 0, int(members.channel_group.cycles_nr)
        while begun < total:
            try:
                with redirect_stdout(StringIO()):  # asammdf prints its speed now and then
                    read_now: list[Any] = [next(part) for part in parts]
                columns = [_numbers(v, bits, c) for (v, bits), c in zip(read_now, conversions, strict=True)]
            except Exception as error:
                raise InputError(f"{path}: damaged after row {begun} of group {group} ({error})") from error
            rows = np.arange(begun, begun + len(columns[0])) + 1
            begun += len(rows)
            values = dict(zip(wanted, columns[1:], strict=True))
            text = {name: np.arange(len(rows) if value.dtype == object else 0) for name, value in values.items()}
            values = {n: np.full(len(rows), np.nan) if v.dtype == object else v for n, v in values.items()}
            yield LogBlock(rows, columns[0], values, text, begun / total)

    return Log(path, signals, True, read, twice, close, _began(file))


def _began(file: Any) -> float:
    """When the recording began, in s since 1970 by the clock on the wall; 0 where the file holds no time that is any."""
    try:
        return float(file.start_time.replace(tzinfo=UTC).timestamp())
    except (OSError, OverflowError, ValueError):
        return 0.0


def _unit(channel: Any) -> str:
    unit = channel.unit or (channel.conversion.unit if channel.conversion else "")
    return str(unit or "").strip("\0 ")


def _numbers(samples: np.ndarray, invalid: np.ndarray | None, conversion: Any) -> np.ndarray:
    """Values as numbers, NaN where invalid; as objects where they are none."""
    if conversion is not None:
        samples = conversion.convert(samples, ignore_value2text_conversions=True)
    if samples.ndim != 1 or samples.dtype.kind not in "fiub":
        return np.empty(len(samples), dtype=object)
    values = samples.astype(np.float64)
    return values if invalid is None else np.where(np.asarray(invalid, dtype=bool), np.nan, values)
