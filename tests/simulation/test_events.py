"""Events: conditions between rows, the bound of the list, and times that the methods agree on."""

import numpy as np
import pytest

from polydraulic import load_scenario, simulate
from polydraulic.flow.record import N_RECORD
from polydraulic.machine.plant import prepare
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.simulation import events as module
from polydraulic.simulation.events import CONDITIONS, N_CONDITION, edges_of, listed, new_log, scan
from polydraulic.tables import read_table, write_table

UP = Scenario("up", 4.0, {"boom": Constant(0.62)}, ("swing", "stick"))


def rows_of(machine, n):
    rows = np.zeros((n, N_RECORD))
    rows[:, 3:9] = 1e6
    rows[:, 10], rows[:, 11] = 0.2, -1.0
    return rows


def found_in(machine, rows, dt=0.01, locked=()):
    log = new_log()
    scan(np.arange(len(rows)) * dt, rows, edges_of(machine), prepare(machine, dt), log)
    return listed(log, locked)


def test_every_condition_has_its_words():
    assert len(CONDITIONS) == N_CONDITION
    assert CONDITIONS[7] == ("boom", "low stop met", "low stop left")


def test_a_spool_edge_lies_between_the_rows(machine):
    rows = rows_of(machine, 4)
    edge = machine.spool.deadband
    rows[:, 2] = [0.0, -0.9 * edge, -1.3 * edge, -0.5 * edge]
    found = found_in(machine, rows)
    assert found["events_dropped"] == 0
    assert [event[1:] for event in found["events"]] == [["stick", "valve opens"], ["stick", "valve closes"]]
    assert [event[0] for event in found["events"]] == pytest.approx([0.0125, 0.02 + 0.01 * 0.3 / 0.8])
    assert found_in(machine, rows, locked=("stick",))["events"] == []


def test_a_contact_is_where_the_joint_was_heading(machine):
    rows = rows_of(machine, 4)
    stop = machine.boom.stops.high
    rows[:, 10] = [stop - 0.02, stop - 0.004, stop, stop - 0.001]
    rows[:, 13] = [1.6, 1.6, 0.0, -0.2]
    (met, left) = found_in(machine, rows)["events"]
    assert met == [pytest.approx(0.01 + 0.004 / 1.6), "boom", "high stop met"]
    assert left == [pytest.approx(0.02), "boom", "high stop left"]


def test_bounds_of_lines_and_pumps(machine):
    rows = rows_of(machine, 5)
    rows[:, 3] = [1e6, machine.swing.line.relief, 1e6, 1e6, 1e6]
    rows[:, 8] = [1e6, 1e6, machine.tank.floor, 1e6, 1e6]
    rows[:, 27] = [0.0, 0.0, 0.0, 1e-4, 1e-4]
    assert [tuple(event[1:]) for event in found_in(machine, rows)["events"]] == [
        ("swing", "line A relief opens"),
        ("swing", "line A relief closes"),
        ("stick", "line B runs empty"),
        ("stick", "line B fills"),
        ("series", "pump relief opens"),
    ]


def test_the_list_is_bounded(machine, monkeypatch):
    n = module.MAX_EVENTS + 100
    rows = rows_of(machine, n)
    rows[1::2, 0] = 0.01  # the valve opens and its bypass closes at every second row
    found = found_in(machine, rows)
    assert len(found["events"]) == module.MAX_EVENTS
    assert found["events_dropped"] == 2 * (n - 1) - module.MAX_EVENTS


def test_events_are_written_and_read(machine, tmp_path):
    run = simulate(machine, "exact", UP, t_end=0.3)
    assert [event[2] for event in run.info["events"]] == ["valve opens", "bypass closes"]
    write_table(run, tmp_path / "run.parquet")
    assert read_table(tmp_path / "run.parquet").info == run.info


def test_printed_openings_of_the_step_test(machine):
    """The stick opens at 0.195 s and the swing at 0.395 s (thesis 5.3.2)."""
    run = simulate(machine, "exact", load_scenario("step"), t_end=0.5)
    times = {link: t for t, link, what in run.info["events"] if what == "valve opens"}
    assert times["stick"] == pytest.approx(0.195, abs=5e-4)
    assert times["swing"] == pytest.approx(0.395, abs=5e-4)
