"""The variables of a MAT file up to v7: names, shapes and classes, objects (timetables, strings) among them.

SciPy's `whosmat` ends in an error where a file holds an object. An element of a file is a type and a length, 4 bytes each, and its data; a
short one has both in 4 bytes, and up to 4 bytes of data.
"""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Literal, NamedTuple

from polydraulic.errors import InputError

_HEAD = 128  # bytes before the first element
_MATRIX, _PACKED = 14, 15  # types of elements
_CLASSES = (
    "unknown", "cell", "struct", "object", "char", "sparse", "double", "single", "int8", "uint8", "int16", "uint16", "int32", "uint32",
    "int64", "uint64", "function", "opaque",
)  # fmt: skip
_LOOKED_AT = 4096  # bytes of a variable: flags, shape and name stand first
_OLD = 0  # version of files that have elements of another kind

Order = Literal["little", "big"]


class MatVariable(NamedTuple):
    """A variable: its name, its shape, and its class; of an object also the class that it is of."""

    name: str
    shape: tuple[int, ...]
    kind: str
    object_kind: str = ""


def variables_of(path: Path) -> list[MatVariable]:
    """Variables of a file, in their order.

    Raises
    ------
    InputError
        A file that is cut off.
    """
    from scipy import io

    if io.matlab.matfile_version(path)[0] == _OLD:
        return [MatVariable(*variable) for variable in io.whosmat(path)]
    return list(_variables(path))


def _variables(path: Path) -> Iterator[MatVariable]:
    size = path.stat().st_size
    with path.open("rb") as file:
        order: Order = "big" if file.read(_HEAD)[126:128] == b"MI" else "little"
        while file.tell() < size:
            kind, length = (int.from_bytes(file.read(4), order) for _ in range(2))
            end = file.tell() + length
            if end > size:
                raise InputError(f"{path}: cannot be read as a MAT log (it is cut off after {size} bytes)")
            content = _begin_of(file, kind, length)
            if content:
                yield _variable(content, order)
            file.seek(end)


def _begin_of(file: BinaryIO, kind: int, length: int) -> bytes:
    """The first bytes of a variable; none where an element is none."""
    content = file.read(min(length, _LOOKED_AT))
    if kind == _PACKED:  # behind its own type and length
        return zlib.decompressobj().decompress(content, _LOOKED_AT)[8:]
    return content if kind == _MATRIX else b""


def _variable(data: bytes, order: Order) -> MatVariable:
    flags, rest = _element(data, order)
    number = int.from_bytes(flags[:4], order) & 0xFF
    kind = _CLASSES[number] if number < len(_CLASSES) else "unknown"
    if kind == "opaque":  # its name, the system of its class, its class; no shape
        name, rest = _element(rest, order)
        _, rest = _element(rest, order)
        return MatVariable(_text(name), (1,), kind, _text(_element(rest, order)[0]))
    shape, rest = _element(rest, order)
    sides = tuple(int.from_bytes(shape[at : at + 4], order) for at in range(0, len(shape), 4))
    return MatVariable(_text(_element(rest, order)[0]), sides, kind)


def _element(data: bytes, order: Order) -> tuple[bytes, bytes]:
    """The data of the first element, and what follows it."""
    first = int.from_bytes(data[:4], order)
    if first >> 16:  # a short one
        return data[4 : 4 + min(first >> 16, 4)], data[8:]
    length = int.from_bytes(data[4:8], order)
    return data[8 : 8 + length], data[8 + length + -length % 8 :]


def _text(data: bytes) -> str:
    return data.decode("utf-8", "replace").strip("\0 ")
