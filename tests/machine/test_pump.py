"""The closed forms of both circuits against bracketed solves with every special case written out."""

import math
from typing import NamedTuple

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from helpers.valves import circuit_pump, orifices
from polydraulic._kernel import driver
from polydraulic.machine.circuits.series.check import PROVED
from polydraulic.machine.circuits.series.short import series_1, series_2
from polydraulic.machine.pump import Pump, delivered
from polydraulic.machine.valve import Orifices
from polydraulic.thesis.excavator import spool_of
from polydraulic.units import to_si

Q = to_si(171.5, "in3/s")
P_RETURN = to_si(50.0, "psi")
RELIEF = to_si(4500.0, "psi")
PUMP = Pump(Q, RELIEF, P_RETURN)
conductance = st.one_of(st.just(0.0), st.floats(1e-12, 2e-5))
pressure = st.one_of(st.sampled_from([0.0, P_RETURN, RELIEF]), st.floats(0.0, 3.5e7))


def single(k_in, k_bypass, p_in):
    return series_1(Orifices(k_in, k_bypass, 0.0), p_in, PUMP)


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
    found = single(k_in, k_bypass, p_in).q_in_1
    # the judge finds the pressure to 1e-9 Pa or a rounding of it, which bounds how well it knows the flow
    slack = 1e-7 + 2e-15 * p
    known = k_in * math.sqrt(slack) if abs(p - p_in) < 1e-3 else k_in * slack / math.sqrt(abs(p - p_in))
    assert found == pytest.approx(q, rel=1e-9, abs=1e-12 * Q + known)


@given(k_in=conductance, k_bypass=conductance, p_in=pressure)
def test_pump_flow_is_shared_out(k_in, k_bypass, p_in):
    q, circuit, _ = single(k_in, k_bypass, p_in)
    assert 0.0 <= q <= Q
    assert circuit.q_bypass >= 0.0
    assert circuit.q_relief >= 0.0
    assert q + circuit.q_bypass + circuit.q_relief == pytest.approx(Q, rel=1e-12)


@given(k_in=st.floats(1e-9, 2e-5), k_bypass=st.floats(1e-9, 2e-5), p_in=st.floats(0.0, 2.5e7))
def test_pump_pressure_drives_both_flows(k_in, k_bypass, p_in):
    circuit = single(k_in, k_bypass, p_in).circuit
    p, _ = judge(k_in, k_bypass, p_in)
    assert circuit.p_pump == pytest.approx(p, rel=1e-7, abs=1.0)


@given(
    k_in=st.floats(1e-9, 2e-5), more=st.floats(1.0, 3.0), k_bypass=conductance, p_in=pressure, higher=st.floats(0, 1e7)
)
def test_flow_rises_with_opening_and_falls_with_pressure(k_in, more, k_bypass, p_in, higher):
    q = single(k_in, k_bypass, p_in).q_in_1
    assert single(k_in * more, k_bypass, p_in).q_in_1 >= q * (1.0 - 1e-12)
    assert single(k_in, k_bypass, p_in + higher).q_in_1 <= q * (1.0 + 1e-12)


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
    found = single(k_in, k_bypass, p_in)
    assert found.q_in_1 == pytest.approx(q, rel=1e-12, abs=1e-20)
    assert found.circuit.p_pump == pytest.approx(p_pump, rel=1e-12)


class Bracketed(NamedTuple):
    """What the judge of the series circuit finds: flows in m3/s."""

    q_pump: float
    q_first: float
    passed: float  # by the first valve
    q_second: float


@numba.njit(error_model="numpy")
def middle_of(low, high):
    middle = 0.5 * (low + high)
    return middle, middle in (low, high)


