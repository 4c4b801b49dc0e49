"""One case for all: the true wheel loader watched by itself, so that nothing has to be identified."""

import numpy as np
import pytest
from scipy.stats import poisson

from polydraulic.parameters.load import load_machine
from polydraulic.thesis.diagnosis_study import (
    BEGINS,
    DRIFTS,
    LASTS,
    RASTER,
    WITHIN,
    WatchedFault,
    case_of_log,
    drifts_watched,
    evidence_over_time,
    fault_kind,
    faults_watched,
    most_per_hour,
    schedule,
    watch_fault,
    watch_healthy,
    watch_unusual,
    work_log,
)

SEED = 12000


@pytest.fixture(scope="module")
def case():
    machine = load_machine("wheel_loader")
    return case_of_log(machine, machine, work_log(machine, SEED, 300.0))


@pytest.fixture(scope="module")
def kinds(case):
    return {kind.name: kind for kind in faults_watched(case)}


def test_a_log_is_noisy_whole_and_repeatable(case):
    log, again = (work_log(case.true, SEED, 20.0) for _ in range(2))
    other = work_log(case.true, SEED + 1, 20.0)
    assert all(np.array_equal(log[name], again[name]) for name in log.names)
    assert not np.array_equal(log["lift.p_a"][:100], other["lift.p_a"][:100])
    assert all(np.isfinite(log[name]).all() for name in log.names)
    assert np.min(np.diff(log["time"])) == pytest.approx(RASTER)
    assert np.all((np.diff(log["segment"]) > 0) == (np.diff(log["time"]) > 1.5 * RASTER))
    assert log.unit("lift.angle") == "rad"
    assert np.std(np.diff(log["lift.p_a"])) > 0.0


def test_what_is_watched_and_how_a_fault_is_scheduled(case, kinds):
    assert {"tilt.leak_across", "work.torque_limit_off", "lift.p_a.bias", "lift.p_a.freeze"} <= set(kinds)
    assert "lift.p_a.drift" not in kinds
    assert schedule(kinds["lift.spool_weak"]) == ("lift.spool_weak 10 % from 30 s", "spool of lift moves 10 % less")
    assert schedule(kinds["lift.p_a.freeze"])[0] == "lift.p_a.freeze from 30 s"
    few = case_of_log(case.true, case.of.machine, work_log(case.true, SEED, 120.0), ["*.p_?", "*.angle", "*.voltage"])
    assert not any(".q_" in kind.name for kind in faults_watched(few))
    assert fault_kind("lift.p_a.freeze") == "freeze"


@pytest.mark.parametrize("name", ["lift.spool_weak", "tilt.voltage.freeze"])
def test_a_fault_is_found_and_named(case, kinds, name):
    found = watch_fault(case, kinds[name], SEED + 2)
    assert (found.fault, found.named, found.outcome) == (name, name, "in time")
    assert 0 < found.delay <= found.could_show <= LASTS
    assert found.delay <= found.clock <= LASTS
    assert found.alarms_before == 0
    assert 0 < found.judged_before < BEGINS


def test_what_becomes_of_faults_that_give_no_alarm():
    none = WatchedFault("a.b", "", "", 0, 0, 0.0, 0, 0)
    assert none.outcome == none._replace(could_show=WITHIN - 1).outcome == "no occasion"
    assert none._replace(could_show=WITHIN).outcome == none._replace(could_show=WITHIN, hidden=True).outcome == "missed"
    assert none._replace(could_show=WITHIN - 1, hidden=True).outcome == "hidden"
    assert none._replace(named="a.c", delay=WITHIN).outcome == "in time"
    assert none._replace(named="a.c", delay=WITHIN + 1).outcome == "late"


def test_a_drift_can_show_once_it_has_grown_and_is_named_so(case):
    drifts = {kind.name: kind for kind in drifts_watched(case)}
    assert set(drifts) == {f"{column}.drift" for column in case.of.columns}
    found = watch_fault(case, drifts["tilt.voltage.drift"], SEED + 4)
    assert (found.named, found.outcome) == ("tilt.voltage.drift", "in time")
    assert found.delay < WITHIN < found.clock
    assert found.clock <= DRIFTS


def test_an_occasion_that_errors_of_the_machine_take_away_is_told_from_none(case, kinds):
    """Residuals of healthy work are taken to be anything: nothing shows by them any more."""
    anything = tuple((1e30, 1.0) for _ in case.expected.scales)
    unsure = case._replace(expected=case.expected._replace(scales=anything))
    assert watch_fault(unsure, kinds["lift.spool_weak"], SEED + 2).outcome == "hidden"
    strays = np.ones(len(case.of.directions))  # by as much as what is to be found
    straying = case._replace(expected=case.expected._replace(slow=strays))
    assert watch_fault(straying, kinds["lift.spool_weak"], SEED + 2).outcome == "hidden"


def test_healthy_work_gives_no_alarm_and_a_payload_its_name(case):
    healthy = watch_healthy(case, case.true, SEED + 3, 60.0)
    assert healthy.named == []
    assert 20 < healthy.seconds <= 60
    named = dict(watch_unusual(case, SEED + 4))
    assert named["payload of 960 kg"] == "tip.payload_unknown"
    assert len(named) == 3


def test_evidence_rises_with_the_fault_and_stays_low_without(case, kinds):
    table = evidence_over_time(case, kinds["tilt.leak_across"], SEED + 5)
    assert table["faulty.own"].max() >= 1.0 > table["healthy.own"].max()
    assert np.all(table["healthy.most"] >= table["healthy.own"])
    before = table["time"] < BEGINS - 1.0
    assert before.any()
    assert np.allclose(table["faulty.own"][before], table["healthy.own"][before], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("alarms", [0, 1, 5])
def test_the_bound_leaves_the_alarms_seen_a_chance_of_five_percent(alarms):
    hours = 1.3
    assert poisson.cdf(alarms, most_per_hour(alarms, 3600.0 * hours) * hours) == pytest.approx(0.05)
