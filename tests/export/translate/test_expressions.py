"""Expressions: the same choices as in Python, and a clear no where there is no counterpart."""

import math

import numpy as np
import pytest

from helpers.kernels_in_c import Pair, library, refusal, write_two


def extremes(a: float, b: float) -> float:
    return 1.0 / min(a, b) + 3.0 / max(a, b)


def test_minimum_and_maximum_choose_as_python_does(tmp_path):
    c, _ = library(tmp_path, (extremes, [0.0, 0.0]))
    values = (1.0, -2.0, math.inf, -math.inf, math.nan)
    for a in values:
        for b in values:
            assert np.array_equal(c.extremes(a, b), extremes(a, b), equal_nan=True)
    assert c.extremes(0.0, -0.0) == math.inf  # the first of two equal ones, as in Python
    assert c.extremes(-0.0, 0.0) == -math.inf


def power(x: float) -> float:
    return x**2


def chained(x: float) -> float:
    return 1.0 if 0.0 < x < 1.0 else 0.0


def unassigned(x: float) -> float:
    if x > 0.0:
        y = 1.0
    return y


def library_function(x: float) -> float:
    return math.exp(x)


def writes_inside(v: np.ndarray) -> float:
    return v[0] + write_two(v, 2.0)


def writes_twice(v: np.ndarray) -> float:
    return min(write_two(v, 2.0), write_two(v, 3.0))


def writes_through_another_name(v: np.ndarray) -> float:
    w = v
    y = write_two(w, 2.0)
    return y


def sliced(v: np.ndarray) -> float:
    return v[1:][0]


def backwards(v: np.ndarray) -> float:
    return v[-1]


def by_keyword(x: float) -> Pair:
    return Pair(a=x, static=1.0)


def allocates(n: int) -> float:
    return np.zeros(n)[0]


def rounds_down(n: int) -> int:
    return n // 2


def truth_of_a_float(x: float) -> float:
    return 1.0 if x else 2.0


def method(p: Pair) -> float:
    return p.count(1.0)


REFUSED = [
    (power, 1, "write x * x"),
    (chained, 1, "two comparisons"),
    (unassigned, 3, "y may be read before it is assigned"),
    (library_function, 1, "use polydraulic.elementary"),
    (writes_inside, 1, "give its result a name first"),
    (writes_twice, 1, "give its result a name first"),
    (writes_through_another_name, 2, "must be a parameter"),
    (sliced, 1, "must be a whole number"),
    (backwards, 1, "at least 0"),
    (by_keyword, 1, "by place"),
    (allocates, 1, "is no kernel"),
    (rounds_down, 1, "Python rounds down"),
    (truth_of_a_float, 1, "is no condition"),
    (method, 1, "is no kernel"),
]


@pytest.mark.parametrize(("kernel", "line", "why"), REFUSED, ids=[kernel.__name__ for kernel, _, _ in REFUSED])
def test_what_has_no_counterpart_is_refused_with_file_and_line(kernel, line, why):
    found, message = refusal(kernel)
    assert found == line
    assert why in message