@numba.njit(error_model="numpy")
def second_valve(w, k_in, k_bypass, p_in, p_return):
    """Pressure before the second valve and flow into its actuator, at the flow w: the printed cases."""
    a, b, drop = k_in * k_in, k_bypass * k_bypass, p_in - p_return
    if a == 0.0 and b == 0.0:
        return (1e30 if w > 0.0 else p_return), 0.0
    if b == 0.0:
        return p_in + w * w / a, w
    if a == 0.0 or w * w / b <= drop:
        return p_return + w * w / b, 0.0
    if drop < 0.0 and w * w / a <= -drop:
        return p_in + w * w / a, w
    low, high = 0.0, w
    for _ in range(200):
        q, done = middle_of(low, high)
        if done:
            break
        if p_in + q * q / a > p_return + (w - q) ** 2 / b:
            high = q
        else:
            low = q
    return (p_in + q * q / a if a >= b else p_return + (w - q) ** 2 / b), q


@numba.njit(error_model="numpy")
def limited(p, pump):
    on = pump.log_least < 0.0 and p > pump.limit_start
    return pump.flow * (pump.limit_start / p) ** pump.limit_exponent if on else pump.flow


@numba.njit(error_model="numpy")
def series_judge(first, second, p_first, p_second, pump):
    """Bracket the flow that passes the first valve's bypass; everything else follows from it."""
    at_relief = limited(pump.relief, pump)
    to_first = first.inlet * math.sqrt(max(pump.relief - p_first, 0.0))
    w = 0.0
    if first.bypass > 0.0:
        low, high = 0.0, pump.flow
        for _ in range(200):
            w, done = middle_of(low, high)
            if done:
                break
            p = second_valve(w, second.inlet, second.bypass, p_second, pump.p_return)[0] + (w / first.bypass) ** 2
            if limited(p, pump) - w - first.inlet * math.sqrt(max(p - p_first, 0.0)) > 0.0:
                low = w
            else:
                high = w
    if w < 1e-15 * pump.flow:
        # Nothing passes. The pressure between the valves may jump there, and says nothing: ask the first valve alone.
        low, high = 0.0, pump.flow
        for _ in range(200):
            q, done = middle_of(low, high)
            if done:
                break
            if limited(p_first + (q / (first.inlet + 1e-300)) ** 2, pump) > q:
                low = q
            else:
                high = q
        q = (
            0.5 * (low + high)
            if limited(p_first + (pump.flow / (first.inlet + 1e-300)) ** 2, pump) < pump.flow
            else pump.flow
        )
        if p_first + (q / (first.inlet + 1e-300)) ** 2 > pump.relief:
            return Bracketed(at_relief, min(at_relief, to_first), 0.0, 0.0)
        return Bracketed(q, q, 0.0, 0.0)
    between, q_second = second_valve(w, second.inlet, second.bypass, p_second, pump.p_return)
    p = between + (w / first.bypass) ** 2
    if p <= pump.relief:
        Q = limited(p, pump)
        return Bracketed(Q, Q - w, w, q_second)
    low, high = 0.0, w
    for _ in range(200):
        w, done = middle_of(low, high)
        if done:
            break
        between, q_second = second_valve(w, second.inlet, second.bypass, p_second, pump.p_return)
        if between + (w / first.bypass) ** 2 < pump.relief:
            low = w
        else:
            high = w
    return Bracketed(at_relief, min(to_first, at_relief - w), w, q_second)


@driver
def errors_against_judge(k, p, pump, out):
    for i in range(k.shape[0]):
        first, second = Orifices(k[i, 0, 0], k[i, 0, 1], 0.0), Orifices(k[i, 1, 0], k[i, 1, 1], 0.0)
        s = series_2(first, second, p[i, 0], p[i, 1], pump)
        true = series_judge(first, second, p[i, 0], p[i, 1], pump)
        circuit = s.circuit
        out[i, 0] = circuit.q_pump - true.q_pump
        out[i, 1] = s.q_in_1 - true.q_first
        out[i, 2] = s.q_in_2 - true.q_second
        out[i, 3] = s.q_in_2 + circuit.q_bypass - true.passed
        out[i, 4] = circuit.q_pump - s.q_in_1 - s.q_in_2 - circuit.q_bypass - circuit.q_relief
        out[i, 5] = circuit.p_pump


