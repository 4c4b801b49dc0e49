import numpy as np
import pytest

from polydraulic.parameters.layout.parts import LinkParameters
from polydraulic.plotting.travel import joint_stops


def link(joint, axis):
    return LinkParameters("arm", "base", joint, axis, {"x": 1.0, "z": 0.5}, 1.0, {}, {})


@pytest.mark.parametrize(("axis", "view", "high"), [
    ("-y", "side", (np.cos(0.7), 0.0, np.sin(0.7))), ("y", "side", (np.cos(0.7), 0.0, -np.sin(0.7))),
    ("z", "top", (np.cos(0.7), np.sin(0.7), 0.0)), ("-z", "top", (np.cos(0.7), -np.sin(0.7), 0.0)),
])  # fmt: skip
def test_an_arc_ends_where_the_link_points_at_its_stop(axis, view, high):
    stops = joint_stops(3, link("revolute", axis), (-0.4, 0.7), 2.0)
    assert (stops.joint, stops.low, stops.high, stops.view) == (3, -0.4, 0.7, view)
    middle = np.array([1.0, 0.0, 0.5])
    assert np.array(stops.path[-1].at) - middle == pytest.approx(2.0 * np.array(high))
    assert {spot.link for spot in stops.path} == {"base"}
    assert np.linalg.norm(np.array([spot.at for spot in stops.path]) - middle, axis=1) == pytest.approx(2.0)
    tick = np.array([spot.at for spot in stops.ticks[1]]) - middle
    assert tick == pytest.approx(np.outer([1.76, 2.24], high))


def test_an_arc_follows_where_its_link_points_to():
    stops = joint_stops(0, link("revolute", "-y"), (0.0, 1.0), 1.0, np.array([0.0, 0.2, -3.0]))
    assert np.array(stops.path[0].at) == pytest.approx([1.0, 0.0, -0.5])


@pytest.mark.parametrize(
    ("axis", "along"), [("x", (1, 0, 0)), ("-x", (-1, 0, 0)), ("z", (0, 0, 1)), ("-y", (0, -1, 0))]
)
def test_a_joint_that_slides_has_a_line_beside_its_way(axis, along):
    stops = joint_stops(1, link("prismatic", axis), (0.2, 1.5), 0.3)
    ends = np.array([stops.path[0].at, stops.path[-1].at])
    assert ends[1] - ends[0] == pytest.approx(1.3 * np.array(along))
    beside = ends[0] - np.array([1.0, 0.0, 0.5]) - 0.2 * np.array(along)
    assert np.linalg.norm(beside) == pytest.approx(0.3)
    assert abs(beside @ np.array(along)) < 1e-12
    assert stops.view == "side"
