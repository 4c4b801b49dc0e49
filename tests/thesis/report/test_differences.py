"""Numbers of runs, checked on runs made by hand."""

import numpy as np
import pytest

from polydraulic.tables import Table
from polydraulic.thesis.report.differences import Compared, event, phases, spool_range, value

TIME = np.linspace(0.0, 2.0, 401)


def run(angle, events=()):
    names = ("effector.x", "effector.y", "effector.z")
    columns = {"time": TIME, "boom.angle": angle, "boom.spool": 0.0254 * TIME / 4.0}
    columns |= {name: scale * angle for name, scale in zip(names, (3.0, 4.0, 0.0), strict=True)}
    return Table(
        columns, {"boom.angle": "rad", "boom.spool": "m", **dict.fromkeys(names, "m")}, {"events": list(events)}
    )


@pytest.fixture
def pair():
    return Compared(run(np.zeros(401)), run(np.radians(np.where(TIME <= 1.0, TIME, 2.0 - TIME))))


def test_errors_at_a_time_and_the_largest(pair):
    assert pair.at("boom.angle", 0.5) == pytest.approx(0.5)
    assert pair.largest("boom.angle", 0.0, 2.0) == pytest.approx(1.0)
    assert pair.largest("boom.angle", 1.5, 2.0) == pytest.approx(0.5)
    assert pair.time_of_largest("boom.angle", 0.2, 2.0) == pytest.approx(1.0)


def test_distance_of_the_tips(pair):
    assert pair.distance(1.0) == pytest.approx(5.0 * np.radians(1.0))
    assert pair.largest_distance() == pytest.approx(5.0 * np.radians(1.0))
    assert pair.largest_distance(0.5) == pytest.approx(5.0 * np.radians(0.5))
    assert pair.time_of_largest_distance() == pytest.approx(1.0)
    assert pair.along("y")[200] == pytest.approx(4.0 * np.radians(1.0))


def test_events_values_and_ranges():
    table = run(
        np.radians(TIME), [[0.1, "boom", "valve opens"], [0.2, "stick", "valve opens"], [0.9, "boom", "valve opens"]]
    )
    assert event(table, "boom", "valve opens", 1) == 0.9
    assert value(table, "boom.angle", 0.75) == pytest.approx(0.75)
    assert spool_range(table, "boom", 0.0254 * 0.2, 0.0) == pytest.approx([0.20125, 0.5])


def test_phases_of_the_task():
    assert np.allclose(phases("task", "boom"), [[0.0, 3.0], [3.0, 7.0], [7.0, 10.0], [10.0, 13.0]])
