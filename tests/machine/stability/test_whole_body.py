"""A machine as one body, against momentum and spin of its links differentiated numerically."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.machine.frames import link_frames, placed, vector
from polydraulic.machine.newton_euler import tensor_of
from polydraulic.machine.stability.whole_body import standing, standing_margins
from polydraulic.parameters.layout.chassis import Slope

MACHINES = ("excavator_22t", "loader_crane", "wheel_loader")


def moving(machine, t):
    """Joint positions on a smooth path, (n,)."""
    k = np.arange(len(machine.names))
    middle = np.array([0.5 * (max(f.stops.low, -2.0) + min(f.stops.high, 2.0)) for f in machine.functions])
    return middle + 0.2 * np.sin((1.0 + 0.3 * k) * t + k)


def derivatives(machine, t):
    k = np.arange(len(machine.names))
    speed = 1.0 + 0.3 * k
    return moving(machine, t), 0.2 * speed * np.cos(speed * t + k), -0.2 * speed**2 * np.sin(speed * t + k)


def momentum_and_spin(machine, t, h=1e-5):
    """Sum of m v, and of r x m v + I w about the origin, of all links, from places and turns on both sides."""
    frames = [link_frames(machine, moving(machine, t + s * h)) for s in (-1, 0, 1)]
    momentum, spin = np.zeros(3), np.zeros(3)
    for link in machine.links:
        before, here, after = (f[link.name][1] + f[link.name][0] @ vector(link.cg) for f in frames)
        turn = frames[1][link.name][0]
        skew = (frames[2][link.name][0] - frames[0][link.name][0]) / (2 * h) @ turn.T
        w = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        p = link.mass * (after - before) / (2 * h)
        momentum += p
        spin += np.cross(here, p) + turn @ tensor_of(link) @ turn.T @ w
    return momentum, spin


@pytest.mark.parametrize("name", MACHINES)
def test_net_force_is_weight_less_what_changes_momentum(name):
    machine, t, h = load_machine(name), 0.7, 1e-3
    push = np.array([500.0, -300.0, 200.0])
    row = standing(machine, *(x[None] for x in derivatives(machine, t)), push[None])[0]
    (p0, l0), (p1, _), (p2, l2) = (momentum_and_spin(machine, t + s * h) for s in (-1, 0, 1))
    weight, cg, velocity, force, moment = row[0], row[1:4], row[4:7], row[7:10], row[10:13]
    assert weight == pytest.approx(9.81 * (sum(link.mass for link in machine.links) + machine.chassis.mass))
    np.testing.assert_allclose(velocity * weight / machine.gravity, p1, rtol=1e-6, atol=1e-3)
    np.testing.assert_allclose(force, np.array([0, 0, -weight]) + push - (p2 - p0) / (2 * h), rtol=1e-5, atol=1.0)
    tip = placed(link_frames(machine, moving(machine, t)), *machine.tip)
    about_origin = np.cross(cg, [0, 0, -weight]) + np.cross(tip, push) - (l2 - l0) / (2 * h)
    np.testing.assert_allclose(moment + np.cross(cg, force), about_origin, rtol=1e-5, atol=5.0)


def test_on_a_slope_weight_alone_turns():
    level = load_machine("wheel_loader")
    tilted = level._replace(chassis=level.chassis._replace(slope=Slope(0.2, -0.1)))
    state = [x[None] for x in derivatives(level, 0.3)]
    a, b = (standing(m, *state, np.zeros((1, 3)))[0] for m in (level, tilted))
    np.testing.assert_allclose(
        b[10:13], a[10:13], rtol=1e-12, atol=1e-6
    )  # weight has no moment about the centre of gravity
    np.testing.assert_allclose(b[7:10] - a[7:10], a[0] * (np.array([0, 0, 1]) - np.array(tilted.chassis.upward)))


def test_a_machine_without_chassis_is_refused():
    machine = load_machine("wheel_loader")._replace(chassis=None)
    zero = np.zeros((1, 2))
    with pytest.raises(InputError, match=r"no \[chassis\]"):
        standing_margins(machine, zero, zero, zero, np.zeros((1, 3)))
