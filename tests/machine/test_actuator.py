import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.elementary import sincos
from polydraulic.machine.actuator import friction_torque, lever_arm, prepare_cylinder


@given(share=st.floats(0.0, 1.0), link=st.sampled_from(["boom", "stick"]))
def test_lever_arm_is_the_slope_of_the_length(machine, share, link):
    part = getattr(machine, link)
    cylinder, sign = part.cylinder, 1.0 if link == "boom" else -1.0
    prepared = prepare_cylinder(cylinder, sign)
    angle = part.stops.low + share * (part.stops.high - part.stops.low)

    def length(theta):
        psi = sign * theta + cylinder.angle_offset
        return math.sqrt(
            cylinder.r_base**2 + cylinder.r_link**2 - 2 * cylinder.r_base * cylinder.r_link * math.cos(psi)
        )

    slope = sign * (length(angle + 1e-5) - length(angle - 1e-5)) / 2e-5
    assert lever_arm(sincos(angle), prepared) == pytest.approx(slope, rel=1e-8)
    rod_side, head_side = sorted([prepared.area_a, prepared.area_b])
    assert (prepared.area_a, prepared.area_b) == ((head_side, rod_side) if link == "boom" else (rod_side, head_side))


def test_friction_opposes_motion(machine):
    f = machine.boom.friction
    for rate in (-1.0, -0.01, 0.0, 0.02, 0.5):
        assert friction_torque(rate, f) == pytest.approx(-friction_torque(-rate, f), rel=1e-12)
        assert friction_torque(rate, f) * rate >= 0.0
    assert friction_torque(1.0, f) == pytest.approx(f.coulomb + f.viscous)
