"""Residuals of a healthy run are what sampling leaves; those of another machine are not, where they should."""

import numpy as np
import pytest

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.block import residuals_of
from polydraulic.watch.residuals import Residuals, case_of
from polydraulic.watch.watched import plan_of


@pytest.fixture(scope="module")
def seen():
    of, expected = known()
    readings, _ = blocks(of, log_of(of.machine, 12, 30.0))
    return of, expected, readings


def rms(residual, variance):
    return float(np.sqrt(np.mean(residual[np.isfinite(variance)] ** 2)))


def test_what_is_left_of_a_healthy_machine_is_little(seen):
    of, expected, readings = seen
    own, variances = residuals_of(plan_of(of, expected.noise), readings)
    left = {c.name: rms(r, v) for c, r, v in zip(of.channels, own, variances, strict=True)}
    pump = of.machine.circuits[0].pump.flow
    assert left["lift.spool"] < 0.02 * of.machine.function("lift").valve.knots[-1]
    assert left["lift.q_in"] < 0.02 * pump
    assert left["lift.volume_a"] < 0.05 * pump
    assert left["lift.p_out"] < 10e5


def test_a_fault_moves_what_depends_on_it_and_shares_the_rest(seen):
    of, _, _ = seen
    residuals = Residuals(of.columns, of.shape, of.channels)
    healthy = residuals.of(case_of(of.machine))

    def moved(case):
        return [c.name for c, a, b in zip(of.channels, healthy, residuals.of(case), strict=True) if a != b]

    assert moved(case_of(of.machine)) == []
    assert moved(case_of(of.machine.with_values({"functions.lift.pilot.time_constant": 0.3}))) == ["lift.spool"]
    read = case_of(of.machine, shifts={"lift.q_out": 1e-4})
    assert moved(read) == ["lift.p_out", "lift.volume_a", "lift.volume_b"]
    assert moved(case_of(of.machine, payload=500.0)) == ["lift.torque", "tilt.torque"]


def test_a_spool_that_sticks_follows_late(seen):
    of, expected, readings = seen
    lift = of.machine.function("lift")
    late = 0.1 * lift.valve.knots[-1]
    sticks = lift._replace(effects=lift.effects._replace(hysteresis=late))
    machine = of.machine._replace(functions=tuple(sticks if f.name == "lift" else f for f in of.machine.functions))
    place = [c.name for c in of.channels].index("lift.spool")
    own, sticky = (
        residuals_of(plan_of(of._replace(machine=m), expected.noise), readings)[0][place] for m in (of.machine, machine)
    )
    assert 0.3 * late < np.abs(own - sticky).max() <= 0.5 * late * (1.0 + 1e-9)
