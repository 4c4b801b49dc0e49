"""Statements: what is declared where, and a clear no where there is no counterpart."""

from typing import NamedTuple

import numpy as np
import pytest

from helpers.kernels_in_c import Pair, library, refusal


class Nested(NamedTuple):
    """A struct with a large part."""

    part: Pair
    x: float
    y: float
    z: float
    more: Pair


class Outer(NamedTuple):
    """Holds the struct."""

    inner: Nested


def _swapped(x: float) -> float:
    value = Outer(Nested(Pair(x, 1.0), 2.0, 3.0, 4.0, Pair(5.0, 6.0)))
    inner = value.inner
    value = Outer(Nested(Pair(0.0, 0.0), 0.0, 0.0, 0.0, Pair(0.0, 0.0)))
    return inner.part.a + value.inner.part.a


def swapped(x: float) -> float:
    return _swapped(x)


def test_a_part_of_what_changes_later_is_copied(tmp_path):
    c, text = library(tmp_path, (swapped, [0.0]))
    assert "const Nested inner = value.inner;" in text
    assert c.swapped(7.0) == 7.0


def unbounded(x: float) -> float:
    while x < 1.0:
        x = 2.0 * x
    return x


def swap(x: float) -> float:
    a, b = x, 2.0
    a, b = b, a
    return a - b


def unpacks(x: float) -> float:
    a, b = _pair(x)
    return a + b


def _pair(x: float) -> Pair:
    return Pair(x, x)


def two_types(x: float) -> float:
    y = 0
    y = x
    return y


def no_end(x: float) -> float:
    if x > 0.0:
        return x


def steps_of_two(n: int) -> int:
    k = 0
    for i in range(0, n, 2):
        k += i
    return k


def bound_changes(v: np.ndarray, n: int) -> float:
    for i in range(n):
        n = n - 1
        v[i] = 0.0
    return v[0]


def read_after_loop(n: int) -> int:
    total = 0
    for i in range(n):
        total += i
    return i


def with_default(x: float = 1.0) -> float:
    return x


REFUSED = [
    (unbounded, 1, "has no bound"),
    (swap, 2, "a is read after it has changed"),
    (unpacks, 1, "use its fields"),
    (two_types, 2, "y is int and gets float"),
    (no_end, 0, "does not return on every path"),
    (steps_of_two, 2, "steps of 1"),
    (bound_changes, 1, "may not change inside"),
    (read_after_loop, 4, "i may be read before"),
    (with_default, 0, "without defaults"),
]


@pytest.mark.parametrize(("kernel", "line", "why"), REFUSED, ids=[kernel.__name__ for kernel, _, _ in REFUSED])
def test_what_has_no_counterpart_is_refused_with_file_and_line(kernel, line, why):
    found, message = refusal(kernel)
    assert found == line
    assert why in message
