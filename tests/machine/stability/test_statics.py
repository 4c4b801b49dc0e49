"""Torques at rest, and the pressures that hold them: against weights times arms, and MuJoCo."""

from math import cos, pi, sin

import numpy as np
import pytest

from helpers.statics import Statics, lever_of
from polydraulic import load_machine
from polydraulic.machine.stability.statics import holding_pressures, static_torques


def test_static_torques_are_weights_times_arms():
    machine = load_machine("wheel_loader")
    lift, tilt = 0.3, -0.2
    ((torque, _),) = static_torques(machine, np.array([[lift, tilt]]), 100.0)
    bucket = 2.6 * cos(lift)
    arm = 1250.0 * (1.25 * cos(lift) - 0.1 * sin(lift))
    load = 3650.0 * (bucket + 0.65 * cos(lift + tilt) - 0.35 * sin(lift + tilt)) + 100.0 * (
        bucket + 1.3 * cos(lift + tilt)
    )
    assert torque == pytest.approx(9.81 * (arm + load), rel=1e-12)


def test_pressures_that_hold_are_equal_to_the_torque():
    machine = load_machine("wheel_loader")
    row = np.array([[0.1, 0.2]])
    (p_a, p_b), _ = holding_pressures(machine, row, 500.0)[0]
    statics = Statics(machine, row[0])
    lever = lever_of(statics, machine.functions[0], row[0, 0])
    head, rod = (2 * pi / 4.0 * (0.12**2 - d**2) for d in (0.0, 0.07))
    torque = statics.torques[0] + 500.0 * statics.torques_per_kg[0]
    assert (p_a * head - p_b * rod) * lever == pytest.approx(torque, rel=1e-9)
    assert min(p_a, p_b) == machine.tank.return_pressure
