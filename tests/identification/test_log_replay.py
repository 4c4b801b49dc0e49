"""A machine run against a log of itself, and of another one."""

from dataclasses import replace

import numpy as np
import pytest

from helpers.machine_log import changed, machine_log
from helpers.valves import changed as other_parts
from polydraulic.errors import InputError
from polydraulic.identification import plot_replay, replay
from polydraulic.identification.log_replay import (
    Drift,
    Window,
    _begins,
    _near,
    _part_with,
    _state,
    against_log,
    drift_rows,
    drifts,
    joints_of,
    replayed,
)
from polydraulic.machine.frames import link_frames, placed
from polydraulic.tables import Table

FLOW = "iterative"  # as good as exact, and no lanes: plain Python fills 64 of them slowly


def some(table, keep):
    return Table({name: values[keep] for name, values in table.columns.items()}, table.units)


@pytest.fixture(scope="module")
def log():
    return machine_log(20.0, seed=3)


@pytest.fixture(scope="module")
def found(machine, log):
    return replay(log, machine, FLOW, seconds=5.0)


def test_the_machine_follows_its_own_log(found):
    windows = found.windows
    assert [round(float(w.time[0]), 6) for w in windows] == [0.0, 5.0, 10.0, 15.0]
    assert all(w.run.shape == w.measured.shape == (250, 3) for w in windows)
    for drift in found.drifts:
        assert 0.0 < drift.median <= drift.largest < (0.3 if drift.name == "tip" else np.radians(3.0))
        assert drift.moved > 5.0 * drift.median


def test_the_step_is_a_choice(machine, log, found):
    fine, usual = replay(log, machine, FLOW, seconds=5.0, dt=2.5e-3).windows[0].run, found.windows[0].run
    assert np.any(fine != usual)
    assert fine == pytest.approx(usual, abs=0.02)
    with pytest.raises(InputError, match="dt = 0 s: must be a positive number of seconds; 0.005 s is usual"):
        replay(log, machine, "exact", dt=0.0)


def test_another_machine_does_not(machine, found, log):
    slow = machine.with_values({"circuits.boom.pump.flow": 0.7 * machine.circuit("boom").pump.flow})
    boom = replay(log, slow, FLOW, seconds=5.0).drifts[1]
    assert boom.largest > 5.0 * found.drifts[1].largest


def test_dead_times_are_those_of_the_log(machine, log):
    late = other_parts(machine, "boom", pilot={"dead_time": 0.3})
    delayed = changed(log, boom_voltage=np.interp(log["time"] + 0.3, log["time"], log["boom.voltage"]))
    here, there = (replay(log, m, FLOW, seconds=5.0).windows[1] for m, log in ((machine, log), (late, delayed)))
    assert np.allclose(here.run, there.run, atol=2e-3)


def begins(log, machine, **options):
    return [float(window.time[0]) for window in replay(log, machine, FLOW, **options).windows]


def test_windows_stay_in_the_rows_given_and_out_of_gaps(machine, log):
    time = log["time"]
    allowed = (time > 6.0) & (time < 13.0)
    assert begins(log, machine, seconds=3.0, rows=allowed) == pytest.approx([6.02, 9.02])
    gap = some(log, (time < 2.0) | (time > 2.3))
    assert begins(gap, machine, seconds=8.0) == pytest.approx([2.3, 10.3])
    bridged = some(log, (time < 2.0) | (time > 2.05))
    assert begins(bridged, machine, seconds=8.0)[0] == 0.0
    with pytest.raises(InputError, match="table: no piece of 60 s without a gap; choose shorter windows"):
        replay(log, machine, FLOW, seconds=60.0)


def test_why_it_is_not_known(machine, log):
    everything = np.ones(len(log), dtype=bool)
    without = Table({name: values for name, values in log.columns.items() if name != "boom.angle"}, log.units)
    assert against_log(machine, FLOW, without, everything) == ("not run against the log: it has no boom.angle", [])
    told, drift = against_log(machine, FLOW, log, log["time"] < 6.0)
    assert (told.startswith("not run against the log: no piece of 10 s"), drift) == (True, [])


