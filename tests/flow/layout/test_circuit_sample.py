"""Exact circuits at points: those of a machine's step, and the least of the pump's modes."""

import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.machine.pump import limited_pump
from polydraulic.simulation.layout.prepare import prepare_layout

CRANE = load_machine("loader_crane")
LIFT, REACH = CRANE.circuits


def points(circuit, n, seed=0):
    rng = np.random.default_rng(seed)
    travel = rng.uniform(
        0.0, [CRANE.function(f).valve.knots[-1] for f in circuit.functions], (n, 0 + len(circuit.functions))
    )
    return travel, rng.uniform(0.0, circuit.pump.relief, travel.shape)


@pytest.mark.parametrize("circuit", [LIFT, REACH], ids=lambda c: c.name)
def test_flows_are_those_of_the_machines_step(circuit):
    valves = [CRANE.function(f).valve for f in circuit.functions]
    travel, p_in = points(circuit, 40)
    pump = limited_pump(circuit.pump.flow, circuit.pump.relief, CRANE.tank.return_pressure, circuit.pump)
    found = sample_valves(valves, pump, travel, p_in)
    ready = prepare_layout(CRANE, 5e-3)
    zero = dict.fromkeys(CRANE.names, 0.0)
    for k in range(len(travel)):
        spool, p = (
            ready.module.Functions(**{**zero, **dict(zip(circuit.functions, row[k].tolist(), strict=True))})
            for row in (travel, p_in)
        )
        flows = ready.module.exact_step(ready.valves, spool, p)
        of = getattr(flows, f"circuit_{circuit.name}")
        wanted = [getattr(flows.q_in, f) for f in circuit.functions]
        assert found.q_in[k] == pytest.approx(wanted, rel=1e-9, abs=1e-9 * circuit.pump.flow)
        assert (found.q_pump[k], found.p_pump[k]) == pytest.approx((of.q_pump, of.p_pump), rel=1e-9)
        assert found.q_passed[k, -1] == pytest.approx(of.q_bypass, abs=1e-9 * circuit.pump.flow)
        assert getattr(flows, f"between_{circuit.name}_1") == pytest.approx(found.p_between[k, 0], rel=1e-9)
    entered = np.cumsum(found.q_in, axis=1) + found.q_passed + found.q_relief[:, None]
    assert np.allclose(entered, found.q_pump[:, None], atol=1e-9 * circuit.pump.flow)


def test_a_pump_may_deliver_another_flow_at_each_point():
    valves = [CRANE.function(f).valve for f in LIFT.functions]
    travel, p_in = points(LIFT, 3)
    pump = limited_pump(LIFT.pump.flow, LIFT.pump.relief, 0.0, LIFT.pump)
    half = sample_valves(valves, pump._replace(flow=0.5 * pump.flow), travel, p_in)
    given = sample_valves(valves, pump, travel, p_in, np.full(3, 0.5 * pump.flow))
    assert np.array_equal(half.q_in, given.q_in)


def test_points_that_are_not_solved_are_named():
    valves = [CRANE.function(f).valve for f in REACH.functions]
    travel, p_in = points(REACH, 3)
    pump = limited_pump(REACH.pump.flow, REACH.pump.relief, 0.0, REACH.pump)
    with pytest.raises(InputError, match="the exact circuit is not solved at 1 of 3 points, first at travels"):
        sample_valves(valves, pump, travel, np.where(np.arange(3)[:, None] == 1, np.nan, p_in))
