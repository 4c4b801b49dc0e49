"""Torques at joints against what a pendulum needs."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.machine.joint_torques import torques_of_friction, torques_of_motion


def test_at_rest_a_joint_carries_the_weight_behind_it():
    machine = load_machine("cat215b")
    q = np.zeros((2, 3))
    q[1] = 0.2, 0.3, -1.0
    still = np.zeros_like(q)
    needed = torques_of_motion(machine, q, still, still)
    assert needed[:, 0] == pytest.approx(0.0, abs=1e-6)  # upright
    stick = machine.link("stick")
    arm = np.hypot(stick.cg["x"], stick.cg["z"])
    lean = np.arctan2(stick.cg["z"], stick.cg["x"]) + q[:, 1] + q[:, 2]
    assert needed[:, 2] == pytest.approx(machine.gravity * stick.mass * arm * np.cos(lean), rel=1e-9)


def test_friction_is_against_the_rate_and_unsure_at_rest():
    machine = load_machine("cat215b")
    fast = np.full((1, 3), 1.0)
    friction, unsure = torques_of_friction(machine, np.concatenate([fast, -fast, 0.0 * fast]))
    for k, f in enumerate(machine.functions):
        assert friction[0, k] == pytest.approx(f.friction.coulomb + f.friction.viscous, rel=0.02)
        assert friction[1, k] == -friction[0, k]
        assert friction[2, k] == 0.0
        assert unsure[2, k] == pytest.approx(f.friction.static / np.sqrt(3.0))
