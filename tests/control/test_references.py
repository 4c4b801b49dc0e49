"""Paths of a tip."""

import numpy as np
import pytest

from polydraulic import InputError
from polydraulic.control.references import pick_and_place, straight_line, tip_path

START = np.array([7.0, 0.5, 0.1, -1.9])


@pytest.mark.parametrize("path", [straight_line(START, length=4.0, slope=0.1, depth=0.3), pick_and_place(START)])
def test_velocities_are_the_slopes_of_the_points_and_every_point_is_met_at_rest(path):
    step = 1e-6
    for time in np.linspace(0.01, path.duration - 0.01, 40):
        ahead, behind, (_, velocity) = path.at(time + step)[0], path.at(time - step)[0], path.at(time)
        np.testing.assert_allclose((ahead - behind) / (2 * step), velocity, atol=1e-5)
    for end, point in zip(path.ends, path.points, strict=True):
        found, velocity = path.at(float(end))
        np.testing.assert_allclose(found, point, atol=1e-12)
        np.testing.assert_allclose(velocity, 0.0, atol=1e-12)


def test_a_line_has_its_length_slope_and_speed():
    path = straight_line(START, length=4.0, speed=0.3, slope=0.1)
    first, last = path.at(-1.0)[0], path.at(1e3)[0]
    np.testing.assert_allclose(last - first, [-4.0 * np.cos(0.1), 4.0 * np.sin(0.1), 0.0, 0.0], atol=1e-12)
    speeds = [float(np.hypot(*path.at(time)[1][:2])) for time in np.linspace(0.0, path.duration, 200)]
    assert max(speeds) == pytest.approx(0.3)
    assert path.duration == pytest.approx(4.0 / 0.3 + 0.6)


def test_a_depth_is_dug_first():
    path = straight_line(START, length=2.0, depth=0.4)
    np.testing.assert_allclose(path.points[1] - path.points[0], [0.0, -0.4, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("points", "options", "words"),
    [
        ([[0.0, 0.0, 0.0, 0.0]], {}, "two or more rows"),
        ([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]], {}, "two or more rows"),
        ([[0.0] * 4, [np.nan] * 4], {}, "two or more rows of finite"),
        ([[0.0] * 4, [0.0] * 4], {}, "points 1 and 2 are the same"),
        ([[0.0] * 4, [1.0] * 4], {"speed": 0.0}, "speed = 0.0"),
        ([[0.0] * 4, [1.0] * 4], {"ramp": np.inf}, "ramp = inf"),
    ],
)
def test_paths_that_are_none_are_refused(points, options, words):
    with pytest.raises(InputError, match=words):
        tip_path(points, **options)
