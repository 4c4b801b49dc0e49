"""Objects in MAT files of v5, as MATLAB writes them and no Python library does."""

import zlib

import numpy as np


def element(kind, data):
    """An element of a file of v5: its type, its length, and bytes up to a multiple of 8."""
    return np.array([kind, len(data)], dtype="<u4").tobytes() + data + bytes(-len(data) % 8)


def opaque(name, kind, *, compressed):
    """A variable of v5 that is an object: flags, its name, the system of its class, the class, and what MATLAB alone reads."""
    reference = element(6, np.array([13, 0], dtype="<u4").tobytes()) + element(
        5, np.array([6, 1], dtype="<i4").tobytes()
    )
    reference += element(1, b"") + element(6, np.array([0xDD000000, 2, 1, 1, 1, 1], dtype="<u4").tobytes())
    texts = b"".join(element(1, text.encode()) for text in (name, "MCOS", kind))
    whole = element(14, element(6, np.array([17, 0], dtype="<u4").tobytes()) + texts + element(14, reference))
    packed = zlib.compress(whole)
    return np.array([15, len(packed)], dtype="<u4").tobytes() + packed if compressed else whole
