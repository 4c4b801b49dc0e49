"""The Jacobian is the slope of the tip's place, its inverse moves the tip as wanted, and axes of the arm turn with it."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.machine.reach.tip import joint_speeds, slew_sign, tip_at_joints, tip_jacobian, to_arm
from polydraulic.parameters.load import machine_names


def poses(machine, n=20):
    stops = np.array([(f.stops.low, f.stops.high) for f in machine.functions]).clip(-2.0, 2.0)
    return np.random.default_rng(0).uniform(stops[:, 0], stops[:, 1], (n, len(stops)))


@pytest.mark.parametrize("name", machine_names())
def test_the_jacobian_is_the_slope_of_the_tip(name):
    machine, h = load_machine(name), 1e-6
    at = poses(machine)
    steps = h * np.eye(at.shape[1])
    slopes = [(tip_at_joints(machine, at + step) - tip_at_joints(machine, at - step)) / (2.0 * h) for step in steps]
    assert np.allclose(tip_jacobian(machine, at), np.stack(slopes, axis=-1), rtol=0.0, atol=1e-8)


def test_joints_move_the_tip_as_wanted_and_those_that_stand_do_not():
    machine = load_machine("excavator_22t")
    at, wanted = poses(machine), np.array([[0.3, -0.2, 0.1]])
    jacobian = tip_jacobian(machine, at)
    rates = joint_speeds(jacobian, np.repeat(wanted, len(at), axis=0), np.array([1.0, 1.0, 1.0, 0.0]))
    assert np.all(rates[:, 3] == 0.0)
    reached = (jacobian @ rates[..., None])[..., 0]
    close = np.linalg.norm(reached - wanted, axis=1) < 0.02
    assert close.mean() > 0.8  # the others are stretched, where the damping holds joints back
    assert np.isfinite(rates).all()


@pytest.mark.parametrize(("name", "sign"), [("cat215b", 1.0), ("loader_crane", 1.0), ("wheel_loader", 0.0)])
def test_which_machines_slew(name, sign):
    assert slew_sign(load_machine(name)) == sign


def test_axes_of_the_arm_turn_with_it():
    """What lies outward at rest lies to the right once the arm has turned to the left."""
    heading, vector = np.array([0.0, 0.5 * np.pi]), np.array([[2.0, 2.0], [0.0, 0.0], [1.0, 1.0]])
    assert np.allclose(to_arm(heading, vector), [[2.0, 0.0], [0.0, -2.0], [1.0, 1.0]])