def test_how_far_it_drifts_is_said(found):
    head, names, *rows = str(found).splitlines()
    assert head == "4 windows of 5 s, each started from the measured state; largest distance in a window:"
    assert names.split() == ["joint", "median", "largest", "moved"]
    assert [row.split()[0] for row in rows] == ["swing", "boom", "stick", "tip"]
    assert rows[1].split()[1:3] == [f"{np.degrees(found.drifts[1].median):.2f}", "deg"]
    assert "rad" in found.text("si").splitlines()[3]


def test_models_go_with_flow_models_of_networks(machine, log):
    with pytest.raises(InputError, match="models go with the flow models 'polynomial' and 'neural', not with 'exact'"):
        replay(log, machine, "exact", models=[])


def test_the_picture_shows_joints_and_drift(found):
    figure = plot_replay(found)
    assert [axis.get_ylabel() for axis in figure.axes] == [
        "swing\nangle [deg]",
        "boom\nangle [deg]",
        "stick\nangle [deg]",
        "run - measured\n[deg]",
    ]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    dated = plot_replay(replace(found, began=1.7e9), units="si")
    assert dated.axes[-1].get_xlabel() == "time of day, 2023-11-14"
    assert str(dated.axes[0].lines[0].get_xdata()[0]) == "2023-11-14T22:13:20.000000"
    assert dated.axes[0].lines[0].get_ydata() == pytest.approx(found.windows[0].measured[:, 0])
    assert len(figure.axes[1].lines) == 3 * len(found.windows)
    assert figure.axes[0].get_title(loc="left") == "all 4 windows"


def test_the_picture_says_how_many_windows_it_does_not_show(found):
    figure = plot_replay(replace(found, windows=4 * found.windows))
    assert figure.axes[0].get_title(loc="left") == "the first 6 of 16 windows"
    assert len(figure.axes[1].lines) == 3 * 6


@pytest.mark.parametrize(
    ("spoilt", "seconds", "message"),
    [
        (
            lambda log: Table(log.columns, {**log.units, "stick.angle": "deg"}),
            5.0,
            "column 'stick.angle' is in 'deg'; a machine runs in SI",
        ),
        (
            lambda log: Table(log.columns | {"boom.angle": np.rad2deg(log["boom.angle"])}, log.units),
            5.0,
            "column 'boom.angle' lies between .* it must be in rad",
        ),
        (
            lambda log: Table(log.columns | {"boom.p_a": 1e-5 * log["boom.p_a"]}, log.units),
            5.0,
            "column 'boom.p_a' comes to .* it must be in Pa",
        ),
        (lambda log: some(log, slice(None, None, -1)), 5.0, "column 'time' does not rise"),
        (
            lambda log: Table({"time": log["time"]}, {}),
            5.0,
            "the log has no column of swing, boom, stick, the functions of",
        ),
        (lambda log: log, 0.0, "a window of 0 s: must be finite and two time steps"),
        (lambda log: log, float("nan"), "a window of nan s"),
    ],
)
def test_bad_logs_are_named(machine, log, spoilt, seconds, message):
    with pytest.raises(InputError, match=message):
        replay(spoilt(log), machine, FLOW, seconds=seconds)


def test_no_window_goes_over_the_end_of_one_of_several_logs(machine, log):
    half = len(log) // 2  # files that a logger cut without losing a row
    parts = [some(log, np.arange(len(log)) < half), some(log, np.arange(len(log)) >= half)]
    assert begins(log, machine, seconds=8.0) == pytest.approx([0.0, 8.0])
    assert begins(parts, machine, seconds=8.0) == pytest.approx([0.0, log["time"][half]])
    anew = Table({**parts[1].columns, "time": parts[1]["time"] - parts[1]["time"][0]}, log.units)
    windows = replay([parts[0], anew], machine, FLOW, seconds=8.0).windows
    assert windows[1].time[0] == pytest.approx(log["time"][half - 1] + 60.0)
    assert windows[1].run == pytest.approx(replay(parts[1], machine, FLOW, seconds=8.0).windows[0].run, abs=1e-3)


RASTER = 1.0 / 64.0  # s, so that sums of it are exact


