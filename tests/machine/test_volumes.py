"""Levers and volumes of actuators: one the slope of the other, and levers those of the simulation."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.machine.volumes import lever_grid, levers, side_volumes
from polydraulic.parameters.layout.geometry import lever


@pytest.mark.parametrize("name", ["cat215b_bucket", "loader_crane"])
def test_levers_are_slopes_of_volumes(name):
    machine = load_machine(name)
    for f in machine.functions:
        low, high = max(f.stops.low, -3.0), min(f.stops.high, 3.0)
        position, step = np.linspace(low, high, 50)[1:-1], 1e-4 * (high - low)
        for side, sign in ((0, 1.0), (1, -1.0)):
            slope = side_volumes(machine, f, position + step)[side] - side_volumes(machine, f, position - step)[side]
            assert np.allclose(slope / (2.0 * step), sign * levers(machine, f, position)[side], rtol=5e-3)


def test_levers_are_those_of_the_pins():
    machine = load_machine("cat215b")
    boom = machine.function("boom")
    at = lever_grid(boom)[[10, 300]]
    arm = [abs(lever(boom, machine.link(boom.moves), angle)) for angle in at.tolist()]
    a, b = levers(machine, boom, at)
    assert np.allclose(a / a[0], np.array(arm) / arm[0])
    assert np.all(a > b)
