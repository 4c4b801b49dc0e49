import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.elementary import sincos
from polydraulic.machine.actuator import friction_torque, lever_arm, motor_displacement
from polydraulic.machine.drives import prepare_drive


@given(share=st.floats(0.0, 1.0), link=st.sampled_from(["boom", "stick"]))
def test_lever_arm_is_the_slope_of_the_distance_of_the_pins(machine, share, link):
    f, moved = machine.function(link), machine.link(link)
    prepared, sign = prepare_drive(f, moved), 1.0 if link == "boom" else -1.0
    angle = f.stops.low + share * (f.stops.high - f.stops.low)

    def length(theta):
        x, z = f.pins.rod["x"], f.pins.rod.get("z", 0.0)
        turned = (x * math.cos(theta) - z * math.sin(theta), x * math.sin(theta) + z * math.cos(theta))
        base = (f.pins.base["x"] - moved.at["x"], f.pins.base["z"])
        return math.dist(turned, base)

    slope = (length(angle + 1e-5) - length(angle - 1e-5)) / 2e-5
    assert lever_arm(sincos(angle), prepared) == pytest.approx(sign * slope, rel=1e-8)
    rod_side, head_side = sorted([prepared.area_a, prepared.area_b])
    assert (prepared.area_a, prepared.area_b) == ((head_side, rod_side) if link == "boom" else (rod_side, head_side))


def test_a_motor_moves_its_displacement_times_the_gear_ratio(machine):
    motor = machine.function("swing").drive
    assert motor_displacement(motor) == pytest.approx(motor.displacement * motor.gear_ratio)


def test_friction_opposes_motion(machine):
    f = machine.function("boom").friction
    for rate in (-1.0, -0.01, 0.0, 0.02, 0.5):
        assert friction_torque(rate, f) == pytest.approx(-friction_torque(-rate, f), rel=1e-12)
        assert friction_torque(rate, f) * rate >= 0.0
    assert friction_torque(1.0, f) == pytest.approx(f.coulomb + f.viscous)
