"""Margins over an edge against values derived by hand, and numbers that are known from elsewhere."""

from math import atan, cos, hypot, pi, radians, sin

import numpy as np
import pytest

from polydraulic.machine.stability.margins import MEASURES, Standing, edge_margins
from polydraulic.machine.stability.vectors import Vector

SQUARE = ((1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0), (-1.0, -1.0, 0.0))  # edges: forward, left, rear, right


def margins(corners, cg, *, weight=1000.0, velocity=(0, 0, 0), force=None, moment=(0, 0, 0), upward=(0, 0, 1)):
    force = -weight * np.array(upward, dtype=float) if force is None else force
    parts = (cg, velocity, force, moment, upward)
    standing = Standing(float(weight), *(Vector(*map(float, part)) for part in parts))
    ends = zip(corners, (*corners[1:], corners[0]), strict=True)
    found = [edge_margins(Vector(*begin), Vector(*end), standing) for begin, end in ends]
    return dict(zip(MEASURES, np.array(found).T, strict=True))


@pytest.mark.parametrize(
    ("cg", "known"), [((0.2, 0.7, 1), (0.2, 1.3, 0.8, 0.7)), ((-0.2, 0.7, 1), (-0.2, 1.3, 1.2, 0.7))]
)
def test_distances_that_are_known_from_elsewhere(cg, known):
    rectangle = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 2.0, 0.0), (0.0, 2.0, 0.0))
    found = margins(rectangle, cg)
    bottom, right, top, left = found["distance"]
    np.testing.assert_allclose((left, top, right, bottom), known, rtol=0, atol=1e-15)
    np.testing.assert_allclose(found["dynamic_distance"], found["distance"], rtol=0, atol=1e-15)  # at rest


def test_force_angle_measure_of_a_machine_at_rest():
    """The edge is seen b ahead and h below: at the angle atan(b / h) to the weight, which acts b from it."""
    x, h, w = 0.4, 1.5, 1000.0
    found = margins(SQUARE, (x, 0.0, h), weight=w)["force_angle"]
    by_hand = [atan(b / h) * w * b for b in (1.0 - x, 1.0, 1.0 + x, 1.0)]
    np.testing.assert_allclose(found, by_hand, rtol=1e-14)


def test_force_angle_measure_with_inertia():
    """A force f forward at the centre of gravity leans the net force by atan(f / w) and takes f h off the moment w b."""
    h, w, f = 1.5, 1000.0, 300.0
    found = margins(SQUARE, (0.0, 0.0, h), weight=w, force=(f, 0.0, -w))
    forward, rear = ((atan(1.0 / h) + s * atan(f / w)) * (w + s * f * h) for s in (-1.0, 1.0))
    assert found["force_angle"][0] == pytest.approx(forward, rel=1e-14)
    assert found["force_angle"][2] == pytest.approx(rear, rel=1e-14)
    assert found["dynamic_distance"][0] == pytest.approx((w - f * h) / w, rel=1e-14)
    assert found["distance"][0] == 1.0  # inertia does not move the centre of gravity


def test_moment_acts_as_the_force_that_has_it_at_the_centre_of_gravity():
    """A moment about y tips forward: over the forward edge it is the force m / |l| across l, in the plane of the weight."""
    h, w, m = 1.5, 1000.0, 200.0
    found = margins(SQUARE, (0.0, 0.0, h), weight=w, moment=(0.0, m, 0.0))
    far = hypot(1.0, h)
    ahead = np.array([1.0, -h]) / far  # l in x and z
    net = np.array([0.0, -w]) + m / far * np.array([-ahead[1], ahead[0]])
    angle = np.arctan2(net[0] * ahead[1] - net[1] * ahead[0], net @ ahead)
    assert found["dynamic_distance"][0] == pytest.approx((w - m) / w, rel=1e-14)
    assert found["force_angle"][0] == pytest.approx(angle * (w - m), rel=1e-13)
    assert found["dynamic_distance"][1] == pytest.approx(1.0, rel=1e-14)  # not over the side


@pytest.mark.parametrize("excess", [-1.0, 1.0])
def test_all_dynamic_measures_change_sign_together(excess):
    h, w = 1.5, 1000.0
    found = margins(SQUARE, (0.0, 0.0, h), weight=w, force=((w + excess) / h, 0.0, -w))
    assert np.sign(found["dynamic_distance"][0]) == np.sign(found["force_angle"][0]) == -excess
    assert abs(found["dynamic_distance"][0]) == pytest.approx(1.0 / w, rel=1e-9)


def test_energy_raises_the_centre_of_gravity_above_the_edge():
    h, w = 1.5, 1000.0
    found = margins(SQUARE, (0.4, 0.0, h), weight=w)["energy"]
    assert found[0] == pytest.approx(w * (hypot(0.6, h) - h), rel=1e-14)
    assert found[2] == pytest.approx(w * (hypot(1.4, h) - h), rel=1e-14)
    assert margins(SQUARE, (1.2, 0.0, h), weight=w)["energy"][0] == pytest.approx(-w * (hypot(0.2, h) - h), rel=1e-13)


def test_slope_moves_the_line_of_gravity():
    """Where the ground rises forward by a, the machine is turned back: its distances are b cos a + h sin a and b cos a - h sin a."""
    a, h, w = radians(20), 1.5, 1000.0
    found = margins(SQUARE, (0.0, 0.0, h), weight=w, upward=(sin(a), 0.0, cos(a)))
    assert found["distance"][0] == pytest.approx(cos(a) + h * sin(a), rel=1e-14)
    assert found["distance"][2] == pytest.approx(cos(a) - h * sin(a), rel=1e-14)
    assert found["distance"][1] == pytest.approx(
        1.0, rel=1e-14
    )  # along the slope, only the weight across the edge counts
    np.testing.assert_allclose(found["dynamic_distance"], found["distance"], rtol=1e-14)
    energy = w * (hypot(1.0, h) - (h * cos(a) - sin(a)))
    assert found["energy"][0] == pytest.approx(energy, rel=1e-13)


def test_closing_is_the_rate_of_the_distance():
    corners, v, dt = ((2.0, -1.0, 0.1), (1.0, 1.5, -0.2), (-1.0, 0.3, 0.0)), np.array([0.3, -0.2, 0.1]), 1e-6
    upward = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    before, after = (
        margins(corners, np.array([0.2, 0.1, 1.0]) + s * dt * v, upward=upward, velocity=v) for s in (-1, 1)
    )
    rate = (after["distance"] - before["distance"]) / (2.0 * dt)
    np.testing.assert_allclose(before["closing"], -rate, rtol=0, atol=1e-9)


def test_edge_that_stands_askew():
    """A triangle's edge at 45 deg, against the distance of a point to a line."""
    corners = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (-1.0, -1.0, 0.0))
    found = margins(corners, (0.1, 0.2, 0.8))
    assert found["distance"][0] == pytest.approx((1.0 - 0.3) * cos(pi / 4), rel=1e-14)