def first_rows(time, seconds=1.0, parts=None, rows=None):
    """Rows in which windows begin."""
    rows = np.ones(len(time), dtype=bool) if rows is None else rows
    return _begins(time, rows, seconds, [len(time)] if parts is None else parts)


def test_windows_fill_a_piece_to_its_last_row():
    assert first_rows(RASTER * np.arange(129)) == [0, 64]
    assert first_rows(RASTER * np.arange(128)) == [0]
    assert first_rows(RASTER * np.arange(64)) == []


@pytest.mark.parametrize(("steps", "begun"), [(6, [0]), (7, [])])
def test_straight_lines_bridge_a_tenth_of_a_second(steps, begun):
    time = RASTER * (np.arange(60) + (steps - 1) * (np.arange(60) >= 30))
    assert first_rows(time, RASTER * 60) == begun


@pytest.mark.parametrize(
    ("raster", "begun"), [(0.025, 0), (0.026, 1), (0.033, 1), (0.034, 2), (0.05, 2), (0.051, None)]
)
def test_a_window_begins_where_five_rows_are_within_a_tenth_of_a_second(raster, begun):
    assert first_rows(raster * np.arange(200))[:1] == ([] if begun is None else [begun])


@pytest.mark.parametrize("began", [0.0, 17.3, 1.7e9])  # s since 1970: no difference of them is exact
@pytest.mark.parametrize(("raster", "first"), [(0.01, 0), (0.02, 0), (1.0 / 30.0, 1), (0.05, 2)])
def test_windows_are_the_same_whenever_a_log_began(began, raster, first):
    n = round(2.0 / raster)
    time = began + raster * np.arange(3 * n + first + 1)
    assert first_rows(time, 2.0) == [first, first + n, first + 2 * n]
    bridged = np.delete(time, np.arange(n, n + round(0.1 / raster) - 1))  # a tenth of a second
    assert first_rows(bridged, 2.0)[:1] == [first]
    assert len(first_rows(bridged, 5.0)) == 1


def test_windows_stay_in_their_part_and_in_rows_that_follow_each_other():
    time = RASTER * np.arange(200)
    assert first_rows(time, parts=[100, 100]) == [0, 100]
    assert first_rows(time, parts=[60, 70, 70]) == [60, 130]
    rows = np.ones(200, dtype=bool)
    rows[64] = False
    assert first_rows(time, rows=rows) == [65, 129]
    rows[65] = False
    assert first_rows(time, rows=rows) == [66, 130]
    assert first_rows(time, rows=np.zeros(200, dtype=bool)) == []


def test_rows_of_another_part_say_nothing_about_the_start():
    parts, time = [10, 20], RASTER * np.arange(30)
    for row, expected in (
        (0, range(7)),
        (9, range(3, 10)),
        (10, range(10, 17)),
        (20, range(14, 27)),
        (29, range(23, 30)),
    ):
        own = _part_with(parts, row)
        assert own == (slice(0, 10) if row < 10 else slice(10, 30))
        assert _near(time, row, own).tolist() == list(expected)


def test_the_state_at_the_start_is_measured_and_its_rates_are_those_of_a_parabola(machine):
    t = 0.02 * np.arange(40) - 0.4
    names = [f"{link}.{what}" for what in ("spool", "p_a", "p_b") for link in ("swing", "boom", "stick")]
    columns = {name: np.full(40, 1.0 + place) for place, name in enumerate(names)}
    columns["boom.spool"][20], columns["swing.p_a"][20], columns["stick.p_b"][20] = -2.0, -3.0, -4.0
    for place, link in enumerate(("swing", "boom", "stick")):
        columns[f"{link}.angle"] = place + (0.1 + place) * t + 5.0 * t**2
    found = _state(Table({"time": t + 3.0, **columns}, {}), 20, slice(0, 40), joints_of(machine))
    assert found[:9].tolist() == [1.0, -2.0, 3.0, 0.0, 5.0, 6.0, 7.0, 8.0, 0.0]  # a pressure is none below 0
    assert found[9:] == pytest.approx([0.0, 1.0, 2.0, 0.1, 1.1, 2.1], abs=1e-9)


