"""Bus logs decoded by databases: each message of each sender is a group with a clock of its own.

The log is read once: frames that a database knows go to a file for each message, from which blocks are decoded. A signal that is in
some frames of its message only (a multiplexed one) is in a group of these frames.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.files import Scratch
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.can.bits import unsigned
from polydraulic.measure.formats.can.blf_objects import left_unread
from polydraulic.measure.formats.can.database import CanSignal, Message, Messages, Selection, parameter_group
from polydraulic.measure.formats.can.frames import LONGEST, BusFrames, bus_frames_of
from polydraulic.measure.formats.can.transport import Transport
from polydraulic.measure.formats.log import BLOCK, Log, LogBlock, Signal
from polydraulic.measure.formats.named import GroupName, in_groups
from polydraulic.measure.formats.status_text import StatusNotes

_WAITING = 8 << 20  # bytes of frames that wait for being written


class _Key(NamedTuple):
    bus: int
    frame: int
    extended: bool


def open_can(path: Path, databases: Sequence[Path]) -> Log:
    """Open a bus log.

    Parameters
    ----------
    path : Path
        MDF4 with CAN frames, BLF or ASC.
    databases : sequence of Path
        DBC files.

    Raises
    ------
    InputError
        A file that cannot be read, databases that contradict each other, or no frame that they know.
    """
    messages = Messages(databases)
    left_out = left_unread(path) if path.suffix.lower() == ".blf" else {}
    scratch = Scratch()
    try:
        spool = _Spool(messages, scratch)
        for block in bus_frames_of(path):
            spool.add(block)
        spool.flush()
        if not spool.known:
            seen = ", ".join(sorted(spool.unknown | spool.unknown_groups)[:5]) or "none"
            raise InputError(
                f"{path}: no frame that {', '.join(p.name for p in databases)} knows; identifiers of the log: {seen}"
            )
    except BaseException:
        scratch.close()
        raise
    groups: list[tuple[_Key, tuple[Selection, ...]]] = []
    found: list[Signal] = []
    of: list[CanSignal] = []
    names: list[GroupName] = []
    for key, message in spool.known.items():
        for signal in message.signals:
            group = (key, signal.selections)
            if group not in groups:
                groups.append(group)
                names.append(_name(key, message, spool))
            found.append(Signal(signal.name, signal.unit, groups.index(group)))
            of.append(signal)
    signals, twice, also, origin = in_groups(found, names)
    left_out |= dict.fromkeys(sorted(spool.unknown), "frames that no database knows")
    left_out |= dict.fromkeys(sorted(spool.unknown_groups), "messages of several frames that no database knows")
    left_out |= spool.transport.incomplete()
    for message in messages.exact.values():
        left_out |= {name: reason for name, reason in message.left_out.items() if name not in origin}
        if all(message is not known for known in spool.known.values()):
            for signal in message.signals:
                if signal.name not in origin:
                    left_out[signal.name] = "no frame of its message is in the log"

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        key, selections = groups[group]
        notes = [StatusNotes(name, findings) for name in wanted]
        total, begun = spool.count[key], 0
        for done, records in spool.records(key):
            there = np.ones(len(records), dtype=bool)
            for field, values in selections:
                if field.n_byte > records["data"].shape[1]:
                    there[:] = False
                    continue
                there &= (records["length"] >= field.n_byte) & np.isin(unsigned(records["data"], field), values)
            records = records[there]
            rows = np.arange(begun, begun + len(records)) + 1
            begun += len(records)
            block: dict[str, np.ndarray] = {}
            for name, note in zip(wanted, notes, strict=True):
                block[name], said, short = of[origin[name]].values(records["data"], records["length"])
                note.add(rows, said)
                findings.add_rows("short frame", name, rows[short])
            text = {name: np.zeros(0, dtype=np.int64) for name in wanted}
            yield LogBlock(rows, records["time"].copy(), block, text, done / total)

    return Log(path, signals, True, read, twice, scratch.close, spool.began, also=also, left_out=left_out)


class _Spool:
    """Frames in one file for each message, sender and bus."""

    def __init__(self, messages: Messages, scratch: Scratch) -> None:
        self.messages, self.scratch = messages, scratch
        self.known: dict[_Key, Message] = {}
        self.unknown: set[str] = set()
        self.unknown_groups: set[str] = set()
        self.transport = Transport()
        self.count: dict[_Key, int] = {}
        self.began = 0.0
        self._files: dict[_Key, Path] = {}
        self._parts: dict[_Key, list[bytes]] = {}
        self._waiting = 0

    def add(self, block: BusFrames) -> None:
        """Sort the frames of a block."""
        self.began = self.began or block.began
        if self.messages.groups:  # a bus of J1939
            alone, put_together = self.transport.split(block)
            block = BusFrames(
                block.time[alone], block.bus[alone], block.frame[alone], block.extended[alone], block.length[alone], block.data[alone],
                block.began,
            )  # fmt: skip
            for whole in put_together:
                self._add_whole(_Key(whole.bus, whole.frame, True), whole.time, whole.data)
        code = (block.bus << 30) | (block.frame << 1) | block.extended
        for one in np.unique(code).tolist():
            key = _Key(one >> 30, (one >> 1) & 0x1FFFFFFF, bool(one & 1))
            message = self._message(key)
            if message is None:
                self.unknown.add(f"{key.frame:#x}" + ("x" if key.extended else ""))
                continue
            rows = np.flatnonzero(code == one)
            records = np.zeros(len(rows), dtype=_record(message))
            records["time"], records["length"] = block.time[rows], block.length[rows]
            records["data"][:, :LONGEST] = block.data[rows, : records["data"].shape[1]]
            self._keep(key, records)
        if self._waiting > _WAITING:
            self.flush()

    def _add_whole(self, key: _Key, time: float, data: bytes) -> None:
        """Add a message that was put together from several frames."""
        message = self._message(key)
        if message is None:
            self.unknown_groups.add(f"PGN {parameter_group(key.frame):#06x} ({parameter_group(key.frame)})")
            return
        records = np.zeros(1, dtype=_record(message))
        width = min(len(data), records["data"].shape[1])
        records["time"], records["length"] = time, len(data)
        records["data"][0, :width] = np.frombuffer(data, dtype=np.uint8, count=width)
        self._keep(key, records)

    def _message(self, key: _Key) -> Message | None:
        """Return what is known of frames with an identifier, and begin their file if it is the first."""
        message = self.known.get(key) or self.messages.find(key.frame, key.extended)
        if message is not None and key not in self.known:
            self.known[key], self.count[key] = message, 0
            self._files[key], self._parts[key] = self.scratch.folder / str(len(self._files)), []
        return message

    def _keep(self, key: _Key, records: np.ndarray) -> None:
        self._parts[key].append(records.tobytes())
        self._waiting += records.nbytes
        self.count[key] += len(records)

    def flush(self) -> None:
        """Write what waits."""
        for key, parts in self._parts.items():
            if parts:
                with self.scratch.writing(), self._files[key].open("ab") as file:
                    file.writelines(parts)
                parts.clear()
        self._waiting = 0

    def records(self, key: _Key) -> Iterator[tuple[int, np.ndarray]]:
        """Frames of a message in blocks, with the number of those that have been read."""
        kind = _record(self.known[key])
        for begun in range(0, self.count[key], BLOCK):
            part = np.fromfile(self._files[key], dtype=kind, count=BLOCK, offset=begun * kind.itemsize)
            yield begun + len(part), part


def _record(message: Message) -> np.dtype:
    return np.dtype([("time", "<f8"), ("length", "<i8"), ("data", "u1", (max(1, message.length),))])


def _name(key: _Key, message: Message, spool: _Spool) -> GroupName:
    """Name of a message, with its sender and bus where there are several."""
    same = [k for k, m in spool.known.items() if m is message]
    label = message.name
    if len({k.frame for k in same}) > 1:
        label += f"@{key.frame & 0xFF:#04x}"
    if len({k.bus for k in same}) > 1:
        label += f"@bus{key.bus}"
    return GroupName(label)
