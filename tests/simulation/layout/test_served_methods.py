"""Which methods serve which machine, and how the others are refused."""

import pytest

from helpers.small_crane import with_effects
from polydraulic import InputError
from polydraulic.simulation.layout.served_methods import CONTINUOUS, STEPPED, check_method, method_lines
from polydraulic.simulation.runs import METHODS


def test_every_method_is_known():
    assert {STEPPED, *CONTINUOUS} == set(METHODS)


def test_a_plain_machine_has_all_methods(crane):
    for method in METHODS:
        check_method(crane, method)
    assert method_lines(crane) == ["methods of simulate: semi-implicit, rk4, rosenbrock, reference"]


def test_effects_leave_one_method_and_are_named(crane):
    sticky = with_effects(crane, sticks=True)
    check_method(sticky, STEPPED)
    for method in CONTINUOUS:
        with pytest.raises(
            InputError,
            match=rf"functions.slew.friction.sticks: method {method!r} does not know it; use 'semi-implicit'",
        ):
            check_method(sticky, method)
    (line,) = method_lines(sticky)
    assert line.startswith("methods of simulate: semi-implicit alone, since the others do not know functions.slew.")
