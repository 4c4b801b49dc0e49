"""Vectors of terms: the algebra of space, and nothing of what is zero."""

import math

import numpy as np
import pytest

from polydraulic.machine.tree.terms import Recorder, Term
from polydraulic.machine.tree.vectors import (
    NOTHING,
    Rotation,
    added,
    components,
    cross,
    dot,
    plane,
    rotated,
    rotated_back,
    scaled,
    unit,
)


def numbers(*values):
    return tuple(Term(value, None) for value in values)


def values(vector):
    return [part.factor for part in vector]


def test_axes_are_right_handed():
    for k in range(3):
        i, j = plane(k)
        assert cross(unit(i), unit(j)) == unit(k)
        assert dot(unit(i), unit(j)).zero
        turned = rotated(unit(i), Rotation(k, *numbers(1.0, 0.0)))
        assert values(turned) == values(unit(j))


def test_a_turn_back_undoes_a_turn():
    turn = Rotation(1, *numbers(math.sin(0.7), math.cos(0.7)))
    v = numbers(1.0, 2.0, 3.0)
    assert values(rotated_back(rotated(v, turn), turn)) == pytest.approx([1.0, 2.0, 3.0])
    assert rotated(v, None) == v


def test_products_are_those_of_numpy():
    a, b = np.random.default_rng(0).normal(size=(2, 3))
    assert values(cross(numbers(*a), numbers(*b))) == pytest.approx(np.cross(a, b))
    assert dot(numbers(*a), numbers(*b)).factor == pytest.approx(a @ b)
    assert values(added(numbers(*a), scaled(2.0, numbers(*b)))) == pytest.approx(a + 2.0 * b)


def test_what_is_not_given_is_not_there():
    x = Recorder().leaf("x", "x")
    v = components({"x": x})
    assert v == (x, *NOTHING[1:])
    assert cross(v, unit(0)) == NOTHING
    assert cross(v, unit(1)) == (*NOTHING[:2], x)
