"""Recorded drives in files: read whole, checked, and written block by block."""

import json
import os
import sys
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.cockpit.recorded.tape import FORM
from polydraulic.errors import InputError, briefly

ENDING = ".drive.jsonl"
MOST = 100 * 1024 * 1024  # bytes of a file: many hours
_HEAD = {
    "form": str,
    "machine": str,
    "flow": str,
    "dt": float,
    "functions": list,
    "of": str,
    "values": dict,
    "payload": float,
    "start": dict,
}


class Drive(NamedTuple):
    """A recorded drive.

    Attributes
    ----------
    name : str
    head : dict
        See `tape.head_of`.
    stamps : tuple of dict
        By rising ``step``: ``levers`` in V, ``payload`` in kg, ``change`` of numbers, ``reset``, ``hash`` of the state before the step.
    end : int
        Steps in all.
    whole : bool
        Whether it was ended; else the program, or the disk, ended before it.
    """

    name: str
    head: dict[str, Any]
    stamps: tuple[dict[str, Any], ...]
    end: int
    whole: bool


def drive_names(folder: Path) -> list[str]:
    """Names of the drives in a folder, latest first."""
    try:
        return sorted((path.name.removesuffix(ENDING) for path in folder.glob(f"*{ENDING}")), reverse=True)
    except OSError:
        return []


def read_drive(path: str | Path) -> Drive:
    """Read a recorded drive; what a crash has left of a last line is left out.

    Raises
    ------
    InputError
        A file that is none, or is damaged elsewhere than at its end.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MOST:
            raise InputError(f"{path}: has more than {MOST} bytes; no drive that was recorded is so long")
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        why = error.strerror if isinstance(error, OSError) else "is no text"
        raise InputError(f"{path}: cannot be read: {why}") from error
    lines = text.split("\n")[:-1]  # a whole line ends
    found = [_line(line, path, number) for number, line in enumerate(lines, 1)]
    if not found or found[0].get("form") != FORM:
        raise InputError(f"{path}: is no recorded drive of this version ({FORM})")
    head, stamps = found[0], found[1:]
    for key, kind in _HEAD.items():
        good = _finite(head.get(key)) if kind is float else isinstance(head.get(key), kind)
        if not good:
            raise InputError(f"{path}: line 1: {key} = {briefly(head.get(key))}: is damaged")
    step = 0
    for number, stamp in enumerate(stamps, 2):
        _check(stamp, step, len(head["functions"]), f"{path}: line {number}")
        step = stamp["step"]
    return Drive(path.name.removesuffix(ENDING), head, tuple(stamps), step, bool(stamps and stamps[-1].get("end")))


def new_name(folder: Path, machine: str) -> str:
    """Name of a drive that begins now, in UTC; one of the same second gets a number."""
    of = "".join(c if c.isalnum() or c in "-_" else "_" for c in Path(machine).stem)[:40]
    name = f"{datetime.now(UTC):%Y%m%d-%H%M%S}-{of}"
    taken = set(drive_names(folder))
    return next(found for k in count(1) if (found := name if k == 1 else f"{name}-{k}") not in taken)


class DriveFile:
    """A drive that is being written; blocks reach the disk before the next one.

    Raises
    ------
    OSError
    """

    def __init__(self, folder: Path, name: str) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.path, self._blocks, self._size = folder / f"{name}{ENDING}", 0, 0
        self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)

    def write(self, first: int, blocks: tuple[str, ...]) -> None:
        """Write those blocks that are not yet written.

        Parameters
        ----------
        first : int
            Number of the first one.
        blocks : tuple of str

        Raises
        ------
        InputError
            If blocks were missed, or the drive is too long.
        OSError
        """
        if first > self._blocks:
            raise InputError("the disk was too slow: parts of the drive were lost")
        new = blocks[self._blocks - first :]
        for block in new:
            content = memoryview(block.encode())
            self._size += len(content)
            if self._size > MOST:
                raise InputError(f"a drive has at most {MOST} bytes; record another one")
            while content:
                content = content[os.write(self._file, content) :]
            self._blocks += 1
        if new:
            os.fsync(self._file)

    def close(self) -> None:
        """End."""
        os.close(self._file)


def _line(line: str, path: Path, number: int) -> dict[str, Any]:
    try:
        found = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: line {number} is damaged: {briefly(line)}") from error
    if not isinstance(found, dict):
        raise InputError(f"{path}: line {number} is damaged: {briefly(line)}")
    return found


def _finite(value: Any) -> bool:
    """Whether it is a number that a float holds: JSON has NaN, and whole numbers of any length."""
    return isinstance(value, float | int) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _check(stamp: dict[str, Any], step: int, n: int, where: str) -> None:
    """Refuse a stamp that no cockpit has written."""
    levers, change = stamp.get("levers", [0.0] * n), stamp.get("change", {})
    numbers = [*levers, *change.values()] if isinstance(levers, list) and isinstance(change, dict) else [None]
    numbers.append(stamp.get("payload", 0.0))
    if (
        not isinstance(stamp.get("step"), int)
        or not step <= stamp["step"] < 2**40
        or len(numbers) != n + len(change) + 1
        or not all(map(_finite, numbers))
    ):
        raise InputError(f"{where}: is damaged: {briefly(stamp)}")
