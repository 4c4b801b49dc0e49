"""Frames of a bus log, in blocks: MDF4 bus logging through asammdf, BLF and ASC through python-can."""

from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.formats.mdf.mdf_log import bus_frames, mdf_began, mdf_file, mdf_version, rows_fit, within_rows
from polydraulic.measure.log_units import need

LONGEST = 64  # bytes of a frame (CAN FD)
_BATCH = 1 << 14  # frames
_LENGTHS = np.array([*range(9), 12, 16, 20, 24, 32, 48, 64])  # bytes by their code
_EXTENDED = 1 << 31  # mark of an identifier of 29 bits


class BusFrames(NamedTuple):
    """Data frames in the order of the file.

    Attributes
    ----------
    time : (n,) array, s
        From `began` on.
    bus : (n,) array of int
        Number of the bus.
    frame : (n,) array of int
        Identifiers.
    extended : (n,) array of bool
        Whether an identifier has 29 bits.
    length : (n,) array of int
        Bytes that a frame has.
    data : (n, LONGEST) array of uint8
    began : float, s since 1970
        0 where the file does not say.
    """

    time: np.ndarray
    bus: np.ndarray
    frame: np.ndarray
    extended: np.ndarray
    length: np.ndarray
    data: np.ndarray
    began: float


def bus_frames_of(path: Path) -> Iterator[BusFrames]:
    """Blocks of data frames of a log; an InputError where it cannot be read."""
    return _of_mdf(path) if path.suffix.lower() == ".mf4" else _of_can(path)


def _of_mdf(path: Path) -> Iterator[BusFrames]:
    file, formulas, close = mdf_file(path)
    try:
        began = mdf_began(file)
        for number, group in enumerate(file.groups):
            members = bus_frames(group)
            master = file.masters_db.get(number)
            if master is None or not {"ID", "DataBytes"} <= set(members) or not group.channel_group.cycles_nr:
                continue
            version = mdf_version(file)
            if not rows_fit(group, path.stat().st_size, version):
                raise InputError(f"{path}: there are more rows than the file can hold: the file is damaged")
            if not all(within_rows(group.channels[n], group, version) for n in (master, *members.values())):
                raise InputError(f"{path}: the parts of frames lie beyond the end of their rows: the file is damaged")
            if (number, master) in formulas:
                raise InputError(f"{path}: the time of the frames cannot be read: {formulas[number, master].reason}")
            names = [n for n in ("ID", "DataBytes", "IDE", "DataLength", "DLC", "BusChannel") if n in members]
            indices = [master, *(members[n] for n in names)]
            parts = [
                file.iter_get(group=number, index=index, samples_only=True, raw=n > 0)
                for n, index in enumerate(indices)
            ]
            done, total = 0, int(group.channel_group.cycles_nr)
            while done < total:
                with redirect_stdout(StringIO()):  # asammdf prints its speed now and then
                    time, *columns = [np.asarray(next(part)[0]) for part in parts]
                done += len(time)
                yield _columns(time, dict(zip(names, columns, strict=True)), began)
    except InputError:
        raise
    except Exception as error:  # asammdf raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as a bus log ({error})") from error
    finally:
        close()


def _columns(time: np.ndarray, found: dict[str, np.ndarray], began: float) -> BusFrames:
    n = len(time)
    frame = found["ID"].astype(np.int64)
    extended = (frame & _EXTENDED) != 0
    frame = frame & 0x1FFFFFFF
    extended |= found["IDE"].astype(bool) if "IDE" in found else frame > 0x7FF
    data = np.zeros((n, LONGEST), dtype=np.uint8)
    given = found["DataBytes"]
    if given.dtype.kind == "S":  # bytes of this kind lose their zeros at the end
        given = given.view(np.uint8).reshape(n, given.dtype.itemsize)
    if given.ndim == 2:
        data[:, : given.shape[1]] = given[:, :LONGEST]
        there = np.full(n, given.shape[1])
    else:  # of lengths of their own
        rows = [bytes(row) for row in given]
        there = np.array([len(row) for row in rows], dtype=np.int64)
        data[:] = np.frombuffer(b"".join(row[:LONGEST].ljust(LONGEST, b"\0") for row in rows), np.uint8).reshape(
            n, LONGEST
        )
    length = found["DataLength"].astype(np.int64) if "DataLength" in found else there
    if "DataLength" not in found and "DLC" in found:
        length = _LENGTHS[found["DLC"].astype(np.int64) & 0xF]
    return BusFrames(
        time,
        found.get("BusChannel", np.zeros(n)).astype(np.int64),
        frame,
        extended,
        np.minimum(length, there),
        data,
        began,
    )


def _of_can(path: Path) -> Iterator[BusFrames]:
    can = need("can", "can")
    try:
        blf = path.suffix.lower() == ".blf"
        with path.open("rb") if blf else path.open(encoding="utf-8", errors="replace") as file:
            reader = (can.BLFReader if blf else can.ASCReader)(file)
            began = float(getattr(reader, "start_timestamp", 0.0) or 0.0)
            messages = (m for m in reader if not (m.is_error_frame or m.is_remote_frame))
            while batch := list(islice(messages, _BATCH)):
                if getattr(reader, "timestamps_format", None) == "relative":  # which python-can reads as times
                    raise InputError(
                        f"{path}: each time of the log counts from the line before it (timestamps relative), and lines that are no "
                        "frames count, too: save it with absolute times"
                    )
                yield _messages(batch, began)
    except InputError:
        raise
    except Exception as error:  # python-can raises errors of many kinds on damaged files
        raise InputError(f"{path}: cannot be read as a bus log ({error})") from error


def _messages(batch: list[Any], began: float) -> BusFrames:
    data = b"".join(bytes(m.data).ljust(LONGEST, b"\0") for m in batch)
    for m in batch:
        if not 0 <= m.arbitration_id <= (0x1FFFFFFF if m.is_extended_id else 0x7FF):
            bits = 29 if m.is_extended_id else 11
            raise ValueError(
                f"the identifier {m.arbitration_id:#x} at {m.timestamp - began:g} s has more than {bits} bits"
            )
    return BusFrames(
        np.array([m.timestamp for m in batch]) - began,
        np.array([m.channel if isinstance(m.channel, int) else 0 for m in batch], dtype=np.int64),
        np.array([m.arbitration_id for m in batch], dtype=np.int64),
        np.array([m.is_extended_id for m in batch], dtype=bool),
        np.array([len(m.data) for m in batch], dtype=np.int64),
        np.frombuffer(data, dtype=np.uint8).reshape(len(batch), LONGEST),
        began,
    )
