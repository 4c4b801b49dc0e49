"""Residuals of a healthy run are what sampling leaves; those of another machine are not, where they should."""

import numpy as np
import pytest

from helpers.watched_logs import blocks, known, log_of
from polydraulic import load_machine
from polydraulic.watch.residuals import Residuals, case_of


@pytest.fixture(scope="module")
def seen():
    of, _ = known()
    log = log_of(of.machine, 12, 30.0)
    return of, Residuals(blocks(of, log)[0], of.shape, of.channels)


def rms(residual, counts):
    fine = np.isfinite(residual) & counts
    return float(np.sqrt(np.mean(residual[fine] ** 2)))


def test_what_is_left_of_a_healthy_machine_is_little(seen):
    of, residuals = seen
    case = case_of(of.machine)
    left = {c.name: rms(r, n) for c, r, n in zip(of.channels, residuals.of(case), residuals.counts(case), strict=True)}
    pump = of.machine.circuits[0].pump.flow
    assert left["lift.spool"] < 0.02 * of.machine.function("lift").valve.knots[-1]
    assert left["lift.q_in"] < 0.02 * pump
    assert left["lift.volume_a"] < 0.05 * pump
    assert left["lift.p_out"] < 10e5


def test_a_fault_moves_what_depends_on_it_and_shares_the_rest(seen):
    of, residuals = seen
    healthy = residuals.of(case_of(of.machine))
    slow = residuals.of(case_of(of.machine.with_values({"functions.lift.pilot.time_constant": 0.3})))
    moved = [c.name for c, a, b in zip(of.channels, healthy, slow, strict=True) if a is not b]
    assert moved == ["lift.spool"]
    read = residuals.of(case_of(of.machine, shifts={"lift.q_out": 1e-4}))
    moved = [c.name for c, a, b in zip(of.channels, healthy, read, strict=True) if a is not b]
    assert moved == ["lift.p_out", "lift.volume_a", "lift.volume_b"]
    loaded = residuals.of(case_of(of.machine, payload=500.0))
    moved = [c.name for c, a, b in zip(of.channels, healthy, loaded, strict=True) if a is not b]
    assert moved == ["lift.torque", "tilt.torque"]


def test_a_spool_that_sticks_follows_late():
    of, _ = known()
    machine = load_machine("wheel_loader")
    log = log_of(machine, 12, 12.0)
    residuals = Residuals(blocks(of, log)[0], of.shape, of.channels)
    lift = machine.function("lift")
    late = 0.1 * lift.valve.knots[-1]
    sticky = machine._replace(
        functions=tuple(
            f._replace(effects=f.effects._replace(hysteresis=late)) if f.name == "lift" else f
            for f in machine.functions
        )
    )
    place = [c.name for c in of.channels].index("lift.spool")
    apart = residuals.of(case_of(machine))[place] - residuals.of(case_of(sticky))[place]
    assert 0.3 * late < np.abs(apart).max() <= 0.5 * late * (1.0 + 1e-9)
