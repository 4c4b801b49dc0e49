"""Derivatives of recorded terms, calculated and compared with differences."""

import math

import pytest

from polydraulic.machine.tree.derivatives import along_joint, along_rate, derivatives
from polydraulic.machine.tree.statements import body
from polydraulic.machine.tree.terms import ZERO, Recorder


class Turn:
    def __init__(self, sin, cos):
        self.sin, self.cos = sin, cos


class Values:
    def __init__(self, **values):
        self.__dict__.update(values)


def value(term, angle, way, speed):
    """A term's value, by the text that is written of it."""
    lines = body([term], lambda texts: texts[0]).replace("    return ", "    found = ")
    turn = Values(arm=Turn(math.sin(angle), math.cos(angle)), slide=way)
    names = {"turn": turn, "rate": Values(arm=speed), "mass": 7.0}
    exec("\n".join(line.strip() for line in lines.split("\n")), names)
    return names["found"]


def recorded():
    """A sum of products, one of them under a reciprocal, with a fixed factor and a part that is used twice."""
    terms = Recorder()
    mass = terms.leaf("mass", "mass", fixed=True)
    sin, cos, way = (
        terms.leaf(text, name)
        for text, name in (
            ("turn.arm.sin", "arm_sin"),
            ("turn.arm.cos", "arm_cos"),
            ("turn.slide", "slide_way"),
        )
    )
    rate = terms.leaf("rate.arm", "arm_rate")
    x = mass * cos + way * sin
    return terms, x * x * rate - 3.0 * way * sin + rate * rate * terms.reciprocal(x * x + mass * mass), mass


@pytest.mark.parametrize(
    ("direction", "step"),
    [
        (lambda terms: along_joint(terms, "arm", turns=True), (1.0, 0.0, 0.0)),
        (lambda terms: along_joint(terms, "slide", turns=False), (0.0, 1.0, 0.0)),
        (lambda terms: along_rate(terms, "arm"), (0.0, 0.0, 1.0)),
    ],
)
def test_derivatives_are_differences(direction, step):
    terms, term, _ = recorded()
    (found,) = derivatives([term], direction(terms))
    for at in ((0.3, 1.2, -0.7), (-2.0, 0.1, 1.5)):
        near = [[a + side * 1e-6 * b for a, b in zip(at, step, strict=True)] for side in (1.0, -1.0)]
        difference = (value(term, *near[0]) - value(term, *near[1])) / 2e-6
        assert value(found, *at) == pytest.approx(difference, rel=1e-7)
        assert abs(difference) > 1e-3


def test_what_does_not_move_has_none():
    terms, _, mass = recorded()
    leaf = terms.leaf("rate.other", "other_rate")
    assert derivatives([mass, leaf, ZERO], along_rate(terms, "arm")) == [ZERO, ZERO, ZERO]
