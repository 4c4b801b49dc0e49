"""Long runs under operators that nobody planned: every whole-machine flow model keeps its bounds and loses no oil."""

import numpy as np
import pytest

from polydraulic import random_operator, simulate
from polydraulic.flow import FLOW_KINDS
from polydraulic.parameters.schema import LINKS

WHOLE = [name for name, kind in FLOW_KINDS.items() if set(kind.links) == set(LINKS)]


def check(machine, run, balances):
    assert all(np.all(np.isfinite(values)) for values in run.columns.values())
    for link in LINKS:
        part = getattr(machine, link)
        assert run[f"{link}.angle"].min() >= part.stops.low
        assert run[f"{link}.angle"].max() <= part.stops.high
        assert np.abs(run[f"{link}.spool"]).max() <= machine.spool.knots[-1]
        for name in ("p_a", "p_b"):
            assert run[f"{link}.{name}"].min() >= machine.tank.floor
            assert run[f"{link}.{name}"].max() <= part.line.relief
    for circuit, fed in (("boom", ["boom"]), ("series", ["swing", "stick"])):
        if balances:
            used = sum(run[f"{link}.q_in"] for link in fed)
            parts = [f"{circuit}.{name}" for name in ("q_bypass", "q_relief", "q_stored")]
            used += sum(run[name] for name in parts if name in run.names)
            assert np.abs(run[f"{circuit}.q_pump"] - used).max() <= 1e-9 * run[f"{circuit}.q_pump"].max()
        for name in (f"{circuit}.p_pump", f"{circuit}.p_between"):
            if name in run.names:
                assert run[name].min() >= machine.tank.floor - 1e-6  # Pa, rounding
                assert run[name].max() <= machine.pumps.relief * (1.0 + 1e-12)


@pytest.mark.parametrize("name", WHOLE)
def test_a_short_run(machine, build, name):
    run = simulate(machine, build(name, machine), random_operator(3, 2.0))
    check(machine, run, FLOW_KINDS[name].balances)
    assert all(np.ptp(run[f"{link}.angle"]) > 0.0 for link in LINKS)


@pytest.mark.slow
@pytest.mark.parametrize("limited", [False, True], ids=["constant", "limited"])
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", WHOLE)
def test_ten_minutes(machine, build, name, seed, limited):
    machine = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=limited))
    run = simulate(machine, build(name, machine), random_operator(seed, 600.0), every=2)
    check(machine, run, FLOW_KINDS[name].balances)
    stops = machine.boom.stops
    assert np.ptp(run["boom.angle"]) > 0.5 * (stops.high - stops.low)
