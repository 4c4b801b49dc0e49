"""A machine run against a log of itself, and of another one."""

from dataclasses import replace

import numpy as np
import pytest

from helpers.machine_log import changed, machine_log
from polydraulic.errors import InputError
from polydraulic.identification import plot_replay, replay
from polydraulic.identification.log_replay import against_log
from polydraulic.tables import Table

LOG = machine_log(20.0, seed=3)
FLOW = "iterative"  # as good as exact, and no lanes: plain Python fills 64 of them slowly


def some(table, keep):
    return Table({name: values[keep] for name, values in table.columns.items()}, table.units)


@pytest.fixture(scope="module")
def found(machine):
    return replay(LOG, machine, FLOW, seconds=5.0)


def test_the_machine_follows_its_own_log(found):
    windows = found.windows
    assert [round(float(w.time[0]), 6) for w in windows] == [0.0, 5.0, 10.0, 15.0]
    assert all(w.run.shape == w.measured.shape == (250, 3) for w in windows)
    for drift in found.drifts:
        assert 0.0 < drift.median <= drift.largest < (0.3 if drift.name == "tip" else np.radians(3.0))
        assert drift.moved > 5.0 * drift.median


def test_another_machine_does_not(machine, found):
    slow = machine._replace(pumps=machine.pumps._replace(boom_flow=0.7 * machine.pumps.boom_flow))
    boom = replay(LOG, slow, FLOW, seconds=5.0).drifts[1]
    assert boom.largest > 5.0 * found.drifts[1].largest


def test_dead_times_are_those_of_the_log(machine):
    late = machine._replace(boom=machine.boom._replace(pilot=machine.boom.pilot._replace(dead_time=0.3)))
    delayed = changed(LOG, boom_voltage=np.interp(LOG["time"] + 0.3, LOG["time"], LOG["boom.voltage"]))
    here, there = (replay(log, m, FLOW, seconds=5.0).windows[1] for m, log in ((machine, LOG), (late, delayed)))
    assert np.allclose(here.run, there.run, atol=2e-3)


def begins(log, machine, **options):
    return [float(window.time[0]) for window in replay(log, machine, FLOW, **options).windows]


def test_windows_stay_in_the_rows_given_and_out_of_gaps(machine):
    time = LOG["time"]
    allowed = (time > 6.0) & (time < 13.0)
    assert begins(LOG, machine, seconds=3.0, rows=allowed) == pytest.approx([6.02, 9.02])
    gap = some(LOG, (time < 2.0) | (time > 2.3))
    assert begins(gap, machine, seconds=8.0) == pytest.approx([2.3, 10.3])
    bridged = some(LOG, (time < 2.0) | (time > 2.05))
    assert begins(bridged, machine, seconds=8.0)[0] == 0.0
    with pytest.raises(InputError, match="table: no piece of 60 s without a gap; choose shorter windows"):
        replay(LOG, machine, FLOW, seconds=60.0)


def test_why_it_is_not_known(machine):
    everything = np.ones(len(LOG), dtype=bool)
    without = Table({name: values for name, values in LOG.columns.items() if name != "boom.angle"}, LOG.units)
    assert against_log(machine, FLOW, without, everything) == ("not run against the log: it has no boom.angle", [])
    told, drift = against_log(machine, FLOW, LOG, LOG["time"] < 6.0)
    assert (told.startswith("not run against the log: no piece of 10 s"), drift) == (True, [])


def test_how_far_it_drifts_is_said(found):
    head, names, *rows = str(found).splitlines()
    assert head == "4 windows of 5 s, each started from the measured state; largest distance in a window:"
    assert names.split() == ["joint", "median", "largest", "moved"]
    assert [row.split()[0] for row in rows] == ["swing", "boom", "stick", "tip"]
    assert rows[1].split()[1:3] == [f"{np.degrees(found.drifts[1].median):.2f}", "deg"]
    assert "rad" in found.text("si").splitlines()[3]


def test_models_go_with_flow_models_of_networks(machine):
    with pytest.raises(InputError, match="models go with the flow models 'polynomial' and 'neural', not with 'exact'"):
        replay(LOG, machine, "exact", models=[])


def test_the_picture_shows_joints_and_drift(found):
    figure = plot_replay(found)
    assert [axis.get_ylabel() for axis in figure.axes] == [
        "swing angle [deg]",
        "boom angle [deg]",
        "stick angle [deg]",
        "run - measured\n[deg]",
    ]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    dated = plot_replay(replace(found, began=1.7e9), units="si")
    assert dated.axes[-1].get_xlabel() == "time of day, 2023-11-14"
    assert str(dated.axes[0].lines[0].get_xdata()[0]) == "2023-11-14T22:13:20.000000"
    assert dated.axes[0].lines[0].get_ydata() == pytest.approx(found.windows[0].measured[:, 0])
    assert len(figure.axes[1].lines) == 3 * len(found.windows)


@pytest.mark.parametrize(
    ("log", "seconds", "message"),
    [
        (
            Table(LOG.columns, {**LOG.units, "stick.angle": "deg"}),
            5.0,
            "column 'stick.angle' is in 'deg'; a machine runs in SI",
        ),
        (some(LOG, slice(None, None, -1)), 5.0, "column 'time' does not rise"),
        (Table({"time": LOG["time"]}, {}), 5.0, "no column 'swing.voltage'"),
        (LOG, 0.0, "a window of 0 s: must be finite and two time steps"),
        (LOG, float("nan"), "a window of nan s"),
    ],
)
def test_bad_logs_are_named(machine, log, seconds, message):
    with pytest.raises(InputError, match=message):
        replay(log, machine, FLOW, seconds=seconds)


def test_no_window_goes_over_the_end_of_one_of_several_logs(machine):
    half = len(LOG) // 2  # files that a logger cut without losing a row
    parts = [some(LOG, np.arange(len(LOG)) < half), some(LOG, np.arange(len(LOG)) >= half)]
    assert begins(LOG, machine, seconds=8.0) == pytest.approx([0.0, 8.0])
    assert begins(parts, machine, seconds=8.0) == pytest.approx([0.0, LOG["time"][half]])
    anew = Table({**parts[1].columns, "time": parts[1]["time"] - parts[1]["time"][0]}, LOG.units)
    windows = replay([parts[0], anew], machine, FLOW, seconds=8.0).windows
    assert windows[1].time[0] == pytest.approx(LOG["time"][half - 1] + 60.0)
    assert windows[1].run == pytest.approx(replay(parts[1], machine, FLOW, seconds=8.0).windows[0].run, abs=1e-3)
