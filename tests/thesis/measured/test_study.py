"""Both ways from a log to a machine, what they reach, and the page that goes all the way with networks."""

import re
from dataclasses import replace

import pytest

from helpers.pages import ROOT, run_page
from polydraulic.thesis.cache import open_lab
from polydraulic.thesis.measured import study
from polydraulic.thesis.measured.conditions import COMMANDS, USUAL
from polydraulic.thesis.measured.study import outcomes, reached_by

PAGE = ROOT / "docs" / "machine_from_a_log.md"


def test_what_is_the_machine_itself_has_no_errors_and_what_is_not_has(machine, monkeypatch):
    monkeypatch.setattr(study, "JUDGES", (4000,))
    monkeypatch.setattr(study, "JUDGE_SECONDS", 2.0)
    monkeypatch.setattr(study, "SCENARIOS", ("pulse",))
    weak = machine.with_values({f"{c.pump_path}.flow": 0.9 * c.pump.flow for c in machine.circuits})
    own, other = reached_by(machine, [(machine, "exact"), (weak, "exact")])
    assert own.median == own.worst == own.scenarios["pulse"] == 0.0
    # rows have the flows of the step before
    assert max(own.flow_rms.values()) < 0.3
    assert own.outside == 0.0
    assert other.median == other.worst > 0.01
    assert other.scenarios["pulse"] > 0.01
    assert max(other.flow_rms.values()) > 1.0


@pytest.mark.slow
def test_ten_minutes_of_work_teach_the_machine(machine):
    (found,) = outcomes(open_lab(machine), [USUAL._replace(minutes=10.0, noise=0.001)])
    assert found.rows == 30001
    assert found.networks.median < 0.4
    assert found.networks.scenarios["sine"] < 0.1
    assert all(rms < 10.0 for rms in found.networks.flow_rms.values())
    assert found.identified.median < 0.05
    assert found.identified.scenarios["sine"] < 0.02


def test_what_a_lab_has_is_not_made_again(machine, monkeypatch):
    monkeypatch.setattr(study, "_made", None)
    lab, said = open_lab(machine), []
    for k, c in enumerate((USUAL, USUAL._replace(noise=0.5))):
        lab.computed.data(f"measured {study._name(c)}", lambda k=k: [k, None, [{}, 0.1, 0.2, {}, 0.0]])
    found = outcomes(replace(lab, say=said.append), [USUAL._replace(noise=0.5), USUAL])
    assert [one.rows for one in found] == [1, 0]
    assert said == []
    assert all(one.networks is None for one in found)
    assert found[0].identified.worst == 0.2


@pytest.mark.slow
def test_several_conditions_at_once_are_those_one_by_one(machine):
    short, noisy = USUAL._replace(minutes=2.0), USUAL._replace(minutes=2.0, noise=0.01)
    together = outcomes(open_lab(machine), [short, noisy])
    alone = [outcomes(open_lab(machine), [c])[0] for c in (short, noisy)]
    for one, other in zip(together, alone, strict=True):
        assert one.rows == other.rows
        assert one.networks.median == pytest.approx(other.networks.median, rel=1e-3)
        assert one.identified.median == pytest.approx(other.identified.median, rel=1e-3)


@pytest.mark.slow
def test_commands_and_angles_alone_tell_pumps_and_pilots(machine):
    (found,) = outcomes(open_lab(machine), [COMMANDS._replace(minutes=5.0)])
    assert found.networks is None
    assert found.identified.median < 3.0


@pytest.mark.slow
def test_the_page_runs_from_top_to_bottom(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    printed = run_page(PAGE, monkeypatch, capfd)
    tips = [float(value) for value in re.findall(r"^  tip\s+([\d.]+)\s", printed, re.MULTILINE)]
    assert len(tips) == 5  # of the blocks held out, of two replays, of two runs
    assert max(tips) < 1000.0  # mm
    assert len(re.findall(r"^\S+ \[\S+\]: (?:holds|does not hold)", printed, re.MULTILINE)) == 6
    pictures = re.findall(r"\(images/(\S+)\)", PAGE.read_text())
    assert len(pictures) == 2
    for name in ("task.svg", "machine.html", "table.quality.html", *pictures):
        assert (tmp_path / name).is_file(), name
    assert list((tmp_path / "c").glob("*.c"))
