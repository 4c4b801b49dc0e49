import pytest

from helpers.flow_steps import PSI, states, step, step_all, with_limit
from polydraulic import build_flow
from polydraulic.thesis.excavator import pump_of, spool_of, without_relief


def test_the_torque_limit_lowers_both_flows(machine):
    lower = with_limit(machine)
    free, limited = build_flow("exact", machine), build_flow("exact", lower)
    lowered = 0
    for spool, p_in, p_out in states(machine):
        without, flows = step_all(machine, free, spool, p_in, p_out), step_all(lower, limited, spool, p_in, p_out)
        for before, after in ((without.boom, flows.boom), (without.series, flows.series)):
            start = pump_of(machine, "boom").torque_limit_start
            if before.p_pump <= start:
                assert tuple(after) == pytest.approx(tuple(before), rel=1e-10, abs=1e-10 * before.q_pump)
                assert after.q_pump == before.q_pump
            else:
                lowered += 1
                power = after.q_pump * after.p_pump
                assert power == pytest.approx(before.q_pump * start, rel=1e-8)
    assert lowered > 50


def test_relief_valve_bounds_the_pressure(machine):
    exact, without = build_flow("exact", machine), without_relief(machine)
    spool, p_in = spool_of(machine).bypass_closed, 4000 * PSI
    bounded = step(machine, exact, spool, p_in, 0.0)
    assert bounded.boom.p_pump == pump_of(machine, "boom").relief
    assert bounded.boom.q_relief > 0.0
    free = step(without, exact, spool, p_in, 0.0)
    assert free.boom.p_pump > pump_of(machine, "boom").relief
    assert free.q_in.boom == pump_of(machine, "boom").flow
