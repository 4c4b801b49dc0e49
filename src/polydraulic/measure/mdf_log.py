"""MDF4 logs: groups of channels, each group with a clock of its own."""

from collections.abc import Iterator, Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.conversion import need
from polydraulic.measure.findings import Findings
from polydraulic.measure.logs import BLOCK, Block, Log, Signal, once


def open_mdf(path: Path) -> Log:
    """Open an MDF4 log; see `polydraulic.measure.logs.open_log`."""
    library = need("asammdf")
    try:
        file = library.MDF(path)
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
    except InputError:
        raise
    except Exception as error:  # asammdf raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as an MDF log ({error})") from error
    if not found:
        raise InputError(f"{path}: the log has no channels with a clock and rows")
    signals, twice = once(found)

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[Block]:
        total = int(file.groups[group].channel_group.cycles_nr)
        for begun in range(0, total, BLOCK):
            count = min(BLOCK, total - begun)
            with redirect_stdout(StringIO()):  # asammdf prints its speed when a disk is slow
                parts = file.select(
                    [(name, *place[name]) for name in wanted],
                    record_offset=begun,
                    record_count=count,
                    ignore_value2text_conversions=True,
                )
            values, text = {}, {}
            for name, part in zip(wanted, parts, strict=True):
                values[name], text[name] = _numbers(part)
            clock = parts[0].timestamps
            yield Block(np.arange(begun, begun + len(clock)) + 1, clock, values, text, (begun + count) / total)

    return Log(path, signals, True, read, twice, file.close)


def _unit(channel: Any) -> str:
    unit = channel.unit or (channel.conversion.unit if channel.conversion else "")
    return str(unit or "").strip("\0 ")


def _numbers(part: Any) -> tuple[np.ndarray, np.ndarray]:
    samples = part.samples
    if samples.ndim != 1 or samples.dtype.kind not in "fiub":
        return np.full(len(samples), np.nan), np.arange(len(samples))
    values = samples.astype(np.float64)
    if part.invalidation_bits is not None:
        values = np.where(np.asarray(part.invalidation_bits, dtype=bool), np.nan, values)
    return values, np.zeros(0, dtype=np.int64)
