from types import SimpleNamespace

import pytest

from polydraulic.parameters.fault_catalogue import fault_catalogue
from polydraulic.parameters.load import load_machine
from polydraulic.thesis import diagnosis
from polydraulic.thesis.cache import open_lab
from polydraulic.thesis.diagnosis import Diagnosis, diagnoses, one_of_each_kind
from polydraulic.thesis.diagnosis_study import fault_kind


def test_of_each_kind_one_fault_functions_and_sensors_by_turns():
    faults = fault_catalogue("wheel_loader")
    chosen = one_of_each_kind(list(faults))
    assert [fault_kind(f.name) for f in chosen] == list(dict.fromkeys(fault_kind(f.name) for f in faults))
    assert {f.name.partition(".")[0] for f in chosen} >= {"lift", "tilt", "work", "tip"}


def test_both_machines_are_the_labs_own_and_made_once(machine):
    lab = open_lab(machine)
    excavator, loader = diagnoses(lab)
    assert excavator.machine is machine
    assert loader.machine.names == ("lift", "tilt")
    assert diagnoses(lab)[0] is excavator


@pytest.mark.slow
def test_a_small_study_is_told_kept_and_not_made_again(machine, tmp_path, monkeypatch):
    monkeypatch.setattr(diagnosis, "LEARNT", 200.0)
    monkeypatch.setattr(diagnosis, "HEALTHY_LOGS", 1)
    monkeypatch.setattr(diagnosis, "HEALTHY_LASTS", 60.0)
    every = one_of_each_kind
    monkeypatch.setattr(diagnosis, "one_of_each_kind", lambda faults: [f for f in every(faults) if "leak" in f.name])
    said = []
    first = Diagnosis(open_lab(machine, tmp_path, said.append), load_machine("wheel_loader"), "loader")
    parts = first.found, first.healthy, first.unusual, first.seconds, first.false_alarms
    assert [fault_kind(f.fault) for f in first.found] == ["leak_across", "leak_out"]
    assert first.seconds == first.healthy[0].seconds + sum(f.judged_before for f in first.found) > 0
    assert first.case.of.machine != first.machine  # identified, not the true one
    assert first.evidence.info["fault"] == first.found[0].fault
    assert [what.partition(" ")[0] for what in said] == ["identify", "watch", "watch", "watch", "watch", "watch"]

    monkeypatch.setattr(diagnosis, "work_log", None)
    again = Diagnosis(open_lab(machine, tmp_path), load_machine("wheel_loader"), "loader")
    assert parts == (again.found, again.healthy, again.unusual, again.seconds, again.false_alarms)
    assert again.evidence.info == first.evidence.info


def test_false_alarms_before_faults_count():
    study = Diagnosis(SimpleNamespace(), None, "any")
    study.found = [SimpleNamespace(judged_before=28, alarms_before=1)]
    study.healthy = [SimpleNamespace(seconds=100, named=["a.b", "a.c"])]
    assert (study.seconds, study.false_alarms) == (128, 3)
