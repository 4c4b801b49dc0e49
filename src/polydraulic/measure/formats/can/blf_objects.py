"""The objects of a BLF log, followed once before python-can follows them: of a damaged file it may never come to an end."""

import struct
import zlib
from collections import Counter
from pathlib import Path

from polydraulic.errors import InputError

_HEAD = struct.Struct("<4sL8xQ")  # of the file: mark, size of the head, size of the file
_BASE = struct.Struct("<4sHHLL")  # mark, size of the head, its version, size, kind
_PACKED = struct.Struct("<H6xL4x")  # how the objects in a container are packed, and their size
_MARK, _CONTAINER = b"LOBJ", 10
_PLAIN, _ZLIB = 0, 2
_VERSIONS = (1, 2)  # of heads that python-can knows
_LARGEST = 1 << 26  # bytes of an object or of a container unpacked; those of loggers have some hundred kilobytes


def left_unread(path: Path) -> dict[str, str]:
    """What python-can leaves out of a BLF log without a word, with the reason.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        A file that does not begin like one; objects without a size, which it would read for ever, or so large that they cannot be any.
    """
    left: Counter[tuple[str, str]] = Counter()
    tail = b""  # the beginning of an object that goes on in the next container
    size_now = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_HEAD.size)
        if len(head) < _HEAD.size or head[:4] != b"LOGG":
            raise InputError(f"{path}: cannot be read as a bus log (it does not begin like a BLF file)")
        _, begin, size_said = _HEAD.unpack(head)
        file.seek(begin)
        while len(head := file.read(_BASE.size)) == _BASE.size:
            mark, _, _, size, kind = _BASE.unpack(head)
            if mark != _MARK or size < _BASE.size:
                raise InputError(f"{path}: cannot be read as a bus log (an object has no head: the file is damaged)")
            _check_size(path, size)
            body = file.read(size - _BASE.size)
            file.read(size % 4)
            if kind != _CONTAINER or len(body) < _PACKED.size:
                continue
            packing, _ = _PACKED.unpack_from(body)
            if packing in (_PLAIN, _ZLIB):
                content = body[_PACKED.size :]
                tail = _follow(path, tail + (content if packing == _PLAIN else _unpacked(path, content)), left)
            else:
                left["container(s)", f"packed in a way that is not known ({packing})"] += 1
    found = {f"{count} {what}": reason for (what, reason), count in left.items()}
    if size_now < size_said:  # as of a logger that lost its power; python-can reads on to the end that is there
        found["the end of the log"] = f"the file is cut off after {size_now} of {size_said} bytes"
    elif _MARK in tail:
        found["the end of the log"] = "its last object is not whole: the file is cut off or damaged"
    return found


def _follow(path: Path, data: bytes, left: Counter[tuple[str, str]]) -> bytes:
    """Go from object to object; what is left of the last one."""
    place = 0
    while True:
        begin = data.find(_MARK, place, place + 8)  # behind what pads the object before
        if begin < 0 and place + 8 <= len(data):
            raise InputError(f"{path}: cannot be read as a bus log (an object has no head: the file is damaged)")
        if begin < 0 or begin + _BASE.size > len(data):
            return data[place:]
        _, _, version, size, _ = _BASE.unpack_from(data, begin)
        if size < _BASE.size:
            raise InputError(f"{path}: cannot be read as a bus log (an object has no size: the file is damaged)")
        _check_size(path, size)
        if begin + size > len(data):
            return data[place:]
        if version not in _VERSIONS:
            left["object(s)", f"with a head that is not known (version {version})"] += 1
        place = begin + size


def _unpacked(path: Path, content: bytes) -> bytes:
    """Objects of a packed container, as far as it goes."""
    unpacker = zlib.decompressobj()
    try:
        found = unpacker.decompress(content, _LARGEST)
    except zlib.error as error:
        raise InputError(f"{path}: cannot be read as a bus log ({error})") from error
    if unpacker.unconsumed_tail:
        _check_size(path, _LARGEST + 1)
    return found


def _check_size(path: Path, size: int) -> None:
    if size > _LARGEST:
        raise InputError(
            f"{path}: cannot be read as a bus log (an object of more than {_LARGEST >> 20} MB: the file is damaged)"
        )
