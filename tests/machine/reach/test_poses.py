"""Poses are seen where tips are: inside the stops, in one plane if the arm does not slew, the nearest to a place found."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.machine.reach.poses import nearest_pose, reached_poses
from polydraulic.machine.reach.tip import tip_at_joints, to_arm
from polydraulic.machine.reach.travels import travels_of


@pytest.mark.parametrize("name", ["cat215b", "wheel_loader"])
def test_an_arm_that_does_not_slew_stays_in_its_plane(name):
    machine = load_machine(name)
    travels = travels_of(machine)
    start = np.array([f.initial.angle for f in machine.functions])
    reached = reached_poses(travels, slewing=False)
    assert np.all((reached.positions >= travels.low) & (reached.positions <= travels.high))
    assert np.array_equal(reached.tips, tip_at_joints(machine, reached.positions))
    heading = np.full(len(reached.tips), start[0] if name == "cat215b" else 0.0)
    assert np.ptp(to_arm(heading, reached.tips.T)[1]) < 1e-12
    assert 3.0 < reached.size < 15.0


def test_the_nearest_pose_is_the_one_whose_tip_is_there():
    machine = load_machine("excavator_22t")
    reached = reached_poses(travels_of(machine), slewing=False)
    tip = tip_at_joints(machine, nearest_pose(reached, 6.0, 1.0))
    assert tip == pytest.approx([6.0, 0.0, 1.0], abs=0.2)  # slews about z at 0
    k = 1234
    assert np.array_equal(nearest_pose(reached, reached.out[k], reached.tips[k, 2]), reached.positions[k])


def test_slewing_spreads_them_to_both_sides():
    reached = reached_poses(travels_of(load_machine("excavator_22t")))
    assert reached.tips[:, 1].min() < -3.0
    assert reached.tips[:, 1].max() > 3.0
