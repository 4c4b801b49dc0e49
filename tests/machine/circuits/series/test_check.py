"""The certificate bounds the error of flows, whatever they are."""

import numba
import numpy as np
import pytest

from helpers.series_made import STATES, pump_of, series, solved
from polydraulic.machine.circuits.series.check import (
    FAR,
    PROVED,
    UNPROVED,
    Junction,
    delivers,
    first_node,
    node,
    status_of,
)
from polydraulic.machine.pump import Circuit, Pump
from polydraulic.machine.valve import Orifices

PUMP = Pump(3e-3, 3e7, 3e5)


def certificate(q, passed, q_relief, k, p, pump):
    """Sum of all differences for flows into actuators and past valves."""
    ports, behind = [*p, pump.p_return], Junction(0.0, 0.0)
    for i in range(len(k) - 1, 0, -1):
        behind = node(q[i], passed[i], k[i], ports[i], ports[i + 1], behind)
    return first_node(q[0], passed[0], q_relief, k[0], ports[0], ports[1], behind, pump)


@pytest.mark.parametrize("kind", ["real", "hard"])
def test_no_flow_is_further_off_than_the_certificate_says(machine, kind):
    """Flows that are moved from those of the circuit, so that they still add up."""
    n, rng, pump, tight = 4, np.random.default_rng(0), pump_of(machine, 0.0), 0
    states = STATES[kind](machine, n, 40 if numba.config.DISABLE_JIT else 1000, rng)
    true = solved(series(n).repair_all, states, pump)
    for inlets, bypasses, p, row in zip(*states, true, strict=True):
        passed = np.append(row[n] + np.cumsum(row[n - 1 : 0 : -1])[::-1], row[n])
        moved = np.sort(passed * rng.uniform(0.9, 1.1, n) + 1e-3 * rng.random(n) * pump.flow)[::-1]
        moved[-1] = np.minimum(moved[-1], moved).min()
        arriving = np.append(max(row[0] + passed[0], moved[0]), moved[:-1])
        q = arriving - moved
        k = [Orifices(a, b, 0.0) for a, b in zip(inlets, bypasses, strict=True)]
        found = certificate(q, moved, pump.flow - arriving[0], k, p, pump)
        error = max(np.abs(q - row[:n]).max(), np.abs(moved - passed).max())
        assert error <= found.unmet * (1.0 + 1e-9) + 1e-9 * pump.flow
        tight += error > 0.01 * found.unmet
    assert tight > 0.2 * len(true)


def test_a_node_where_nothing_arrives_has_the_pressure_that_opens_first():
    behind = Junction(2e6, 0.0)  # the next port is at 3e6, the next node at 5e6
    assert node(0.0, 0.0, Orifices(1e-6, 1e-6, 0.0), 4e6, 3e6, behind).over == 0.0
    assert node(0.0, 0.0, Orifices(1e-6, 1e-6, 0.0), 6e6, 3e6, behind).over == -1e6
    assert node(0.0, 0.0, Orifices(0.0, 1e-6, 0.0), 4e6, 3e6, behind).over == 1e6
    assert node(0.0, 0.0, Orifices(0.0, 0.0, 0.0), 4e6, 3e6, behind).over == FAR


def test_an_open_relief_valve_holds_its_pressure():
    k, behind = Orifices(1e-7, 1e-7, 0.0), Junction(0.0, 0.0)
    q, passed = 1e-7 * (PUMP.relief - 1e6) ** 0.5, 1e-7 * (PUMP.relief - 2e6) ** 0.5
    found = first_node(q, passed, PUMP.flow - q - passed, k, 1e6, 2e6, behind, PUMP)
    assert found.p == PUMP.relief
    assert found.unmet <= 1e-15 * PUMP.flow
    assert first_node(0.9 * q, passed, PUMP.flow, k, 1e6, 2e6, behind, PUMP).unmet == pytest.approx(0.1 * q)


def test_status_says_whether_flows_are_proved():
    assert status_of(0.0, PUMP) == PROVED
    assert status_of(1e-9 * PUMP.flow, PUMP) == UNPROVED
    assert status_of(float("nan"), PUMP) == UNPROVED


def test_a_pump_with_torque_limit_is_judged_by_its_law():
    pump = PUMP._replace(limit_start=1e7, limit_exponent=1.0, log_least=-1.0986)
    assert delivers(Circuit(1.5e-3, 0.0, 0.0, 2e7, 0.0), pump)
    assert not delivers(Circuit(1.5001e-3, 0.0, 0.0, 2e7, 0.0), pump)
    assert delivers(Circuit(3e-3, 0.0, 0.0, 9e6, 0.0), pump)
