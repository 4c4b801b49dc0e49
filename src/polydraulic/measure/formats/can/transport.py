"""Transport protocol of J1939: messages of more than 8 bytes, put together from the frames that carry them.

A frame of connection management announces a message (to all, BAM, or to one, RTS); frames of data transfer follow, each with its number and
7 bytes. A message is kept only if all of them are there.
"""

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from polydraulic.measure.formats.can.frames import BusFrames

_MANAGEMENT, _DATA = 0xEC, 0xEB  # formats of their identifiers
_REQUEST, _BROADCAST, _ABORT = 16, 32, 255  # what the first byte of a frame of management says
_ALL = 255  # the destination of a broadcast
_PRIORITY = 6  # of an identifier that is made for a message put together
_BYTES = 7  # that a frame of data carries
_LONGEST_PAUSE = 1.25  # s between frames of one message, the longest time limit of the standard


class Whole(NamedTuple):
    """A message that was put together: time of its last frame in s, bus, identifier and bytes."""

    time: float
    bus: int
    frame: int
    data: bytes


class _Session:
    """A message that has been announced."""

    def __init__(self, time: float, data: bytes, broadcast: bool) -> None:
        self.last, self.broadcast = time, broadcast
        self.size, self.packets = data[1] | data[2] << 8, data[3]
        self.group = data[5] | data[6] << 8 | data[7] << 16
        self.parts: dict[int, bytes] = {}


class Transport:
    """Puts messages together, block by block."""

    def __init__(self) -> None:
        self._open: dict[tuple[int, int, int], _Session] = {}  # bus, source, destination
        self._lost: Counter[int] = Counter()  # messages without all of their frames, by group
        self._strange = 0  # frames of data that nobody announced

    def split(self, block: BusFrames) -> tuple[np.ndarray, list[Whole]]:
        """Which frames of a block are messages by themselves, (n,) array of bool, and messages that others of them end."""
        form = (block.frame >> 16) & 0xFF
        ours = block.extended & ((form == _MANAGEMENT) | (form == _DATA))
        return ~ours, list(self._whole(block, np.flatnonzero(ours)))

    def incomplete(self) -> dict[str, str]:
        """What could not be put together, with the reason."""
        for session in self._open.values():
            self._lost[session.group] += 1
        self._open.clear()
        found = {
            f"PGN {group:#06x} ({group}): {n} message(s)": "messages of several frames, not all of which are in the log"
            for group, n in sorted(self._lost.items())
        }
        if self._strange:
            found[f"{self._strange} frame(s) of messages of several frames"] = "their announcement is not in the log"
        return found

    def _whole(self, block: BusFrames, rows: np.ndarray) -> Iterable[Whole]:
        for row in rows.tolist():
            time, bus, frame = float(block.time[row]), int(block.bus[row]), int(block.frame[row])
            data = block.data[row, : block.length[row]].tobytes()
            source, destination = frame & 0xFF, (frame >> 8) & 0xFF
            if len(data) < 8:
                self._strange += 1
            elif (frame >> 16) & 0xFF == _MANAGEMENT:
                self._manage(time, (bus, source, destination), data)
            elif (whole := self._carry(time, (bus, source, destination), data)) is not None:
                yield whole

    def _manage(self, time: float, key: tuple[int, int, int], data: bytes) -> None:
        bus, source, destination = key
        if data[0] in (_REQUEST, _BROADCAST):
            self._drop(key)
            session = _Session(time, data, destination == _ALL)
            if -(-session.size // _BYTES) == session.packets and session.size > 8:
                self._open[key] = session
            else:
                self._lost[session.group] += 1
        elif data[0] == _ABORT:  # by either of the two
            self._drop(key)
            self._drop((bus, destination, source))

    def _carry(self, time: float, key: tuple[int, int, int], data: bytes) -> Whole | None:
        session = self._open.get(key)
        if session is None:
            self._strange += 1
            return None
        number = data[0]
        late = time - session.last > _LONGEST_PAUSE
        if late or not 1 <= number <= session.packets or (session.broadcast and number != len(session.parts) + 1):
            self._drop(key)  # a frame is missing, or is of a message whose announcement is
            return None
        session.last, session.parts[number] = time, data[1:8]
        if len(session.parts) < session.packets:
            return None
        del self._open[key]
        bus, source, destination = key
        whole = b"".join(session.parts[n] for n in range(1, session.packets + 1))[: session.size]
        group = session.group if (session.group >> 8) & 0xFF >= 240 else session.group & 0x3FF00 | destination
        return Whole(time, bus, _PRIORITY << 26 | group << 8 | source, whole)

    def _drop(self, key: tuple[int, int, int]) -> None:
        session = self._open.pop(key, None)
        if session is not None:
            self._lost[session.group] += 1
