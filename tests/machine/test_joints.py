import numpy as np
import pytest

from polydraulic.elementary import sincos
from polydraulic.machine.joints import moved, stopped
from polydraulic.machine.linkage import (
    motion,
)
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import Links


def matrix(m):
    return np.array([[m.m11, m.m12, m.m13], [m.m12, m.m22, m.m23], [m.m13, m.m23, m.m33]])


def at(angle, rate, linkage):
    return motion(sincos(angle[1]), sincos(angle[2]), Links(*rate), linkage)


def at_stops(machine, boom=None, stick=None):
    """Angles with boom or stick at an end, given as -1 or 1."""

    def angle(link, side, middle):
        return middle if side is None else (link.stops.high if side > 0 else link.stops.low)

    return Links(0.3, angle(machine.boom, boom, 0.2), angle(machine.stick, stick, -1.2))


def test_impact_stops_one_joint_and_moves_the_others(machine):
    plant = prepare(machine, 0.005)
    angle, rate = at_stops(machine, stick=1), Links(0.1, -0.05, 0.4)
    mass = at(angle, rate, plant.linkage).mass
    after = stopped(angle, rate, mass, plant)
    assert after.rate.stick == 0.0
    assert after.there == (False, False, True)
    change = matrix(mass) @ (np.array(after.rate) - np.array(rate))
    assert change[:2] == pytest.approx([0.0, 0.0], abs=1e-9)  # the impulse acts on the stick alone
    assert change[2] < 0.0
    assert after.rate.boom != rate.boom
    energy = [0.5 * np.array(v) @ matrix(mass) @ np.array(v) for v in (rate, after.rate)]
    assert energy[1] < energy[0]


def test_two_joints_at_their_stops(machine):
    """Whatever drives them: no joint goes on into its stop, none is pulled by it, and no energy appears."""
    plant = prepare(machine, 0.005)
    rng = np.random.default_rng(3)
    for _ in range(300):
        sides = rng.choice([-1, 1], 2)
        angle, rate = at_stops(machine, *sides), Links(*rng.uniform(-1.0, 1.0, 3))
        mass = at(angle, rate, plant.linkage).mass
        after = np.array(stopped(angle, rate, mass, plant).rate)
        impulse = matrix(mass) @ (after - np.array(rate))
        assert np.all(after[1:] * sides <= 1e-12)
        assert np.all(impulse[1:] * sides <= 1e-9)
        assert abs(impulse[0]) < 1e-9
        assert after @ matrix(mass) @ after <= np.array(rate) @ matrix(mass) @ np.array(rate) * (1.0 + 1e-12)


def test_a_held_joint_leaves_when_it_is_pulled_away(machine):
    plant = prepare(machine, 0.005)
    angle, rest = at_stops(machine, boom=1), Links(0.0, 0.0, 0.0)
    mass = at(angle, rest, plant.linkage).mass
    pushed = moved(angle, rest, Links(0.0, 2.0, 0.5), mass, plant)
    assert (pushed.angle.boom, pushed.rate.boom) == (machine.boom.stops.high, 0.0)
    reduced = np.linalg.solve(matrix(mass)[np.ix_([0, 2], [0, 2])], (matrix(mass) @ np.array([0.0, 2.0, 0.5]))[[0, 2]])
    assert [pushed.rate.swing, pushed.rate.stick] == pytest.approx(0.005 * reduced, rel=1e-10)
    pulled = moved(angle, rest, Links(0.0, -2.0, 0.5), mass, plant)
    assert pulled.rate.boom == pytest.approx(-0.01)
    assert pulled.angle.boom < machine.boom.stops.high


def test_a_joint_comes_to_rest_at_its_stop(machine):
    plant = prepare(machine, 0.005)
    angle, rate = Links(0.0, machine.boom.stops.high - 1e-4, -1.2), Links(0.0, 0.5, 0.0)
    after = moved(angle, rate, Links(0.0, 0.0, 0.0), at(angle, rate, plant.linkage).mass, plant)
    assert (after.angle.boom, after.rate.boom) == (machine.boom.stops.high, 0.0)


def test_locked_joints_stand_still(machine):
    plant = prepare(machine, 0.005, ["swing", "stick"])
    assert plant.locked == (True, False, True)
    angle, rate = at_stops(machine, boom=1), Links(0.0, 0.4, 0.0)
    after = moved(angle, rate, Links(0.0, 1.0, 0.0), at(angle, rate, plant.linkage).mass, plant)
    assert after.rate == (0.0, 0.0, 0.0)
    assert after.angle == angle
