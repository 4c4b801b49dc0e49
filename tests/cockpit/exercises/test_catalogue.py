import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.cockpit.exercises.catalogue import exercises_of
from polydraulic.machine.reach.poses import reached_poses
from polydraulic.machine.reach.tip import joint_speeds, tip_at_joints, tip_jacobian
from polydraulic.machine.reach.travels import travels_of
from polydraulic.plotting.layout_shapes import layout_drawing

DT = 5e-3


@pytest.mark.parametrize("name", ["wheel_loader", "excavator_22t", "loader_crane", "cat215b"])
def test_all_that_is_asked_for_can_be_reached(name):
    machine = load_machine(name)
    exercises = exercises_of(machine, DT, layout_drawing(machine).ground)
    travels = travels_of(machine)
    reached = reached_poses(travels, slewing=False)
    start = tip_at_joints(machine, np.array([[f.initial.angle for f in machine.functions]]))[0]
    target = exercises["tracking"].path
    np.testing.assert_allclose(target[0], start, atol=1e-9)
    assert 0.2 < np.linalg.norm(np.diff(target, axis=0), axis=1).max() / DT < 1.5  # m/s: it moves, and can be followed
    line = exercises["trench"].path
    assert line[0, 2] == line[1, 2]
    assert np.linalg.norm(line[1] - line[0]) > 2.0 * exercises["trench"].tolerance
    pose = reached.positions[np.argmin(np.linalg.norm(reached.tips - line[0], axis=1))][None]
    for share in np.linspace(0.0, 1.0, 101):
        place = line[0] + share * (line[1] - line[0])
        for _ in range(3):
            way = place - tip_at_joints(machine, pose)
            pose = pose + joint_speeds(tip_jacobian(machine, pose), way, travels.high - travels.low)
        assert np.all((pose >= travels.low) & (pose <= travels.high))
        assert np.linalg.norm(tip_at_joints(machine, pose) - place) < 0.01
    for kind in ("pick and place", "truck loading"):
        path = exercises[kind].path
        assert np.linalg.norm(path[0] - path[1]) > 4.0 * exercises[kind].tolerance
        assert len(path) == len(exercises[kind].payload)
    assert max(exercises["truck loading"].payload) > 0.0


def test_a_machine_that_draws_no_line_has_no_trench():
    machine = load_machine("wheel_loader")
    held = [
        f._replace(stops=f.stops._replace(low=f.initial.angle - 0.01, high=f.initial.angle + 0.01))
        for f in machine.functions
    ]
    exercises = exercises_of(machine._replace(functions=tuple(held)), DT, 0.0)
    assert list(exercises) == ["tracking", "pick and place", "truck loading"]
    assert all(np.isfinite(exercise.path).all() for exercise in exercises.values())
