"""The closed form of one circuit against a bracketed solve with every special case written out."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from polydraulic.machine.pump import Pump, share_surplus, single_circuit
from polydraulic.units import to_si

Q = to_si(171.5, "in3/s")
P_RETURN = to_si(50.0, "psi")
RELIEF = to_si(4500.0, "psi")
PUMP = Pump(Q, RELIEF, P_RETURN)
conductance = st.one_of(st.just(0.0), st.floats(1e-12, 2e-5))
pressure = st.one_of(st.sampled_from([0.0, P_RETURN, RELIEF]), st.floats(0.0, 3.5e7))


def judge(k_in, k_bypass, p_in):
    """Pump pressure and flow into the actuator, by bracketing the pressure."""

    def through(p):
        return k_in * math.sqrt(max(p - p_in, 0.0)), k_bypass * math.sqrt(max(p - P_RETURN, 0.0))

    if sum(through(RELIEF)) <= Q:
        return RELIEF, through(RELIEF)[0]
    p = brentq(lambda p: sum(through(p)) - Q, min(p_in, P_RETURN), RELIEF, xtol=1e-9, rtol=1e-15, maxiter=500)
    return p, through(p)[0]


@given(k_in=conductance, k_bypass=conductance, p_in=pressure)
def test_closed_form_against_the_judge(k_in, k_bypass, p_in):
    p, q = judge(k_in, k_bypass, p_in)
    found = single_circuit(k_in, k_bypass, p_in, PUMP)
    # the judge finds the pressure to 1e-9 Pa or a rounding of it, which bounds how well it knows the flow
    slack = 1e-7 + 2e-15 * p
    known = k_in * math.sqrt(slack) if abs(p - p_in) < 1e-3 else k_in * slack / math.sqrt(abs(p - p_in))
    assert found == pytest.approx(q, rel=1e-9, abs=1e-12 * Q + known)


@given(k_in=conductance, k_bypass=conductance, p_in=pressure)
def test_pump_flow_is_shared_out(k_in, k_bypass, p_in):
    q = single_circuit(k_in, k_bypass, p_in, PUMP)
    circuit = share_surplus(q, k_in, p_in, k_bypass, PUMP)
    assert 0.0 <= q <= Q
    assert circuit.q_bypass >= 0.0
    assert circuit.q_relief >= 0.0
    assert q + circuit.q_bypass + circuit.q_relief == pytest.approx(Q, rel=1e-12)


@given(k_in=st.floats(1e-9, 2e-5), k_bypass=st.floats(1e-9, 2e-5), p_in=st.floats(0.0, 2.5e7))
def test_pump_pressure_drives_both_flows(k_in, k_bypass, p_in):
    q = single_circuit(k_in, k_bypass, p_in, PUMP)
    circuit = share_surplus(q, k_in, p_in, k_bypass, PUMP)
    p, _ = judge(k_in, k_bypass, p_in)
    assert circuit.p_pump == pytest.approx(p, rel=1e-7, abs=1.0)


@given(
    k_in=st.floats(1e-9, 2e-5), more=st.floats(1.0, 3.0), k_bypass=conductance, p_in=pressure, higher=st.floats(0, 1e7)
)
def test_flow_rises_with_opening_and_falls_with_pressure(k_in, more, k_bypass, p_in, higher):
    q = single_circuit(k_in, k_bypass, p_in, PUMP)
    assert single_circuit(k_in * more, k_bypass, p_in, PUMP) >= q * (1.0 - 1e-12)
    assert single_circuit(k_in, k_bypass, p_in + higher, PUMP) <= q * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("k_in", "k_bypass", "p_in", "q", "p_pump"),
    [
        (0.0, 1e-6, 1e6, 0.0, P_RETURN + (Q / 1e-6) ** 2),  # valve shut
        (1e-6, 0.0, 1e6, Q, 1e6 + (Q / 1e-6) ** 2),  # bypass shut
        (1e-6, 1e-6, 2e7, 0.0, P_RETURN + (Q / 1e-6) ** 2),  # check valve holds
        (1.0, 1e-6, 0.0, Q, (Q / 1.0) ** 2),  # line below the return pressure: no bypass flow
        (0.0, 0.0, 1e6, 0.0, RELIEF),  # dead end
        (1e-6, 0.0, 4e7, 0.0, RELIEF),  # actuator beyond the relief pressure
    ],
)
def test_special_cases(k_in, k_bypass, p_in, q, p_pump):
    found = single_circuit(k_in, k_bypass, p_in, PUMP)
    assert found == pytest.approx(q, rel=1e-12, abs=1e-20)
    assert share_surplus(found, k_in, p_in, k_bypass, PUMP).p_pump == pytest.approx(p_pump, rel=1e-12)
