"""The page of a watched log, and its picture."""

from dataclasses import replace

import numpy as np
import pytest

from helpers.watched_logs import healthy_log, log_of
from polydraulic import InputError, load_machine
from polydraulic.identification import plot_watch, watch_log, write_watch_page
from polydraulic.watch import Alarm, Suspect
from polydraulic.watch.watch import Outlook


@pytest.fixture(scope="module")
def found():
    machine = load_machine("wheel_loader")
    return watch_log(log_of(machine, 31, 40.0, ["work.pump_worn from 10 s"]), machine, healthy=healthy_log())


def test_the_page_says_what_was_found_and_what_cannot_be_told(found, tmp_path):
    write_watch_page(found, tmp_path / "watch.html")
    page = (tmp_path / "watch.html").read_text(encoding="utf-8")
    assert "pump of work worn" in page
    assert "named in an alarm" in page
    assert "cannot tell: " in page
    assert "of the evidence" not in page
    assert "Not judged" not in page
    write_watch_page(replace(found, not_judged="half of it: no reason"), tmp_path / "watch.html")
    assert "<p>Not judged: half of it: no reason.</p>" in (tmp_path / "watch.html").read_text(encoding="utf-8")
    assert "data:image/svg+xml" in page
    with pytest.raises(InputError, match=r"ends in \.html"):
        write_watch_page(found, tmp_path / "watch.txt")


@pytest.mark.parametrize(
    ("name", "share", "words"),
    [
        ("lift.relief_low", 0.001, "the work in this log gave it no occasion to show"),
        ("lift.relief_low", 0.9, "in this log it would have given only 90% of what an alarm takes"),
        ("lift.relief_low", 0.999, "in this log it would have given only 99% of what an alarm takes"),
        ("lift.p_a.freeze", 0.5, "its function moved for only 50% of the time that it takes to be sure"),
    ],
)
def test_why_nothing_is_said_of_a_fault(found, tmp_path, name, share, words):
    write_watch_page(replace(found, findings=[Outlook(name, "title", False, share)]), tmp_path / "watch.html")
    assert f"cannot tell: {words}</td>" in (tmp_path / "watch.html").read_text(encoding="utf-8")


def test_the_picture_names_the_fault_beyond_the_threshold(found):
    axis = plot_watch(found).axes[0]
    assert "work.pump_worn" in [text.get_text() for text in axis.get_legend().get_texts()]
    assert len(axis.patches) == len(found.alarms)


def test_times_are_dates_where_the_log_has_dates(found):
    dated = replace(found, began=1.7e9)
    assert "2023-11-14 22:13:" in str(dated)
    assert " s  " not in str(dated).splitlines()[2]
    assert plot_watch(dated).axes[0].get_xlabel() == "time of day, 2023-11-14"
    assert plot_watch(found).axes[0].get_xlabel() == "time [s]"


def test_what_is_beyond_the_line_but_not_named_is_no_sign_of_nothing(found, tmp_path):
    evidence = found.evidence.copy()
    evidence[5, [d.name for d in found.of.directions].index("lift.leak_out")] = 1.5
    write_watch_page(replace(found, evidence=evidence), tmp_path / "watch.html")
    page = (tmp_path / "watch.html").read_text(encoding="utf-8")
    row = page[page.index("lines of lift leak to the tank") :].partition("</tr>")[0]
    assert "what an alarm named explains the same evidence better" in row


def test_every_sensor_that_stays_is_named_and_a_drift_stands_by_the_bias_that_it_becomes(found, tmp_path):
    stays = [Suspect(f"lift.{c}.freeze", "", 1.0, np.nan, np.nan, False) for c in ("p_a", "p_b")]
    drifts = Suspect("tilt.spool.drift", "drifts", 1.0, 0.01, 0.001, False)
    alarms = [Alarm(1.0, 2.0, 3.0, tuple(stays)), Alarm(4.0, 5.0, 6.0, (drifts,))]
    write_watch_page(replace(found, alarms=alarms), tmp_path / "watch.html")
    page = (tmp_path / "watch.html").read_text(encoding="utf-8")

    def told(title):
        return page[page.index(f">{title}") :].partition("</tr>")[0]

    assert "named in an alarm" in told("sensor of lift.p_a stays")
    assert "named in an alarm" in told("sensor of lift.p_b stays")
    assert "named in an alarm" not in told("sensor of tilt.p_b stays")
    assert "named in an alarm, as a drift" in told("sensor of tilt.spool reads")
