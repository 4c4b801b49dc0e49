from fractions import Fraction

import numpy as np
import pytest

from helpers.series_made import pump_of, series, solved
from polydraulic.machine.circuits.series.check import FAR, REPAIRED, UNPROVED
from polydraulic.machine.circuits.series.march import (
    Climb,
    asks_too_much,
    before_bypass,
    before_outlet,
    climbed,
    march_status,
    over,
    reached_at,
)
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices

PUMP = Pump(3e-3, 3e7, 3e5)


def test_differences_are_rounded_once():
    rng = np.random.default_rng(0)
    for _ in range(300):
        base, p = rng.uniform(0.0, 3e7, 2)
        p = base * (1.0 + rng.choice([0.0, 1e-15, 1e-9])) if rng.random() < 0.5 else p
        y = max(p - base, 0.0) * (1.0 + rng.choice([0.0, 1e-14, -1e-10])) + rng.choice([0.0, 1e-9])
        true = Fraction(y) + Fraction(base) - Fraction(p)
        assert abs(Fraction(over(y, base, p)) - true) <= abs(true) * Fraction(1, 2**52)


def test_a_climb_adds_drops_and_inlets():
    x = climbed(Climb(4e6, 1e-4), Orifices(1e-7, 1e-7, 0.0), 2e6, 1e6)
    assert x.y == pytest.approx(4e6 + (1e-4 / 1e-7) ** 2)
    assert x.flow == pytest.approx(1e-4 + 1e-7 * (x.y + 1e6 - 2e6) ** 0.5)
    assert climbed(Climb(4e6, 1e-4), Orifices(0.0, 0.0, 0.0), 2e6, 1e6).y == FAR


def test_too_much_is_more_than_the_pump_gives_or_beyond_relief():
    assert not asks_too_much(Climb(1e7, 2.9e-3), 1e6, PUMP)
    assert asks_too_much(Climb(1e7, 3.1e-3), 1e6, PUMP)
    assert not asks_too_much(Climb(2.9e7, 1e-3), 1e6, PUMP)
    assert asks_too_much(Climb(2.9e7 + 1e-8, 1e-3), 1e6, PUMP)


def test_an_outlet_that_opens_is_the_new_base_and_one_that_stays_shut_bounds():
    m = reached_at(1e6, PUMP)
    m = before_outlet(m, 1e6, 1e3, 1.1e3, 1e-7)
    assert (m.base, m.low, m.high) == (1e6, 1e6, 1.1e3 * 1.1e3)
    assert (m.flow_low, m.flow_high) == pytest.approx((1e-4, 1.1e-4))
    shut = before_outlet(m, 2.1e6, 0.0, 0.0, 1e-7)
    assert (shut.base, shut.low, shut.high) == (1e6, 1e6, 1.1e6)
    assert before_outlet(m, 2.1e6, 0.0, 0.0, 0.0) == m
    lifted = before_bypass(m, 1e-7)
    assert lifted.low == pytest.approx(1e6 + 1e6)
    assert lifted.high > lifted.low


def test_a_bracket_that_is_open_is_no_repair():
    m = reached_at(1e6, PUMP)._replace(low=1e6, high=1e6, flow_low=3e-3, flow_high=3e-3)
    assert march_status(m, 3e-3, PUMP) == REPAIRED
    assert march_status(m._replace(flow_high=3.1e-3), 3e-3, PUMP) == UNPROVED
    assert march_status(m._replace(flow_low=2e-3, flow_high=2e-3), 3e-3, PUMP) == UNPROVED
    assert march_status(m._replace(flow_low=2e-3, flow_high=2e-3, high=2.9e7), 3e-3, PUMP) == REPAIRED


@pytest.mark.parametrize("broken", [np.nan, 1e35])
def test_what_is_no_pressure_is_never_trusted(machine, broken):
    rng, pump = np.random.default_rng(1), pump_of(machine, 0.0)
    states = [10.0 ** rng.uniform(-8.0, -5.0, (6, 3)) for _ in range(2)] + [rng.uniform(0.0, 1e7, (6, 3))]
    for i in range(3):
        states[2][i, i] = broken
    found = solved(series(3).solve_all, states, pump)
    assert np.all(found[:3, 7] == UNPROVED)
    assert np.all(found[3:, 7] != UNPROVED)
