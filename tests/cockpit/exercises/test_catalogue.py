import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.cockpit.exercises.catalogue import exercises_of
from polydraulic.cockpit.exercises.reachable import reach_of, tips_at
from polydraulic.plotting.layout_shapes import layout_drawing

DT = 5e-3


@pytest.mark.parametrize("name", ["wheel_loader", "excavator_22t", "loader_crane", "cat215b"])
def test_all_that_is_asked_for_can_be_reached(name):
    machine = load_machine(name)
    exercises = exercises_of(machine, DT, layout_drawing(machine).ground)
    reach = reach_of(machine)
    start = tips_at(machine, np.array([[f.initial.angle for f in machine.functions]]))[0]
    target = exercises["tracking"].path
    np.testing.assert_allclose(target[0], start, atol=1e-9)
    assert 0.2 < np.linalg.norm(np.diff(target, axis=0), axis=1).max() / DT < 1.5  # m/s: it moves, and can be followed
    line = exercises["trench"].path
    assert line[0, 2] == line[1, 2]
    for share in np.linspace(0.0, 1.0, 9):
        place = line[0] + share * (line[1] - line[0])
        assert np.linalg.norm(reach.tips - place, axis=1).min() < 0.03 * reach.size
    for kind in ("pick and place", "truck loading"):
        path = exercises[kind].path
        assert np.linalg.norm(path[0] - path[1]) > 4.0 * exercises[kind].tolerance
        assert len(path) == len(exercises[kind].payload)
    assert max(exercises["truck loading"].payload) > 0.0
