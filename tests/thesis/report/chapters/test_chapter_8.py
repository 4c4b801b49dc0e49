"""What the chapter says of both ways, where networks cannot be learnt, and what its figures hold."""

import json

import numpy as np
import pytest

from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.measured.conditions import COMMANDS, NO_PRESSURES, SWEEPS, USUAL
from polydraulic.thesis.measured.study import Outcome, WayErrors
from polydraulic.thesis.report.chapters import chapter_8
from polydraulic.thesis.report.figures import chapter_8 as figures
from polydraulic.thesis.three_links import SCENARIOS

EVERY = list(dict.fromkeys(c for sweep in SWEEPS.values() for c in sweep))


def reached(mm):
    return WayErrors(dict.fromkeys(LINKS, 1.5), 1e-3 * mm, 2e-3 * mm, dict.fromkeys(SCENARIOS, 3e-3 * mm), 0.25)


def outcome(place):
    blind = EVERY[place] in (NO_PRESSURES, COMMANDS)
    return Outcome(1000 + place, None if blind else reached(500 + place), reached(100 + place))


def changed(lab, name):
    kinds = ("fitted", "exact", "real")
    columns = {f"tip.{worst}{kind}": np.linspace(1.0, 0.1, 16) for kind in kinds for worst in ("", "worst_")}
    return Table({"minute": np.arange(16.0), **columns}, {})


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    found = {c: outcome(k) for k, c in enumerate(EVERY)}
    for module in (chapter_8, figures):
        monkeypatch.setattr(module, "all_outcomes", lambda lab: found)
        monkeypatch.setattr(module, "change", changed)


def test_both_ways_stand_side_by_side_and_what_cannot_be_learnt_is_a_dash():
    both, networks, identified = chapter_8.content(None).tables
    assert len(both.rows) == len(EVERY)
    assert both.rows[0][1:] == ["1000", "500", "1000", "25.0", "100", "200", "25.0"]
    commands = both.rows[EVERY.index(COMMANDS)]
    assert commands[0] == "no flow or pressure or spool sensors"
    assert commands[2:5] == ["\u2013"] * 3
    assert commands[5] == str(100 + EVERY.index(COMMANDS))
    assert len(networks.rows) == len(EVERY) - 2
    assert len(identified.rows) == len(EVERY)
    assert all(len(grid.header) == len(row) for grid in (both, networks, identified) for row in grid.rows)


def test_numbers_and_words_are_those_of_the_outcomes():
    content = chapter_8.content(None)
    rows = {row["id"]: row["computed"] for row in content.extra}
    json.dumps(content.extra, allow_nan=False)
    assert rows["polydraulic.measured.median_m"] == pytest.approx(0.5)
    assert rows["polydraulic.identified.median_m"] == pytest.approx(0.1)
    assert rows["polydraulic.identified.commands_m"] == pytest.approx(1e-3 * (100 + EVERY.index(COMMANDS)))
    said = " ".join(paragraph.text for paragraph in content.text)
    assert "the median is 500 mm with networks and 100 mm with the identified machine" in said
    assert "25 % of its steps are flagged as beyond the log" in said


def test_figures_hold_every_condition_of_their_panels():
    data = figures.what_data_buy(None)
    assert len(data.draw().axes) == 6
    assert data.data["noise"]["identified, median"].tolist() == [
        100.0 + EVERY.index(USUAL._replace(noise=noise)) for noise in (0.0, 0.001, 0.003, 0.01, 0.03)
    ]
    sensors = figures.what_sensors_buy(None)
    table = sensors.data[""]
    assert np.isnan(table["networks, median"]).tolist() == [False, False, False, True, True, False, False]
    assert np.all(table["identified, worst"] == 2.0 * table["identified, median"])
    (axis,) = sensors.draw().axes
    assert len(axis.get_xticklabels()) == len(table)
    assert len(figures.adaptation(None).draw().axes) == 2