@pytest.mark.parametrize(("seconds", "allowed"), [(0.0099, False), (0.01, True)])
def test_a_window_is_two_steps_of_5_ms_at_least(machine, seconds, allowed, log):
    nowhere = np.zeros(len(log), dtype=bool)
    if allowed:
        assert replayed(machine, FLOW, log, seconds=seconds, rows=nowhere) == []
    else:
        with pytest.raises(InputError, match="must be finite and two time steps of 0.005 s at least"):
            replayed(machine, FLOW, log, seconds=seconds, rows=nowhere)


def window(run, measured=((0.0, 0.5, -1.0), (0.1, 0.5, -1.0))):
    return Window(np.arange(2.0), np.array(measured), np.array(run))


def test_drifts_are_the_largest_distances_of_windows(machine):
    still = [[0.0, 0.5, -1.0]] * 2

    def reached(angles):
        return placed(link_frames(machine, np.array(angles)), *machine.tip)

    windows = [
        window([[0.0, 0.5, -1.0], [0.4, 0.5, -1.0]]),
        window([[0.0, 0.7, -1.0], [0.1, 0.4, -1.0]]),
        window([[-0.2, 0.5, -1.0], [0.1, 0.5, -1.0]], still),
    ]
    swing, boom, stick, tip = drifts(machine, windows)
    assert swing == ("swing", "rad", pytest.approx(0.2), pytest.approx(0.3), pytest.approx(0.1))
    assert boom == ("boom", "rad", 0.0, pytest.approx(0.2), 0.0)
    assert stick == ("stick", "rad", 0.0, 0.0, 0.0)
    at = [reached([angle, 0.5, -1.0]) for angle in (0.0, 0.1, 0.4, -0.2)]
    far = [np.linalg.norm(at[2] - at[1]), np.linalg.norm(at[0] - at[3])]
    up = max(
        np.linalg.norm(reached(a) - reached(b))
        for a, b in (((0.0, 0.7, -1.0), (0.0, 0.5, -1.0)), ((0.1, 0.4, -1.0), (0.1, 0.5, -1.0)))
    )
    assert (tip.name, tip.unit) == ("tip", "m")
    assert (tip.median, tip.largest) == pytest.approx((sorted([*far, up])[1], max(*far, up)))
    assert tip.moved == pytest.approx(np.linalg.norm(at[1] - at[0]))


def test_a_run_that_diverges_drifts_without_bound(machine):
    good, bad = [[0.0, 0.5, -1.0]] * 2, [[0.0, 0.5, -1.0], [np.nan] * 3]
    one = drifts(machine, [window(run) for run in (bad, good, good)])
    assert [(d.median < np.inf, d.largest) for d in one] == [(True, np.inf)] * 4
    two = drifts(machine, [window(run) for run in (bad, good, bad)])
    assert [row[1:3] for row in drift_rows(two)] == [["diverged"] * 2] * 4
    shown = drift_rows([Drift("boom", "rad", 0.01, 0.02, 0.5), Drift("tip", "m", 0.0123, 0.5, 1.0)])
    assert shown == [["boom", "0.57 deg", "1.15 deg", "28.65 deg"], ["tip", "12 mm", "500 mm", "1000 mm"]]
    assert drift_rows([Drift("boom", "rad", 0.01, 0.02, 0.5)], "si") == [
        ["boom", "0.0100 rad", "0.0200 rad", "0.5000 rad"]
    ]


def test_rows_that_are_not_used_or_in_no_window_are_counted(machine, log, found):
    assert found.doubts == ()
    columns = {name: values.copy() for name, values in log.columns.items()}
    columns["boom.p_a"][100:400] = np.nan  # of 1001 rows, 20 ms apart
    windows = replay(Table(columns, log.units).partial(), machine, FLOW, seconds=5.0)
    assert len(windows.windows) == 2
    unused, between = windows.doubts
    assert unused == "300 of 1001 rows are not used, since columns that are read have no value there: boom.p_a in 300"
    assert between.startswith("201 of 701 rows are in no window: they lie in pieces without a gap, or at ends of these")
    assert f"warning: {between}" in str(windows)
