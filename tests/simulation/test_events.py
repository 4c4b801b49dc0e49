"""Events: conditions between rows, the bound of the list, and times that the methods agree on."""

import numpy as np
import pytest

from polydraulic import load_scenario, simulate
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.signals import Constant
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.events import layout_events
from polydraulic.tables import read_table, write_table
from polydraulic.thesis.excavator import spool_of

UP = Scenario("up", 4.0, {"boom": Constant(0.62)}, ("swing", "stick"))


def columns_for(machine, n):
    """Values of all columns at rest."""
    found = {name: np.zeros(n) for name in columns_of(machine).place}
    for f in machine.functions:
        found[f"{f.name}.p_a"][:], found[f"{f.name}.p_b"][:] = 1e6, 1e6
        found[f"{f.name}.angle"][:] = f.initial.angle
    return found


def found_in(machine, columns, dt=0.01, locked=()):
    return layout_events(machine, locked, np.arange(len(columns["boom.spool"])) * dt, columns.__getitem__)


def test_a_spool_edge_lies_between_the_rows(machine):
    columns, edge = columns_for(machine, 4), spool_of(machine).deadband
    columns["stick.spool"] = np.array([0.0, -0.9 * edge, -1.3 * edge, -0.5 * edge])
    found = found_in(machine, columns)
    assert found["events_dropped"] == 0
    assert [event[1:] for event in found["events"]] == [["stick", "valve opens"], ["stick", "valve closes"]]
    assert [event[0] for event in found["events"]] == pytest.approx([0.0125, 0.02 + 0.01 * 0.3 / 0.8])
    assert found_in(machine, columns, locked=("stick",))["events"] == []


def test_stops_and_bounds_of_lines_and_pumps(machine):
    columns, stop = columns_for(machine, 5), machine.function("boom").stops.high
    columns["boom.angle"] = np.array([stop - 0.02, stop, stop, stop - 0.001, stop - 0.002])
    columns["swing.p_a"] = np.array([1e6, machine.function("swing").line.relief, 1e6, 1e6, 1e6])
    columns["stick.p_b"] = np.array([1e6, 1e6, machine.tank.floor, 1e6, 1e6])
    columns["series.q_relief"] = np.array([0.0, 0.0, 0.0, 1e-4, 1e-4])
    assert sorted((round(t, 6), *rest) for t, *rest in found_in(machine, columns)["events"]) == [
        (0.01, "boom", "high stop met"),
        (0.01, "swing", "line A relief opens"),
        (0.02, "stick", "line B runs empty"),
        (0.02, "swing", "line A relief closes"),
        (0.03, "boom", "high stop left"),
        (0.03, "series", "pump relief opens"),
        (0.03, "stick", "line B fills"),
    ]


def test_the_list_is_bounded(machine):
    n = MAX_EVENTS + 100
    columns = columns_for(machine, n)
    columns["swing.spool"][1::2] = 0.01  # the valve opens and its bypass closes at every second row
    found = found_in(machine, columns)
    assert len(found["events"]) == MAX_EVENTS
    assert found["events_dropped"] == 2 * (n - 1) - MAX_EVENTS


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