def random_states(machine, n, rng):
    """Spools and pressures anywhere, more often at and around knots, in the opening range, and at the settings."""
    knots, travel = np.array(machine.functions[0].valve.knots), spool_of(machine).end
    around = np.array([0.0, 1e-15, -1e-15, 1e-9, -1e-9, 1e-6, -1e-6, 1e-3, -1e-3])
    x = rng.uniform(0.0, travel, (n, 2))
    x = np.where(rng.random((n, 2)) < 0.15, rng.choice(knots, (n, 2)) * (1.0 + rng.choice(around, (n, 2))), x)
    x = np.where(rng.random((n, 2)) < 0.4, rng.uniform(knots[1], knots[4], (n, 2)), x)
    special = [0.0, P_RETURN, RELIEF, to_si(2000.0, "psi"), to_si(5000.0, "psi"), 0.999999 * P_RETURN]
    p = rng.uniform(0.0, RELIEF, (n, 2))
    p = np.where(rng.random((n, 2)) < 0.15, rng.choice(special, (n, 2)), p)
    p[:, 1] = np.where(rng.random(n) < 0.05, p[:, 0], p[:, 1])
    return np.minimum(x, travel) * rng.choice([-1.0, 1.0], (n, 2)), p


def pump_of(machine, exponent, relief):
    limit = {"torque_limit_enabled": exponent > 0.0, "torque_limit_exponent": exponent or 1.0}
    return circuit_pump(machine, "series", relief=relief, **limit)


def check_series(machine, exponent, relief, n, seed):
    pump = pump_of(machine, exponent, relief)
    x, p = random_states(machine, n, np.random.default_rng(seed))
    out = np.empty((n, 6))
    valves = [machine.function(name).valve for name in ("swing", "stick")]
    k = np.stack(
        [[np.interp(np.abs(x[:, i]), v.knots, curve) for curve in (v.inlet, v.bypass)] for i, v in enumerate(valves)]
    )
    errors_against_judge(np.ascontiguousarray(np.moveaxis(k, 2, 0)), p, pump, out)
    assert np.all(np.isfinite(out))
    assert np.abs(out[:, :4]).max() <= 1e-9 * pump.flow
    assert np.abs(out[:, 4]).max() <= 1e-15 * pump.flow
    assert out[:, 5].max() <= relief * (1.0 + 1e-12)


PUMPS = [(0.0, RELIEF), (1.0, RELIEF), (0.5, RELIEF), (2.0, RELIEF), (1.0, 1e12)]  # exponent of the limit, relief


@pytest.mark.parametrize(("exponent", "relief"), PUMPS)
def test_series_circuit_against_the_judge(machine, exponent, relief):
    check_series(machine, exponent, relief, 100 if numba.config.DISABLE_JIT else 20_000, 0)


@pytest.mark.slow
@pytest.mark.parametrize(("exponent", "relief"), PUMPS)
def test_series_circuit_against_the_judge_a_million_times(machine, exponent, relief):
    check_series(machine, exponent, relief, 1_000_000, 1)


