import pytest

from polydraulic.machine.circuits.series_pass import (
    AT_FIRST,
    last_tangent,
    limited,
    passed_first,
    passed_last,
    passed_on,
    settled,
    stepped,
    tangent,
    through,
)
from polydraulic.machine.pump import Orifice, Pump, delivered, single_circuit
from polydraulic.machine.valve import Orifices

PUMP = Pump(3e-3, 3e7, 3e5)
VALVE = Orifices(4e-7, 8e-7, 0.0)


def pressure(flow):
    """Of one valve's circuit."""
    return single_circuit(VALVE, 5e6, PUMP._replace(flow=flow)).circuit.p_pump


def test_a_tangent_has_the_pressure_and_slope_of_the_circuit():
    found = last_tangent(2e-3, VALVE, 5e6, PUMP.p_return)
    assert found.p_rest + 4e-6 / found.square == pytest.approx(pressure(2e-3), rel=1e-12)
    assert 4e-3 / found.square == pytest.approx((pressure(2.001e-3) - pressure(1.999e-3)) / 2e-6, rel=1e-5)


@pytest.mark.parametrize(
    ("inlet", "p_in", "behind", "opens"),
    [
        (1e-7, 2e6, Orifice(1e-12, 3e6), (1e-14, 2e6)),
        (1e-7, 4e6, Orifice(1e-12, 3e6), (1e-12, 3e6)),
        (1e-7, 4e6, Orifice(0.0, 3e6), (1e-14, 4e6)),
        (0.0, 2e6, Orifice(1e-12, 3e6), (1e-12, 3e6)),
    ],
)
def test_where_nothing_flows_the_tangent_is_what_opens_first(inlet, p_in, behind, opens):
    assert tangent(0.0, inlet, p_in, behind) == pytest.approx(opens)


def test_orifices_in_a_row_add_their_drops():
    found = through(2e-6, Orifice(1e-12, 3e6))
    assert found.p_rest == 3e6
    assert 1.0 / found.square == pytest.approx(1.0 / 4e-12 + 1.0 / 1e-12)
    assert through(0.0, Orifice(1e-12, 3e6)).square == 0.0


def test_what_arrives_is_shared_and_nothing_passes_a_dead_end():
    single = single_circuit(VALVE, 5e6, PUMP)
    assert passed_last(PUMP.flow, VALVE, 5e6, PUMP.p_return) == pytest.approx(PUMP.flow - single.q_in, rel=1e-12)
    assert passed_on(PUMP.flow, 1e-7, 5e6, Orifice(0.0, 3e5)) == 0.0


def test_no_more_passes_than_relief_pressure_drives():
    narrow = Orifice(1e-14, 3e5)
    assert passed_first(PUMP.flow, 1e-7, 5e6, narrow, PUMP) == pytest.approx((1e-14 * (3e7 - 3e5)) ** 0.5)
    assert passed_first(PUMP.flow, 1e-7, 5e6, Orifice(1e-14, 4e7), PUMP) == 0.0


def test_a_flow_that_turns_back_moves_by_half():
    assert stepped(1.0, AT_FIRST, 0.5, 2.0, False) == (0.5, -0.5)
    assert stepped(1.0, 0.5, 0.6, 2.0, False) == pytest.approx((0.8, -0.2))
    assert stepped(1.0, 0.5, 0.9, 2.0, False) == pytest.approx((0.9, -0.1))  # little enough
    assert stepped(1.0, 0.5, 3.0, 2.0, False) == (2.0, 1.0)
    assert stepped(1.0, 0.5, 3.0, 2.0, True) == (1.0, 0.0)


def test_steps_towards_the_torque_limit_end_at_it():
    pump = PUMP._replace(limit_start=5e6, limit_exponent=1.0, log_least=-1.79)
    y, change = 0.0, AT_FIRST
    for _ in range(8):
        y, change = limited(
            y, change, last_tangent(pump.flow * 2.718281828459045**y, VALVE, 5e6, pump.p_return), pump, False
        )
    q = pump.flow * 2.718281828459045**y
    assert q == pytest.approx(delivered(pressure(q), pump), rel=1e-12)
    assert q < 0.95 * pump.flow
    assert limited(y, change, Orifice(1e-18, 1e7), pump, True).value == y


def test_settled_is_a_rounding_of_the_flow():
    assert settled(1e-19, 3e-3)
    assert not settled(1e-14, 3e-3)
