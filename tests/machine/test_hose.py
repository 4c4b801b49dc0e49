import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from polydraulic.machine.hose import line_step, prepare_line


@given(
    spool=st.sampled_from([-0.01, 0.01]),
    p_a=st.floats(0.0, 3e7),
    p_b=st.floats(0.0, 3e7),
    q_in=st.floats(0.0, 2.8e-3),
    k_out=st.floats(0.0, 1.7e-5),
    swept=st.floats(-3e-3, 3e-3),
)
def test_lines_keep_their_bounds_and_their_oil(machine, spool, p_a, p_b, q_in, k_out, swept):
    line, dt = machine.function("boom").line, 0.005
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
    line, k_out, inflow = machine.function("boom").line, 9e-7, 8e-4
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


def test_external_leakage_goes_to_the_tank_from_either_line(machine):
    """Shut lines of a standing actuator empty like C dP/dt = -G P."""
    line, g = machine.function("boom").line._replace(leakage=0.0, external_leakage=2e-12), 2e-12
    prepared, p_a, p_b = prepare_line(line, machine.tank, 1e-3), 2e7, 1e7
    for _ in range(1000):
        after = line_step(0.01, p_a, p_b, 0.0, 0.0, 0.0, 0.0, prepared)
        p_a, p_b = after.p_a, after.p_b
    assert p_a == pytest.approx(2e7 * np.exp(-g / line.compliance_a), rel=1e-3)
    assert p_b == pytest.approx(1e7 * np.exp(-g / line.compliance_b), rel=1e-3)
