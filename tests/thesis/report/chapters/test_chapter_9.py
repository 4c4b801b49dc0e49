"""What the chapter says of studies with every outcome, and of one that found nothing."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic.tables import Table
from polydraulic.thesis.diagnosis_study import Healthy, WatchedFault
from polydraulic.thesis.report.chapters import chapter_9

FOUND = [
    WatchedFault("a.leak_across", "a leaks", "a.leak_across", 100, 9, 12.2, 28, 0),
    WatchedFault("a.leak_out", "lines of a leak", "b.leak_out", 50, 10, 20.0, 28, 1),
    WatchedFault("a.spool_slow", "spool of a slow", "a.spool_weak", 90, 70, 90.0, 27, 0),
    WatchedFault("b.spool_weak", "spool of b weak", "", 100, 0, 0.0, 28, 0),
    WatchedFault("b.line_relief_low", "valves of b low", "", 3, 0, 0.0, 28, 0),
    WatchedFault("b.friction_high", "friction of b high", "", 20, 0, 0.0, 28, 0, True),
    WatchedFault("a.p_a.bias", "sensor reads too much", "oil.cold", 80, 8, 9.0, 28, 0),
]


def study(name, found, named=()):
    time = np.arange(1.0, 151.0)
    columns = {
        "faulty.own": time / 75.0,
        "faulty.most": time / 70.0,
        "healthy.own": 0.0 * time,
        "healthy.most": 0.1 + 0.0 * time,
    }
    return SimpleNamespace(
        name=name,
        found=found,
        healthy=[Healthy(1800, list(named))],
        unusual=[("oil cold", "no alarm")],
        evidence=Table({"time": time, **columns}, {"time": "s"}, {"fault": "a.leak_across"}),
        seconds=1800 + sum(f.judged_before for f in found),
        false_alarms=len(named) + sum(f.alarms_before for f in found),
    )  # fmt: skip


@pytest.fixture
def every_outcome(monkeypatch):
    monkeypatch.setattr(chapter_9, "diagnoses", lambda lab: [study("one", FOUND[:3]), study("two", FOUND[3:], ["b.x"])])


def words(content):
    return " ".join(paragraph.text for paragraph in content.text)


def test_numbers_count_what_could_show(every_outcome):
    rows = {row["id"].rpartition(".")[2]: row for row in chapter_9.content(None).extra}
    assert rows["in_time_percent"]["computed"] == pytest.approx(
        60.0
    )  # 3 of 5: one late, one missed, one without occasion
    assert rows["kind_percent"]["computed"] == pytest.approx(50.0)
    assert rows["delay_s"]["computed"] == pytest.approx(9.5)
    assert rows["clock_s"]["computed"] == pytest.approx(16.1)
    assert rows["false_alarms"]["computed"] == 2.0
    assert rows["healthy_h"]["computed"] == pytest.approx((3600 + 195) / 3600)


def test_text_and_tables_name_what_went_wrong(every_outcome):
    content = chapter_9.content(None)
    said = words(content)
    assert "Of 7 faults 3 were found within 60 s" in said
    assert "found later: 1 (a.spool_slow);" in said
    assert "had as long: 1 (b.spool_weak)." in said
    assert "The work gave no occasion to: 1 (b.line_relief_low)." in said
    assert "if the identified machine had no errors to: 1 (b.friction_high)." in said
    assert "Of those that were found 1 had less than 60 s, too." in said
    assert "1 of 4 name the fault itself, 2 its kind" in said
    assert "there were 2." in said
    delays, kinds, false, unusual = content.tables
    assert [row[3:] for row in delays.rows][2:5] == [
        ["70", "90", "a.spool_weak"],
        ["–", "–", "missed"],
        ["–", "–", "no occasion to show"],
    ]
    assert ["spool slow", "1", "spool weak (1)"] in kinds.rows
    assert [row[:4] for row in false.rows] == [
        ["one", "31", "1", "1 before faults"],
        ["two", "32", "1", "b.x"],
        ["all", "63", "2", "b.x, 1 before faults"],
    ]
    assert unusual.rows == [["one", "oil cold", "no alarm"], ["two", "oil cold", "no alarm"]]


def test_the_confusion_matrix_holds_every_log_and_names_of_other_kinds(every_outcome):
    figure = chapter_9.confusion(None)
    table = figure.data[""]
    counts = table.matrix(table.names[1:])
    assert counts.sum() == len(FOUND)
    assert counts.sum(axis=1).tolist() == [1.0] * 7
    assert (
        table["cold"][6]
        == table["hidden by errors of the identified machine"][5]
        == table["missed"][3]
        == table["no occasion to show"][4]
        == 1.0
    )
    assert table["spool weak"].tolist() == [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]
    (axis,) = figure.draw().axes
    assert len(axis.texts) == 7


def test_evidence_is_drawn_next_to_that_of_healthy_work(every_outcome):
    figure = chapter_9.evidence(None)
    assert list(figure.data) == ["one", "two"]
    for axis in figure.draw().axes:
        assert axis.lines[0].get_ydata().max() == pytest.approx(2.0)
        assert axis.lines[1].get_ydata().max() == 0.0


def test_a_study_without_any_alarm_says_so_in_numbers_that_exist(monkeypatch):
    monkeypatch.setattr(chapter_9, "diagnoses", lambda lab: [study("one", FOUND[4:5])])
    content = chapter_9.content(None)
    json.dumps(content.extra, allow_nan=False)
    assert {row["id"].rpartition(".")[2] for row in content.extra} == {"false_alarms", "healthy_h", "most_per_hour"}
    assert "Of 1 faults 0 were found" in words(content)
    assert "there was none" in words(content)
    assert chapter_9.confusion(None).draw().axes
