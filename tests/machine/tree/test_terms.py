"""Recorded arithmetic: nothing is done twice, nothing is done with zero, and the value is that of the arithmetic."""

import math

import numpy as np
import pytest

from polydraulic.machine.tree.statements import Constants, body
from polydraulic.machine.tree.terms import ZERO, Recorder, Term


@pytest.fixture
def record():
    return Recorder()


def moving(record, *names):
    return [record.leaf(name, name) for name in names]


def fixed(record, *names):
    return [record.leaf(name, name, fixed=True) for name in names]


def test_zero_leaves_no_trace(record):
    (x,) = moving(record, "x")
    assert x + ZERO == x == 0.0 + x
    assert (x * ZERO).zero
    assert (0.0 * x).zero
    assert (x - x).zero
    assert (-ZERO).zero
    assert x * 1.0 == x


def test_what_is_the_same_is_recorded_once(record):
    x, y = moving(record, "x", "y")
    assert x + y == y + x
    assert x * y == y * x
    assert x - y == -(y - x)
    assert (2.0 * x + 2.0 * y) == 2.0 * (x + y)
    assert (-x) * y == -(x * y)
    assert record.reciprocal(-x) == -record.reciprocal(x)


def test_parts_that_meet_their_like_are_merged(record):
    x, y, z = moving(record, "x", "y", "z")
    assert (x + y) + y == x + 2.0 * y
    assert (x + y) - y == x
    assert (x + y + z) - (x + y) == z
    assert ((x + y) - z) + z - (y + x) == ZERO


def test_fixed_parts_gather(record):
    x, y = moving(record, "x", "y")
    a, b = fixed(record, "a", "b")
    assert ((a + b) * x).fixed is False
    assert (a * b).fixed
    assert a * (b * x) == (a * b) * x
    assert (a + x) + b == (a + b) + x
    assert ((x + a) + y) + b == (x + (a + b)) + y
    assert (a * 2.0) * x == (2.0 * a) * x
    product = (a * (b * (2.0 * x))).node
    assert [part.fixed for part in product.parts] == [True, False]  # one factor before the run, one in it


def test_a_number_without_unit_is_not_added(record):
    (x,) = moving(record, "x")
    with pytest.raises(TypeError, match="without unit"):
        x + 1.0
    assert Term(2.0, None) + 3.0 == Term(5.0, None)


def test_names_are_given_once(record):
    x, y = moving(record, "x", "y")
    assert (x + y).named("sum").node.name == "sum"
    assert (x * y).named("sum").node.name == "sum_2"
    assert (x + y).named("other").node.name == "sum"
    assert (-(x * x)).named("drop").node.name == "minus_drop"
    assert x.named("z").node.name == "x"


@pytest.mark.parametrize("seed", range(30))
def test_the_statements_have_the_value_of_the_arithmetic(seed):
    """Random expressions, recorded and computed side by side."""
    rng, record, constants = np.random.default_rng(seed), Recorder(), Constants()
    names = {name: float(rng.uniform(0.5, 2.0)) for name in "abcxyz"}
    pool = [(record.leaf(n, n, fixed=n in "abc"), value) for n, value in names.items()]
    for step in range(60):
        (one, p), (other, q) = (pool[k] for k in rng.integers(len(pool), size=2))
        kind = rng.integers(6)
        if kind == 5 and not one.zero and one.node is not None and not one.fixed:
            made = (record.reciprocal(one), 1.0 / p)
        elif kind == 4:
            made = (-2.0 * one, -2.0 * p)
        else:
            made = [(one + other, p + q), (one - other, p - q), (one * other, p * q), (one * other, p * q)][kind % 4]
        if 1e-3 < abs(made[1]) < 1e3:
            pool.append((made[0].named(f"n{step}") if rng.random() < 0.3 else made[0], made[1]))
    chosen = [pool[k] for k in rng.integers(len(pool), size=6)]
    text = "def f(x, y, z, constants):\n" + body(
        [t for t, _ in chosen], lambda texts: f"({', '.join(texts)},)", constants
    )
    roots = [Term(1.0, node) for node in constants.nodes]
    text += "\n\ndef prepare(a, b, c):\n" + body(roots, lambda texts: f"({''.join(t + ', ' for t in texts)})")
    space: dict[str, object] = {}
    exec(text, space)

    class Given:
        pass

    for node, value in zip(constants.nodes, space["prepare"](*(names[n] for n in "abc")), strict=True):
        setattr(Given, node.name, value)
    found = space["f"](*(names[n] for n in "xyz"), Given)
    for mine, (_, value) in zip(found, chosen, strict=True):
        assert math.isclose(mine, value, rel_tol=1e-9, abs_tol=1e-9)
