"""Parameters of episodes: what may be drawn, from which range, and the machines with them."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.gym.varied import VARIATIONS, checked_ranges, draw_count, parameters_from, varied_machine

ALL = {"payload": (0.0, 500.0), "valve_gain": (0.8, 1.2), "friction": (0.5, 2.0), "dead_time": (0.0, 0.1)}


@pytest.mark.parametrize(
    ("randomize", "said"),
    [
        ({"mass": (0, 1)}, "'mass'; there are"),
        ({"valve_gain": (0.1, 1.0)}, "from 0.2 to 2.5"),
        ({"payload": (5.0, 1.0)}, "rising order"),
        ({"friction": 1.0}, "two numbers"),
        ({"dead_time": (0.0, float("nan"))}, "two numbers"),
    ],
)
def test_ranges_that_cannot_be_used_are_named(randomize, said):
    with pytest.raises(InputError, match=said):
        checked_ranges(randomize)


def test_draws_become_parameters_in_their_ranges():
    ranges = checked_ranges(ALL)
    assert list(ranges) == list(VARIATIONS)
    n = draw_count(ranges, 2)
    assert n == 3 * 2 + 1
    found = parameters_from(ranges, 2, np.array([np.zeros(n), np.full(n, 0.5), np.ones(n)]).T)
    for name, (low, high) in ALL.items():
        assert found[name].shape == (2 if VARIATIONS[name].each else 1, 3)
        assert np.allclose(found[name], [low, 0.5 * (low + high), high])


def test_a_machine_with_parameters_of_its_own():
    machine = load_machine("wheel_loader")
    found = varied_machine(
        machine,
        {"valve_gain": [2.0, 1.0], "friction": [1.0, 0.5], "dead_time": [0.1, 0.0], "payload": [400.0]},
    )
    (lift, tilt), (lift_was, tilt_was) = found.functions, machine.functions
    assert lift.pilot.gain == 2.0 * lift_was.pilot.gain
    assert tilt.pilot.gain == tilt_was.pilot.gain
    assert [getattr(tilt.friction, key) for key in ("coulomb", "static", "viscous")] == [
        0.5 * getattr(tilt_was.friction, key) for key in ("coulomb", "static", "viscous")
    ]
    assert tilt.friction.smoothing == tilt_was.friction.smoothing
    assert (lift.pilot.dead_time, tilt.pilot.dead_time) == (lift_was.pilot.dead_time + 0.1, tilt_was.pilot.dead_time)
    assert found.link("bucket").mass == machine.link("bucket").mass + 400.0
