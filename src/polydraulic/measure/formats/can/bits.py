"""Numbers out of the data bytes of many frames at once."""

from typing import NamedTuple

import numpy as np


class Field(NamedTuple):
    """Where a number lies in the data bytes.

    Attributes
    ----------
    start : int
        Bit 0 is the lowest of byte 0, bit 8 the lowest of byte 1. Of the lowest bit of the number; of its highest if `big`.
    length : int
        Bits, 64 at most.
    big : bool
        Whether the number goes on in the next byte with its lower bits (Motorola) or its higher ones (Intel).
    """

    start: int
    length: int
    big: bool

    @property
    def n_byte(self) -> int:
        """How many data bytes a frame must have to hold the number."""
        if self.big:
            beyond = max(0, self.length - self.start % 8 - 1)
            return self.start // 8 + 1 + -(-beyond // 8)
        return (self.start + self.length - 1) // 8 + 1


def unsigned(data: np.ndarray, field: Field) -> np.ndarray:
    """Whole numbers from 0.

    Parameters
    ----------
    data : (n, n_byte) array of uint8
        Zeros where a frame has no bytes.
    field : Field
        Must lie within the bytes.

    Returns
    -------
    (n,) array of uint64
    """
    found = np.zeros(len(data), dtype=np.uint64)
    left, byte, bit, done = field.length, field.start // 8, field.start % 8, 0
    while left:
        take = min(bit + 1 if field.big else 8 - bit, left)
        low = bit + 1 - take if field.big else bit
        part = ((data[:, byte] >> np.uint8(low)) & np.uint8((1 << take) - 1)).astype(np.uint64)
        if field.big:
            found = (found << np.uint64(take)) | part
        else:
            found |= part << np.uint64(done)
        left, done, byte, bit = left - take, done + take, byte + 1, 7 if field.big else 0
    return found


def as_number(raw: np.ndarray, length: int, *, signed: bool = False, real: bool = False) -> np.ndarray:
    """Numbers that bits stand for: two's complement, IEEE 754, or as they are.

    Parameters
    ----------
    raw : (n,) array of uint64
    length : int
        Bits.
    signed, real : bool
        How the bits are to be read.

    Returns
    -------
    (n,) array of float
    """
    if real:
        whole, kind = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}[length]
        return raw.astype(whole).view(kind).astype(np.float64)
    if not signed:
        return raw.astype(np.float64)
    shift = np.uint64(64 - length)
    return ((raw << shift).view(np.int64) >> np.int64(64 - length)).astype(np.float64)
