"""A valve that draws from a feed, against a bracketed solve for its pressure."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from polydraulic.machine.feed import Bypass, Feed, bypass_flow, draw
from polydraulic.units import to_si

Q = to_si(171.5, "in3/s")
RELIEF = to_si(4500.0, "psi")
conductance = st.one_of(st.just(0.0), st.floats(1e-8, 1e-5))
pressure = st.one_of(st.sampled_from([0.0, 344737.9, RELIEF]), st.floats(0.0, 3.2e7))
resistance = st.one_of(st.just(0.0), st.floats(1e6, 1e12))
impedance = st.floats(1e8, 1e13)
offered = st.floats(0.0, 3.0)


def through(p, k_in, p_in, bypass):
    """Both flows at a pressure, each from its own equation."""
    drop, r, b = max(p - bypass.p_rest, 0.0), bypass.resistance, bypass.square
    q_bypass = 0.0
    if b > 0.0 and drop > 0.0:
        half = 0.5 * r * b
        root = half + math.sqrt(half * half + b * drop)  # 0 where a tiny drop underflows
        q_bypass = b * drop / root if root > 0.0 else 0.0
    return k_in * math.sqrt(max(p - p_in, 0.0)), q_bypass


def judge(feed, k_in, p_in, bypass):
    """Pressure before the valve, by bracketing it."""

    def surplus(p):
        return (p - feed.pressure) / feed.impedance + sum(through(p, k_in, p_in, bypass))

    if surplus(RELIEF) <= 0.0:
        return RELIEF
    return brentq(surplus, min(0.0, feed.pressure), RELIEF, xtol=1e-9, rtol=1e-15, maxiter=500)


@given(k_in=conductance, k_bypass=conductance, p_in=pressure, p_rest=pressure, r=resistance, z=impedance, share=offered)
def test_a_valve_against_the_judge(k_in, k_bypass, p_in, p_rest, r, z, share):
    bypass = Bypass(p_rest, r, k_bypass * k_bypass)
    feed = Feed(min(p_in, p_rest) + share * z * Q, z)
    p = judge(feed, k_in, p_in, bypass)
    d = draw(feed, k_in, p_in, bypass, RELIEF)
    assert d.p == pytest.approx(p, rel=1e-6, abs=100.0)
    # what the feed gives is what is drawn and relieved, and the flows drive the pressure
    given_ = (feed.pressure - d.p) / z
    assert d.q_in + d.q_bypass + d.q_relief == pytest.approx(given_, rel=1e-9, abs=1e-9 * Q)
    q_in, q_bypass = through(d.p, k_in, p_in, bypass)
    slack = 1e-5 * Q + 1e-5 * max(q_in, q_bypass)
    assert d.q_in == pytest.approx(q_in, abs=slack + k_in * 10.0)
    assert d.q_bypass == pytest.approx(q_bypass, abs=slack + k_bypass * 10.0)


def test_special_cases():
    shut, wide = Bypass(0.0, 0.0, 0.0), Bypass(1e6, 0.0, 1e-12)
    dead = draw(Feed(5e6, 1e9), 0.0, 0.0, shut, RELIEF)
    assert (dead.q_in, dead.q_bypass, dead.q_relief, dead.p) == pytest.approx((0.0, 0.0, 0.0, 5e6), abs=1e-60)
    over = draw(Feed(RELIEF + 1e6, 1e9), 0.0, 0.0, shut, RELIEF)
    assert over.p == RELIEF
    assert over.q_relief == pytest.approx(1e-3)
    low = draw(Feed(5e5, 1e9), 1e-6, 2e6, wide, RELIEF)  # below both: check valves hold
    assert (low.q_in, low.q_bypass, low.p) == (0.0, 0.0, 5e5)
    inlet = draw(Feed(5e6, 1e9), 1e-6, 2e6, Bypass(2e7, 1e10, 1e-12), RELIEF)  # only the inlet is below
    assert inlet.q_bypass == 0.0
    assert inlet.q_in == pytest.approx(1e-6 * math.sqrt(inlet.p - 2e6), rel=1e-12)
    assert bypass_flow(1e6 + 4.0, Bypass(1e6, 0.0, 1e-12)) == pytest.approx(2e-6)
    assert bypass_flow(1e6 + 4.0, Bypass(1e6, 2.0, 1e200)) == pytest.approx(2.0)