@pytest.mark.parametrize(
    ("first", "second", "p_first", "p_second", "share_first", "share_second"),
    [
        ((0.0, 3e-6), (0.0, 3e-6), 1e6, 1e6, 0.0, 0.0),  # both shut
        ((1e-6, 0.0), (1e-6, 1e-6), 1e6, 1e6, 1.0, 0.0),  # first bypass shut: the second gets nothing
        ((0.0, 3e-6), (1e-6, 0.0), 1e6, 1e6, 0.0, 1.0),  # first shut, second open wide
        ((2e-6, 1e-6), (2e-6, 0.0), 1e6, 2.9e7, 1.0, 0.0),  # second beyond reach: the pressure between jumps at no flow
        ((2e-6, 1e-6), (0.0, 3e-6), 2e7, 1e6, 0.0, 0.0),  # first beyond reach, second shut
        ((1.0, 1e-6), (1e-6, 1e-6), 0.0, 1e6, 1.0, 0.0),  # first line below the return pressure
    ],
)
def test_special_cases_in_series(first, second, p_first, p_second, share_first, share_second):
    s = series_2(Orifices(*first, 0.0), Orifices(*second, 0.0), p_first, p_second, PUMP)
    assert s.q_in_1 == pytest.approx(share_first * Q, abs=1e-12 * Q)
    assert s.q_in_2 == pytest.approx(share_second * Q, abs=1e-12 * Q)
    assert s.circuit.q_pump == Q


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
@pytest.mark.parametrize(
    ("first", "second", "p_first", "p_second", "passed"),
    [
        # the second port at relief: at a rounding below, its inlet would pass 7.6e-11 m3/s, 2.7e-8 of the pump's flow
        ((0.0, 3.7036274468251946e-06), (1.5788164562807607e-06, 1.1467949109085463e-14), 29821794.98389532, RELIEF, 6.35221595022541912e-11),
        # both ports at relief: passes swung between what both bypasses take and half of that
        ((1.5658363312151504e-07, 3.127925773062695e-07), (1.3139325723392035e-06, 6.819605427358633e-15), RELIEF, RELIEF, 3.77745017507894675e-11),
        # hardly anything opens a way: the pump's whole flow would need 1e34 Pa
        ((1.3765169928730985e-21, 1.4998756366710008e-06), (1.5788164596536834e-06, 1.249373597200093e-20), RELIEF, 34473786.46584181, 6.92040993244156086e-17),
    ],
)  # fmt: skip
def test_what_passes_at_relief_in_fifty_digits(machine, exponent, first, second, p_first, p_second, passed):
    """Flows past the first valve by brackets in 50 digits, every number here taken as it is; neither inlet opens at relief."""
    pump = pump_of(machine, exponent, RELIEF)
    s = series_2(Orifices(*first, 0.0), Orifices(*second, 0.0), p_first, p_second, pump)
    circuit = s.circuit
    assert s.status == PROVED
    assert (s.q_in_1, s.q_in_2, circuit.p_pump) == (0.0, 0.0, RELIEF)
    assert circuit.q_bypass == pytest.approx(passed, rel=1e-14)
    assert circuit.q_pump == pytest.approx(limited(RELIEF, pump), rel=1e-14)


@given(k_in=conductance, k_bypass=conductance, p_in=pressure, exponent=st.sampled_from([0.5, 1.0, 2.0]))
def test_single_circuit_with_torque_limit(machine, k_in, k_bypass, p_in, exponent):
    """The flow is what the pump gives at the pressure that the flow makes, unless the relief valve is open."""
    pump = pump_of(machine, exponent, RELIEF)
    s = series_1(Orifices(k_in, k_bypass, 0.0), p_in, pump)
    circuit = s.circuit
    assert circuit.q_pump == pytest.approx(delivered(circuit.p_pump, pump), rel=1e-9)
    assert circuit.q_pump == pytest.approx(limited(circuit.p_pump, pump), rel=1e-9)
    assert s.q_in_1 + circuit.q_bypass + circuit.q_relief == pytest.approx(circuit.q_pump, rel=1e-12)
    if circuit.q_relief > 1e-6 * Q:
        assert circuit.p_pump == RELIEF
    elif s.q_in_1 > 1e-6 * Q:
        # the pressure that drives the inlet, known to what rounding of the flow leaves
        assert s.q_in_1 == pytest.approx(k_in * math.sqrt(max(circuit.p_pump - p_in, 0.0)), rel=1e-6, abs=1e-7 * Q)


def test_swing_has_priority(machine):
    """More swing opening never gives the stick more."""
    valves = [machine.function(name).valve for name in ("swing", "stick")]
    second = orifices(0.8 * spool_of(machine).bypass_closed, valves[1])
    flows = [
        series_2(orifices(x, valves[0]), second, 5e6, 5e6, PUMP).q_in_2
        for x in np.linspace(spool_of(machine).deadband, spool_of(machine).end, 40)
    ]
    assert np.all(np.diff(flows) <= 1e-12 * Q)
    assert flows[0] > 0.3 * Q
    assert flows[-1] == 0.0
