"""Long runs under operators that nobody planned: every whole-machine flow model keeps its bounds and loses no oil."""

import numpy as np
import pytest

from polydraulic import random_operator, simulate
from polydraulic.flow import FLOW_KINDS
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of, with_pumps

WHOLE = [name for name in FLOW_KINDS if name not in ("pressure", "residual")]  # which need networks of their own


def check(machine, run):
    assert all(np.all(np.isfinite(values)) for values in run.columns.values())
    for link in LINKS:
        part = machine.function(link)
        assert run[f"{link}.angle"].min() >= part.stops.low
        assert run[f"{link}.angle"].max() <= part.stops.high
        assert np.abs(run[f"{link}.spool"]).max() <= spool_of(machine).end
        for name in ("p_a", "p_b"):
            assert run[f"{link}.{name}"].min() >= machine.tank.floor
            assert run[f"{link}.{name}"].max() <= part.line.relief
    for circuit, fed in (("boom", ["boom"]), ("series", ["swing", "stick"])):
        used = sum(run[f"{link}.q_in"] for link in fed)
        parts = [f"{circuit}.{name}" for name in ("q_bypass", "q_relief", "q_stored")]
        used += sum(run[name] for name in parts if name in run.names)
        assert np.abs(run[f"{circuit}.q_pump"] - used).max() <= 1e-9 * run[f"{circuit}.q_pump"].max()
        for name in (f"{circuit}.p_pump", f"{circuit}.p_between"):
            if name in run.names:
                assert run[name].min() >= machine.tank.floor - 1e-6  # Pa, rounding
                assert run[name].max() <= pump_of(machine, "boom").relief * (1.0 + 1e-12)


@pytest.mark.parametrize("name", WHOLE)
def test_a_short_run(machine, build, name):
    run = simulate(machine, build(name, machine), random_operator(3, 2.0))
    check(machine, run)
    assert all(np.ptp(run[f"{link}.angle"]) > 0.0 for link in LINKS)


@pytest.mark.slow
@pytest.mark.parametrize("limited", [False, True], ids=["constant", "limited"])
@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", WHOLE)
def test_ten_minutes(machine, build, name, seed, limited):
    machine = with_pumps(machine, torque_limit_enabled=limited)
    run = simulate(machine, build(name, machine), random_operator(seed, 600.0), every=2)
    check(machine, run)
    stops = machine.function("boom").stops
    assert np.ptp(run["boom.angle"]) > 0.5 * (stops.high - stops.low)
