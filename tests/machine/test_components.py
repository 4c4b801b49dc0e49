"""Each component against its own equation, solved another way."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from polydraulic.elementary import sincos
from polydraulic.errors import InputError
from polydraulic.flow.record import from_vector, to_vector
from polydraulic.machine.actuator import friction_torque, lever_arm, prepare_cylinder
from polydraulic.machine.hose import line_step, prepare_line
from polydraulic.machine.linkage import end_effector, end_effector_printed
from polydraulic.machine.pilot import pilot_step, prepare_pilot
from polydraulic.machine.plant import prepare
from polydraulic.machine.state import initial_state
from polydraulic.machine.valve import orifice_flow, orifices, prepare_valve


def test_state_and_vector(machine):
    x = initial_state(machine)
    assert from_vector(to_vector(x)) == x
    assert to_vector(x).shape == (15,)


@pytest.mark.parametrize("voltage", [0.3, -0.5, 5.0])
def test_pilot_is_the_exact_first_order_answer(machine, voltage):
    pilot = machine.boom.pilot
    prepared = prepare_pilot(pilot, machine.spool, 0.005)
    x = 0.0
    for _ in range(40):
        x = pilot_step(x, voltage, prepared)
    target = max(-machine.spool.knots[-1], min(machine.spool.knots[-1], pilot.gain * voltage))
    assert x == pytest.approx(target * (1.0 - math.exp(-0.2 / pilot.time_constant)), rel=1e-12)


@pytest.mark.parametrize("link", ["swing", "boom", "stick"])
def test_orifices_meet_their_tables(machine, link):
    valve = getattr(machine, link).valve
    prepared = prepare_valve(valve, machine.spool)
    for sign, outlet in ((1.0, valve.outlet_positive), (-1.0, valve.outlet_negative)):
        for i, knot in enumerate(machine.spool.knots):
            k = orifices(sign * knot, prepared)
            expected = (valve.inlet[i], valve.bypass[i], (valve.outlet_positive if knot == 0.0 else outlet)[i])
            assert tuple(k) == pytest.approx(expected, rel=1e-13, abs=1e-25)


@given(x=st.floats(-0.02, 0.02))
def test_orifices_are_linear_between_knots_and_exactly_shut(machine, x):
    prepared = prepare_valve(machine.boom.valve, machine.spool)
    k = orifices(x, prepared)
    knots, travel = machine.spool.knots, abs(x)
    assert k.inlet == pytest.approx(np.interp(travel, knots, machine.boom.valve.inlet), rel=1e-12, abs=1e-22)
    if travel <= machine.spool.deadband:
        assert k.inlet == 0.0
        assert k.outlet == 0.0
    if travel >= machine.spool.bypass_closed:
        assert k.bypass == 0.0


def test_check_valve():
    assert orifice_flow(2.0, -4.0) == 0.0
    assert orifice_flow(2.0, 4.0) == 4.0


@given(
    spool=st.sampled_from([-0.01, 0.01]),
    p_a=st.floats(0.0, 3e7),
    p_b=st.floats(0.0, 3e7),
    q_in=st.floats(0.0, 2.8e-3),
    k_out=st.floats(0.0, 1.7e-5),
    swept=st.floats(-3e-3, 3e-3),
)
def test_lines_keep_their_bounds_and_their_oil(machine, spool, p_a, p_b, q_in, k_out, swept):
    line, dt = machine.boom.line, 0.005
    prepared = prepare_line(line, machine.tank, dt)
    after = line_step(spool, p_a, p_b, q_in, k_out, swept, -0.5 * swept, prepared)
    assert machine.tank.floor <= min(after.p_a, after.p_b)
    assert max(after.p_a, after.p_b) <= line.relief
    assert after.q_out >= 0.0
    flows = {
        "a": (q_in if spool > 0 else -after.q_out) - swept,
        "b": (-after.q_out if spool > 0 else q_in) + 0.5 * swept,
    }
    for p0, p1, c, q in (
        (p_a, after.p_a, line.compliance_a, flows["a"]),
        (p_b, after.p_b, line.compliance_b, flows["b"]),
    ):
        if machine.tank.floor < p1 < line.relief:
            assert c * (p1 - p0) == pytest.approx(dt * q, abs=1e-12 + 1e-9 * abs(dt * q))


def test_implicit_outlet_follows_the_differential_equation(machine):
    line, k_out, inflow = machine.boom.line, 9e-7, 8e-4
    p_e = machine.tank.return_pressure

    def rate(t, p):
        return (inflow - k_out * np.sqrt(np.maximum(p - p_e, 0.0))) / line.compliance_b

    tight = solve_ivp(rate, (0.0, 0.1), [9e6], rtol=1e-10, atol=1.0).y[0, -1]
    errors = []
    for n in (50, 100):
        prepared = prepare_line(line, machine.tank, 0.1 / n)
        p_b = 9e6
        for _ in range(n):
            p_b = line_step(0.01, 1e6, p_b, 0.0, k_out, 0.0, -inflow, prepared).p_b
        errors.append(abs(p_b - tight))
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 1e-2 * tight


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


def test_end_effector_is_a_rotation(machine):
    g = machine.geometry
    swing = np.linspace(-3.0, 3.0, 7)
    angle = np.column_stack([swing, np.full(7, 0.5), np.full(7, -1.4)])
    position = end_effector(angle, g)
    assert np.hypot(position[:, 0], position[:, 1]) == pytest.approx(np.hypot(position[3, 0], position[3, 1]))
    c1, s1 = np.cos(swing), np.sin(swing)
    c2, c23 = math.cos(0.5), math.cos(-0.9)
    printed = end_effector_printed(angle, g)
    assert printed[:, 0] == pytest.approx(1.8 * c1 * c23 + 5.19 * c1 * c2 + 0.81 * c1 + 0.12 * s1)
    assert printed[:, 1] == pytest.approx(1.8 * s1 * c23 + 5.19 * s1 * c2 + 0.81 * s1 + 0.12 * c1)
    assert printed[:, 2] == pytest.approx(1.8 * math.sin(-0.9) + 5.19 * math.sin(0.5))


@pytest.mark.parametrize("dt", [0.0, -0.005, math.nan, math.inf])
def test_step_size_must_be_positive(machine, dt):
    with pytest.raises(InputError, match="time step must be positive"):
        prepare(machine, dt)
