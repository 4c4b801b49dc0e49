import numpy as np
import pytest

from helpers.made_runs import point_at, small_crane
from polydraulic import load_machine
from polydraulic.plotting.layout_shapes import layout_drawing
from polydraulic.plotting.tip_area import tip_area, tip_places


def test_places_are_those_between_the_stops():
    """A jib with an extension reaches a sector of a ring round its joint."""
    crane = small_crane()
    found = tip_places(layout_drawing(crane)) - [0.1, 2.1]  # from the jib's joint
    along, beside = np.hypot(*found.T), -0.2
    assert along.min() == pytest.approx(np.hypot(2.4 + 0.5, beside))
    assert along.max() == pytest.approx(np.hypot(2.4 + 0.5 + 1.1, beside))
    direction = np.arctan2(found[:, 1], found[:, 0]) - np.arctan2(beside, np.sqrt(along**2 - beside**2))
    assert (direction.min(), direction.max()) == pytest.approx((-0.3, 1.2))


def test_the_initial_tip_is_inside(machine):
    for given in (machine, load_machine("cat215b_bucket")):
        drawing = layout_drawing(given)
        x, y, area = tip_area(tip_places(drawing))
        if given is machine:
            tip = (
                0.81 + 5.19 * np.cos(np.radians(30.0)) + 1.8 * np.cos(np.radians(-51.2)),
                5.19 * 0.5 + 1.8 * np.sin(np.radians(-51.2)),
            )
        else:
            tip = point_at(given, drawing.initial, *given.tip)[[0, 2]]
        column, row = (int(np.argmin(np.abs(axis - value))) for axis, value in zip((x, y), tip, strict=True))
        assert area[row, column] > 0.9
        assert area.shape == (len(y), len(x))
        assert area[0].max() < 0.1  # the border is free
