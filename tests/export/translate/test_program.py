"""Whole kernels in C: the same values as in Python."""

import math

import numpy as np
import pytest

from helpers.kernels_in_c import Large, Pair, library, refusal, write_two
from polydraulic import elementary
from polydraulic.errors import InputError
from polydraulic.export.translate.program import Program

LIMIT, _SHIFT = 3, 0.25


def _helper(x: Pair, n: int) -> Pair:
    """Adds up."""
    for _ in range(n):
        x = Pair(x.a + x.static, x.static)
    return x


def many_things(x: float, n: int, v: np.ndarray) -> float:
    """Everything a kernel may do: */ even this."""
    # a comment above
    total = 0.0  # and one behind
    if x > 1.0:
        sign = 1.0
    elif x < -1.0 and n > 0:
        sign = -1.0
    else:
        return min(max(x, -0.0), 0.5, _SHIFT) - 1 / n
    for i in range(n):
        if i == LIMIT:
            continue
        if (i & 1) | (i >> 2):
            total += i * x - (x - i)
            half = total / 2
        elif not (i < n - 2):
            break
        else:
            half = -(-1.0 * x)
        total = total + (half if half > 0.0 else abs(half - 2)) * sign
    pair = _helper(Pair(total, sign), n)
    written = 1.0 - max(write_two(v, pair.a), x) * 2.0  # alone among what reads no arrays
    return written - (pair.a - (pair.static - math.sqrt(abs(x))) - 1.0) - float(n) / (2 + n)


def test_statements_and_expressions_mean_the_same(tmp_path):
    c, text = library(tmp_path, (many_things, [0.0, 1, np.zeros(3)]))
    assert "/* Everything a kernel may do: * / even this. */" in text
    assert "    /* a comment above */\n    double total = 0.0; /* and one behind */" in text
    assert "} else if (x < -1.0 && n > 0) {" in text
    for x in (-7.3, -1.0, -0.2, 0.0, 0.3, 1.1, 5.0):
        for n in range(1, 9):
            ours, theirs = np.array([1.5, 2.5, x]), np.array([1.5, 2.5, x])
            assert c.many_things(x, n, ours.ctypes.data) == many_things(x, n, theirs)
            assert np.array_equal(ours, theirs)


def test_elementary_functions_have_the_same_bits(tmp_path):
    functions = (elementary.exp, elementary.log, elementary.tanh)
    c, _ = library(tmp_path, *((getattr(f, "py_func", f), [0.0]) for f in functions))
    rng = np.random.default_rng(4)
    for x in [*rng.uniform(-30.0, 30.0, 500), 0.0, -0.0, 1e-300, 700.0, -800.0, 1e308]:
        assert c.exp(x) == elementary.exp(x)
        assert c.tanh(x) == elementary.tanh(x)
        if x > 0.0:
            assert c.log(x) == elementary.log(x)


def test_a_pointer_stands_for_a_copy_only_where_nothing_changes():
    program = Program()
    program.entry("f", _read, [Large(Pair(1.0, 2.0), Pair(3.0, 4.0), 5, np.ones((2, 3)))])
    assert "const Large *again = p;" in program.code()
    assert "double static_;" in program.scope.structs()
    assert "double a; /* first */" in program.scope.structs()


def _read(p: Large) -> float:
    again = p
    return again.one.a + again.rows[0, again.n - 4]


def calls_itself(x: float) -> float:
    return x if x > 1.0 else calls_itself(x + 1.0)


def test_examples_without_counterpart_are_named():
    with pytest.raises(InputError, match="argument 0.one.a: a str, which has no counterpart"):
        Program().entry("f", _read, [Large(Pair("a", 1.0), Pair(1.0, 1.0), 1, np.zeros((2, 2)))])
    with pytest.raises(InputError, match="x_a is not a number"):
        Program().scope.data(Pair(math.nan, 1.0), "x")


def test_a_kernel_that_calls_itself_is_refused():
    assert refusal(calls_itself) == (1, " calls_itself: calls_itself calls itself; write a loop with a bound")
