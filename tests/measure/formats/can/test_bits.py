"""Numbers out of data bytes, against an own decoder that goes bit by bit."""

import struct

import numpy as np
import pytest

from polydraulic.measure.formats.can.bits import Field, as_number, unsigned


def bits_of(payload: bytes, start: int, length: int, big: bool) -> list[int]:
    """Bits of a number, the highest first, each looked up in its byte."""
    if not big:
        return [payload[k // 8] >> (k % 8) & 1 for k in range(start + length - 1, start - 1, -1)]
    byte, bit = divmod(start, 8)
    found = []
    for _ in range(length):
        found.append(payload[byte] >> bit & 1)
        byte, bit = (byte, bit - 1) if bit else (byte + 1, 7)
    return found


def test_every_place_and_length_in_eight_bytes():
    rng = np.random.default_rng(3)
    data = rng.integers(0, 256, (6, 8), dtype=np.uint8)
    data[0], data[1] = 0xFF, 0x00
    checked = 0
    for start in range(64):
        for length in range(1, 65):
            for big in (False, True):
                field = Field(start, length, big)
                last = 8 * (start // 8) + 7 - start % 8 + length if big else start + length
                assert (field.n_byte > 8) == (last > 64)
                if field.n_byte > 8:
                    continue
                strings = ["".join(map(str, bits_of(bytes(row), start, length, big))) for row in data]
                expected = [int(text, 2) for text in strings]
                found = unsigned(data, field)
                assert found.tolist() == expected
                two = [n - 2**length if text[0] == "1" else n for n, text in zip(expected, strings, strict=True)]
                assert np.array_equal(as_number(found, length, signed=True), np.array(two, dtype=float))
                checked += 1
    assert checked > 4000


@pytest.mark.parametrize(("kind", "length"), [("e", 16), ("f", 32), ("d", 64)])
@pytest.mark.parametrize("big", [False, True])
def test_numbers_with_a_fraction(kind, length, big):
    values = [0.0, -1.5, 3.140625, 65504.0]
    rows = [struct.pack((">" if big else "<") + kind, value).ljust(8, b"\0") for value in values]
    data = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(4, 8)
    raw = unsigned(data, Field(7 if big else 0, length, big))
    assert as_number(raw, length, real=True).tolist() == values


def test_a_number_ends_in_the_byte_that_holds_its_last_bit():
    assert Field(0, 8, False).n_byte == 1
    assert Field(4, 8, False).n_byte == 2
    assert Field(7, 8, True).n_byte == 1
    assert Field(3, 12, True).n_byte == 2
    assert Field(3, 13, True).n_byte == 3
