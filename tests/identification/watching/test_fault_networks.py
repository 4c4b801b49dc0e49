"""Networks that name faults: learnt from simulated ones, kept as data, refused where they do not fit."""

import json
from dataclasses import replace

import numpy as np
import pytest

from helpers.watched_logs import blocks, healthy_log, known, log_of
from polydraulic import InputError, load_machine
from polydraulic.identification import watch_log
from polydraulic.identification.watching import fault_networks
from polydraulic.identification.watching.fault_networks import (
    learn_fault_networks,
    load_fault_networks,
    networks_for,
    save_fault_networks,
)
from polydraulic.watch.watch import FaultWatch

FEW = ("work.pump_worn", "lift.spool_weak", "lift.friction_high", "tilt.voltage.bias")


@pytest.fixture(scope="module")
def few():
    """Of four faults."""
    of, expected = known()
    with pytest.MonkeyPatch.context() as patch:
        chosen = [(fault, kind) for fault, kind in fault_networks._faults(of.machine, of) if fault.name in FEW]
        patch.setattr(fault_networks, "_faults", lambda plant, of: chosen)
        patch.setattr(fault_networks, "_LASTS", 25.0)
        # the machine as it is has been compiled already
        patch.setattr(fault_networks, "_sticky", lambda machine: machine)
        return learn_fault_networks(of, expected, operators=4)


def test_they_name_the_kind_of_a_fault_of_another_operator(few):
    of, expected = known()
    for fault in ("lift.spool_weak", "work.pump_worn"):
        watch = FaultWatch(of, expected, networks=few)
        watch.judge(*blocks(of, log_of(of.machine, 22, 60.0, [f"{fault} from 20 s"])))
        (alarm,) = watch.alarms
        assert alarm.suspects[0].name == fault
        assert alarm.opinion.kind == fault.rpartition(".")[2]
        assert 0.5 < alarm.opinion.certainty <= 1.0
    assert few.kinds == ("bias", "friction_high", "pump_worn", "spool_weak")


def test_spools_of_any_machine_may_stick_and_sizes_lie_between_the_usual_ones():
    of, _ = known()
    faults = fault_networks._faults(fault_networks._sticky(of.machine), of)
    assert {d.name for d in of.directions} - {fault.name for fault, _ in faults} == {"oil.cold"}
    rng = np.random.default_rng(1)
    bias = next(fault for fault, _ in faults if fault.name == "lift.p_a.bias")
    sizes = [fault_networks._scheduled(bias, rng).size for _ in range(50)]
    assert 0.02 <= min(map(abs, sizes)) < 0.03 < max(map(abs, sizes)) <= 0.05
    assert min(sizes) < 0.0 < max(sizes)


def test_a_file_holds_them_as_data(few, tmp_path):
    path = tmp_path / "names.json"
    save_fault_networks(few, path)
    again = load_fault_networks(path)
    assert (again.directions, again.kinds) == (few.directions, few.kinds)
    assert np.array_equal(again.link, few.link)
    row = np.random.default_rng(1).uniform(0.0, 1.0, (5, len(few.models[0].inputs)))
    for one, other in zip(again.models, few.models, strict=True):
        assert np.array_equal(one.predict(row), other.predict(row))
    of, expected = known()
    assert networks_for(path, of, expected).directions == few.directions
    with pytest.raises(InputError, match=r"ends in \.json"):
        save_fault_networks(few, tmp_path / "names.pkl")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.update(format="other"), "holds no networks that name faults"),
        (lambda d: d.update(schema=9), "has schema 9, this version reads 1"),
        (lambda d: d.update(link=[[1.0]]), "link must be 4 rows of 5 finite numbers"),
        (lambda d: d.update(link="x"), "link must be"),
        (lambda d: d.update(directions=[1]), "directions must be a list of names"),
        (lambda d: d.update(networks={}), "not a polydraulic model file"),
    ],
)
def test_a_damaged_file_is_refused(few, tmp_path, change, words):
    path = tmp_path / "names.json"
    save_fault_networks(few, path)
    data = json.loads(path.read_text(encoding="utf-8"))
    change(data)
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        load_fault_networks(path)
    path.write_text("{", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be read as networks"):
        load_fault_networks(path)


def test_those_of_other_sensors_are_refused(few):
    of, expected = known()
    other = replace(few, directions=few.directions[1:])
    with pytest.raises(InputError, match=f"other sensors, .*{few.directions[0]} are not of both"):
        networks_for(other, of, expected)


def test_fewer_than_three_kinds_are_refused(monkeypatch):
    of, expected = known()
    one = [pair for pair in fault_networks._faults(of.machine, of) if pair[0].name == FEW[0]]
    monkeypatch.setattr(fault_networks, "_faults", lambda plant, of: one)
    monkeypatch.setattr(fault_networks, "_LASTS", 20.0)
    monkeypatch.setattr(fault_networks, "_sticky", lambda machine: machine)
    with pytest.raises(InputError, match="gave alarms of 1 kinds"):
        learn_fault_networks(of, expected, operators=1)


def test_a_watched_log_says_what_they_say(few):
    machine = load_machine("wheel_loader")
    log = log_of(machine, 31, 40.0, ["work.pump_worn from 10 s"])
    said = str(watch_log(log, machine, healthy=healthy_log(), networks=few))
    assert "networks" in said
    assert "pump worn (" in said


def test_a_file_that_is_not_there_is_learnt_once(few, tmp_path, monkeypatch):
    of, expected = known()
    monkeypatch.setattr(fault_networks, "learn_fault_networks", lambda *args, **more: few)
    path = tmp_path / "names.json"
    networks_for(path, of, expected)
    monkeypatch.setattr(fault_networks, "learn_fault_networks", None)
    assert networks_for(path, of, expected).kinds == few.kinds
