"""Pieces of C: numbers of both precisions, comments, strings."""

from collections.abc import Sequence
from ctypes import c_float
from math import isfinite
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError


class Real(NamedTuple):
    """A floating-point type of C."""

    name: str
    suffix: str  # of literals, and of functions of math.h
    largest: str  # macro of float.h
    digits: float  # relative accuracy to expect of a network
    smallest: float  # of the numbers that keep all their digits


DOUBLE = Real("double", "", "DBL_MAX", 1e-10, float(np.finfo(np.float64).tiny))
FLOAT = Real("float", "f", "FLT_MAX", 1e-3, float(np.finfo(np.float32).tiny))
REALS = {real.name: real for real in (DOUBLE, FLOAT)}


def literal(value: float, real: Real = DOUBLE) -> str:
    """`value` as a literal that reads back exactly, in brackets if negative.

    Raises
    ------
    InputError
        If a `float` cannot hold it.
    """
    if real is FLOAT:
        single = held_in(value, real)
        if not isfinite(single) or (value != 0.0 and abs(single) < real.smallest):
            raise InputError(f"the number {value!r} does not fit into a float: fit in other units, or export as double")
        text = str(np.float32(single))
    else:
        text = repr(float(value))
    return f"({text}{real.suffix})" if value < 0.0 else f"{text}{real.suffix}"


def inner_ends(low: float, high: float, real: Real = DOUBLE) -> tuple[float, float]:
    """Ends of a range as numbers of `real`, moved inward: a number of `real` lies between them exactly if it lies in the range.

    Where the range holds no such number, both are the one nearest to its middle.
    """
    if real is DOUBLE:
        return low, high
    ends = 0.0 - rounded_down(-low, real), rounded_down(high, real)
    nearest = held_in(0.5 * low + 0.5 * high, real)
    return ends if ends[0] <= ends[1] else (nearest, nearest)


def held_in(value: float, real: Real) -> float:
    """The number of `real` that is nearest to `value`."""
    return value if real is DOUBLE else c_float(value).value


def rounded_down(value: float, real: Real = DOUBLE) -> float:
    """The largest number of `real` that does not exceed `value`: a number of `real` is above both or above neither."""
    if real is DOUBLE:
        return value
    with np.errstate(over="ignore", under="ignore"):
        single = np.float32(value)
        below = single if float(single) <= value else np.nextafter(single, np.float32(-np.inf))
    return float(below) + 0.0  # no negative zero


def listed(texts: Sequence[str], width: int) -> str:
    """Texts with commas between them, in lines that are indented and no wider than `width` unless one text is."""
    lines, line = [], "   "
    for text in [*(f"{text}," for text in texts[:-1]), texts[-1]]:
        if len(line) + 1 + len(text) > width and line.strip():
            lines.append(line)
            line = "   "
        line = f"{line} {text}"
    return "\n".join([*lines, line])


def block_comment(lines: list[str]) -> str:
    """A block comment."""
    safe = [line.replace("*/", "* /").replace("/*", "/ *").replace("??", "? ?") for line in lines]
    return "\n".join(["/*", *(f" * {one_line(line)}".rstrip() for line in safe), " */"])


def one_line(text: str) -> str:
    """`text` without line breaks."""
    return " ".join(text.split()) if "\n" in text or "\r" in text else text


def string(text: str) -> str:
    """A string literal of UTF-8 bytes."""
    plain = "".join(
        chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}" for byte in text.encode()
    )
    return f'"{plain}"'
