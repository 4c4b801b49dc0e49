"""Pieces of C: numbers of both precisions, comments, strings."""

from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError


class Real(NamedTuple):
    """A floating-point type of C."""

    name: str
    suffix: str  # of literals, and of functions of math.h
    largest: str  # macro of float.h
    digits: float  # relative accuracy to expect of a network


DOUBLE = Real("double", "", "DBL_MAX", 1e-10)
FLOAT = Real("float", "f", "FLT_MAX", 1e-3)
REALS = {real.name: real for real in (DOUBLE, FLOAT)}


def literal(value: float, real: Real = DOUBLE) -> str:
    """`value` as a literal that reads back exactly, in brackets if negative.

    Raises
    ------
    InputError
        If a `float` cannot hold it.
    """
    if real is FLOAT:
        with np.errstate(over="ignore", under="ignore"):
            single = np.float32(value)
        if not np.isfinite(single) or (value != 0.0 and abs(single) < np.finfo(np.float32).tiny):
            raise InputError(f"the number {value!r} does not fit into a float: fit in other units, or export as double")
        text = str(single)
    else:
        text = repr(float(value))
    text = text if any(mark in text for mark in ".en") else f"{text}.0"
    return f"({text}{real.suffix})" if value < 0.0 else f"{text}{real.suffix}"


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
