"""Networks learnt from what sensors read, and the page that goes all the way."""

import re
from dataclasses import replace

import numpy as np
import pytest

from helpers.pages import ROOT, run_page
from polydraulic import simulate
from polydraulic.thesis import measured as measured_study
from polydraulic.thesis.cache import open_lab
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of, with_pumps
from polydraulic.thesis.measured import USUAL, _machine, conditions_in_words, measured, outcomes

PAGE = ROOT / "docs" / "machine_from_a_log.md"


def test_ports_follow_the_spool_and_shut_valves_pass_nothing(machine):
    log = measured(machine, USUAL._replace(minutes=0.2, noise=0.0))
    run = simulate(machine, "exact", _operator(0.2), raster=0.02)
    for link in LINKS:
        open_ = np.abs(run[f"{link}.spool"]) > spool_of(machine).deadband
        assert np.allclose(log[f"{link}.p_in"][open_], np.maximum(run[f"{link}.p_in"][open_], 0.0))
        assert np.all(log[f"{link}.q_in"][~open_] == 0.0)
        assert np.all(log[f"{link}.k_out"][~open_] == 0.0)
        assert log[f"{link}.q_in"][open_].max() > 0.0
    assert np.all(log["series.q_passed"] <= pump_of(machine, "series").flow)


def test_silent_sensors_and_joint_angles(machine):
    whole = measured(machine, USUAL._replace(minutes=0.5))
    assert len(measured(machine, USUAL._replace(minutes=0.5, dropout=0.05))) < 0.9 * len(whole)
    rebuilt = measured(machine, USUAL._replace(minutes=0.5, noise=0.0, flow_sensors=False))
    true = measured(machine, USUAL._replace(minutes=0.5, noise=0.0))
    flowing = true["boom.q_in"] > 0.3 * pump_of(machine, "boom").flow
    error = rebuilt["boom.q_in"] - true["boom.q_in"]  # what the oil's compression takes, and all of it at a stop
    assert np.median(np.abs(error[flowing])) < 0.5 * np.median(true["boom.q_in"][flowing])


def test_conditions_in_words():
    assert conditions_in_words(USUAL._replace(dropout=0.05, flow_sensors=False, limited=True)) == (
        "30 min, sensor noise 0.3 %, joystick travel 100 %, sensors silent 5 % of the time, no flow sensors, pumps with a torque limit"
    )
    assert conditions_in_words(USUAL._replace(outlet_sensors=False, friction=0.0)).endswith(
        "no outlet-flow sensors, no friction"
    )
    assert conditions_in_words(USUAL._replace(friction=5.0)).endswith("5 times the friction")


def test_friction_is_that_of_all_joints_and_changes_the_pressures(machine):
    stiff = _machine(machine, USUAL._replace(friction=5.0))
    for link in LINKS:
        now, then = stiff.function(link).friction, machine.function(link).friction
        assert (now.coulomb, now.static, now.viscous) == (5.0 * then.coulomb, 5.0 * then.static, 5.0 * then.viscous)
        assert (now.smoothing, now.stribeck) == (then.smoothing, then.stribeck)
    assert _machine(machine, USUAL) == with_pumps(machine, torque_limit_enabled=False)
    exact = USUAL._replace(minutes=0.5, noise=0.0)
    pressures = [np.median(measured(m, exact)["swing.p_in"]) for m in (machine, stiff)]
    assert pressures[1] > 1.2 * pressures[0]


def test_flows_out_of_actuators_follow_from_those_in(machine):
    exact = USUAL._replace(minutes=0.5, noise=0.0)
    true, rebuilt = measured(machine, exact), measured(machine, exact._replace(outlet_sensors=False))
    assert all(np.array_equal(true[f"{link}.q_in"], rebuilt[f"{link}.q_in"]) for link in LINKS)
    for link in ("boom", "stick"):
        flowing = true[f"{link}.q_in"] > 0.5 * pump_of(machine, "boom").flow
        read, found = (log[f"{link}.q_out"][flowing] for log in (true, rebuilt))
        assert 0.8 < np.corrcoef(read, found)[0, 1] < 1.0  # compression is what differs
        assert abs(np.median(found - read)) < 0.05 * np.median(read)
    assert np.array_equal(rebuilt["swing.q_out"], rebuilt["swing.q_in"])


@pytest.mark.slow
def test_ten_minutes_of_work_teach_the_machine(machine):
    (found,) = outcomes(open_lab(machine), [USUAL._replace(minutes=10.0, noise=0.001)])
    assert found.rows == 30001
    assert found.median < 0.4
    assert found.scenarios["sine"] < 0.1
    assert all(rms < 10.0 for rms in found.flow_rms.values())


def test_what_a_lab_has_is_not_made_again(machine, monkeypatch):
    monkeypatch.setattr(measured_study, "_made", None)
    lab, said = open_lab(machine), []
    for k, c in enumerate((USUAL, USUAL._replace(noise=0.5))):
        lab.computed.data(f"measured {measured_study._name(c)}", lambda k=k: [k, {}, 0.1, 0.2, {}])
    found = outcomes(replace(lab, say=said.append), [USUAL._replace(noise=0.5), USUAL])
    assert [one.rows for one in found] == [1, 0]
    assert said == []


@pytest.mark.slow
def test_several_conditions_at_once_are_those_one_by_one(machine):
    short, noisy = USUAL._replace(minutes=2.0), USUAL._replace(minutes=2.0, noise=0.01)
    together = outcomes(open_lab(machine), [short, noisy])
    alone = [outcomes(open_lab(machine), [c])[0] for c in (short, noisy)]
    for one, other in zip(together, alone, strict=True):
        assert one.rows == other.rows
        assert one.median == pytest.approx(other.median, rel=1e-3)


@pytest.mark.slow
def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    printed = run_page(PAGE, monkeypatch, capfd)
    tips = [float(value) for value in re.findall(r"tip\s+(\S+)\s", printed)]
    assert len(tips) == 5  # of the blocks held out, of two replays, of two runs
    assert max(tips) < 1000.0  # mm
    assert len(re.findall(r"^\S+ \[\S+\]: (?:holds|does not hold)", printed, re.MULTILINE)) == 6
    pictures = re.findall(r"\(images/(\S+)\)", PAGE.read_text())
    assert len(pictures) == 2
    for name in ("task.svg", "machine.html", "table.quality.html", *pictures):
        assert (tmp_path / name).is_file(), name
    assert list((tmp_path / "c").glob("*.c"))


def _operator(minutes):
    from polydraulic import random_operator
    from polydraulic.thesis.measured import STROKE, USUAL

    return random_operator(USUAL.operator, 60.0 * minutes, limit=STROKE)
