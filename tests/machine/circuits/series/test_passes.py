from math import exp, log

import numpy as np
import pytest

from polydraulic.machine.circuits.series.passes import (
    AT_FIRST,
    SHUT,
    Moved,
    Outlet,
    behind,
    least_flow,
    limited,
    limited_law,
    limited_power,
    passed_first,
    passed_on,
    resistance,
    settled,
    stepped,
    tangent,
)
from polydraulic.machine.circuits.series.short import series_1
from polydraulic.machine.pump import Pump, delivered
from polydraulic.machine.valve import Orifices

PUMP = Pump(3e-3, 3e7, 3e5)
VALVE = Orifices(4e-7, 8e-7, 0.0)
INLET, TANK = resistance(VALVE.inlet), Outlet(resistance(VALVE.bypass), PUMP.p_return)
CLOSED = resistance(0.0)


def pressure(flow):
    """Of one valve's circuit."""
    return series_1(VALVE, 5e6, PUMP._replace(flow=flow)).circuit.p_pump


def test_what_is_shut_resists_more_than_what_is_open():
    assert resistance(2e-7) == pytest.approx(2.5e13)
    assert resistance(1e-29) < SHUT < CLOSED


def test_a_tangent_has_the_pressure_and_slope_of_the_circuit():
    found = tangent(2e-3, INLET, 5e6, TANK)
    assert found.p_rest + found.r * 4e-6 == pytest.approx(pressure(2e-3), rel=1e-12)
    assert 4e-3 * found.r == pytest.approx((pressure(2.001e-3) - pressure(1.999e-3)) / 2e-6, rel=1e-5)


@pytest.mark.parametrize("flow", [0.0, 1e-3])
@pytest.mark.parametrize(
    ("inlet", "p_in", "beyond", "alone"),
    [
        (1e14, 2e6, Outlet(1e12, 2e8), (1e14, 2e6)),
        (1e14, 4e8, Outlet(1e12, 3e6), (1e12, 3e6)),
        (1e14, 4e6, Outlet(CLOSED, 3e6), (1e14, 4e6)),
        (CLOSED, 2e6, Outlet(1e12, 3e6), (1e12, 3e6)),
    ],
)
def test_where_one_of_both_passes_nothing_the_tangent_is_the_other(flow, inlet, p_in, beyond, alone):
    assert tangent(flow, inlet, p_in, beyond) == alone


def test_no_flow_is_too_small_for_a_number():
    for flow in (0.0, 1e-300, 1e-100, 1e-30, 1e-9):
        for inlet in (1e8, 1e14, CLOSED):
            for r in (1e8, 1e14, CLOSED):
                for p in (0.0, 3e6, 4e7):
                    beyond = Outlet(r, 3e6)
                    assert np.isfinite(tangent(flow, inlet, p, beyond)).all()
                    assert 0.0 <= passed_on(flow, inlet, p, beyond) <= flow


def test_orifices_in_a_row_add_their_drops():
    tail = tangent(2e-3, INLET, 5e6, TANK)
    assert behind(2e-3, INLET, 5e6, TANK, 3e12) == (3e12 + tail.r, tail.p_rest)
    assert behind(2e-3, INLET, 5e6, TANK, CLOSED).r >= SHUT


def test_what_arrives_is_shared_and_nothing_passes_a_dead_end():
    single = series_1(VALVE, 5e6, PUMP)
    assert passed_on(PUMP.flow, INLET, 5e6, TANK) == pytest.approx(PUMP.flow - single.q_in_1, rel=1e-12)
    assert passed_on(PUMP.flow, INLET, 5e6, Outlet(CLOSED, 3e5)) == 0.0
    assert passed_on(PUMP.flow, CLOSED, 5e6, TANK) == PUMP.flow


def test_no_more_passes_than_relief_pressure_drives():
    narrow = Outlet(1e14, 3e5)
    assert passed_first(PUMP.flow, 1e14, 5e6, narrow, PUMP) == pytest.approx((1e-14 * (3e7 - 3e5)) ** 0.5)
    assert passed_first(PUMP.flow, 1e14, 5e6, Outlet(1e14, 4e7), PUMP) == 0.0


def test_a_flow_that_turns_back_moves_by_half():
    assert stepped(1.0, AT_FIRST, 0.5, 2.0, False) == (0.5, -0.5)
    assert stepped(1.0, 0.5, 0.6, 2.0, False) == pytest.approx((0.8, -0.2))
    assert stepped(1.0, 0.5, 0.9, 2.0, False) == pytest.approx((0.9, -0.1))  # little enough
    assert stepped(1.0, 0.5, 3.0, 2.0, False) == (2.0, 1.0)
    assert stepped(1.0, 0.5, 3.0, 2.0, True) == (1.0, 0.0)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("step", [limited, limited_law])
def test_steps_towards_the_torque_limit_end_at_it(step, exponent):
    pump = PUMP._replace(limit_start=5e6, limit_exponent=exponent, log_least=-exponent * log(6.0))
    assert least_flow(pump) == pytest.approx(pump.flow * exp(pump.log_least))
    q, change = pump.flow, AT_FIRST
    for _ in range(8):
        before = q
        q, change = step(q, change, least_flow(pump), tangent(q, INLET, 5e6, TANK), pump, False)
        assert change == pytest.approx(q / before - 1.0, abs=1e-15)
    assert q == pytest.approx(delivered(pressure(q), pump), rel=1e-12)
    assert q < 0.95 * pump.flow
    assert step(q, change, 0.0, Outlet(1e18, 1e7), pump, True) == (q, 0.0)


def test_a_pump_of_power_needs_no_logarithm():
    pump = PUMP._replace(limit_start=5e6, limit_exponent=1.0, log_least=-log(6.0))
    whole = tangent(2e-3, INLET, 5e6, TANK)
    given = (2e-3, AT_FIRST, least_flow(pump), whole, pump, False)
    assert limited(*given) == limited_power(*given)
    assert limited_power(*given).value == pytest.approx(limited_law(*given).value, rel=1e-2)


def test_a_pump_below_its_limit_delivers_its_flow():
    pump = PUMP._replace(limit_start=2e7, limit_exponent=1.0, log_least=-log(1.5))
    whole = Outlet(0.0, 1e7)
    assert limited(pump.flow, AT_FIRST, least_flow(pump), whole, pump, False) == Moved(pump.flow, 0.0)
    assert limited(0.999 * pump.flow, AT_FIRST, least_flow(pump), whole, pump, False).value == pump.flow
    assert limited(pump.flow, AT_FIRST, pump.flow, Outlet(0.0, 2.5e7), PUMP, False) == Moved(PUMP.flow, 0.0)  # has none


def test_settled_is_small_and_what_falls_so_fast_that_the_next_pass_changes_a_rounding():
    assert settled(1e-12, 1e-5, 3e-3)
    assert settled(0.0, 0.0, 3e-3)
    assert not settled(1e-12, 1e-10, 3e-3)  # by halves, or little more
    assert not settled(1e-10, AT_FIRST, 3e-3)  # not small
    assert not settled(AT_FIRST, AT_FIRST, 3e-3)
