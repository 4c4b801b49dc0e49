"""Logs cut into windows."""

import numpy as np
import pytest

from helpers.machine_motion import motion_log
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.shooting.windows import LEAD, cut_windows, sensors_of
from polydraulic.tables import Table

NAME = "loader_crane"


def commanded(seconds=20.0, noise=0.0):
    machine = load_machine(NAME)
    log = motion_log(machine, seconds=seconds, noise=noise)
    volts = {f"{f}.voltage": 0.5 * np.sin(log["time"] + k) for k, f in enumerate(machine.names)}
    return machine, Table({**log.columns, **volts}, log.units | dict.fromkeys(volts, "V"))


def test_windows_follow_each_other_and_begin_after_the_lead():
    machine, log = commanded()
    windows = cut_windows(machine, log, ["slew.angle", "outer.p_a"], seconds=2.0, most=100)
    assert windows.dt == pytest.approx(5e-3)
    assert windows.every == 4
    assert windows.n_step == 400
    assert np.allclose(np.diff(windows.time), 2.0)
    assert windows.time[0] >= LEAD
    assert windows.measured.shape == (len(windows.time), 100, 2)
    row = round(windows.time[3] / 0.02)
    assert np.allclose(windows.measured[3, :, 0], log["slew.angle"][row + 1 : row + 101])
    assert windows.p_a is None  # not of every function
    assert np.allclose(windows.position[3, 0], log["slew.angle"][row], atol=1e-3)
    rate = np.gradient(log["slew.angle"], 0.02)
    assert np.allclose(windows.rate[3, 0], rate[row], atol=1e-2)


def test_few_windows_are_spread_over_the_log():
    machine, log = commanded(seconds=60.0)
    windows = cut_windows(machine, log, ["slew.angle"], seconds=1.0, most=5)
    assert len(windows.time) == 5
    assert windows.time[-1] - windows.time[0] > 50.0


def test_no_window_crosses_a_gap():
    machine, log = commanded()
    kept = (log["time"] < 7.0) | (log["time"] > 9.0)
    windows = cut_windows(
        machine, Table({n: v[kept] for n, v in log.columns.items()}, log.units), ["slew.angle"], seconds=2.0, most=50
    )
    for begin in windows.time:
        assert begin + 2.0 <= 7.0 or begin >= 9.0 + LEAD
    assert len(windows.command) == 2


def test_windows_begin_where_positions_are_known_and_nothing_is_read_of_a_silent_sensor():
    machine, log = commanded()
    columns = dict(log.columns)
    silent = {"slew.angle": slice(150, 160), "outer.p_a": slice(400, 500), "outer.angle": slice(700, 704)}
    for name, rows in silent.items():
        columns[name] = columns[name].copy()
        columns[name][rows] = np.nan
    found = cut_windows(machine, Table(columns, log.units).partial(), ["slew.angle", "outer.p_a"], seconds=2.0, most=50)
    rows = np.round(found.time / 0.02).astype(int)
    assert len(found.command) == 1  # levers are known, so that their pilots go on
    assert len(rows) >= 7
    for name in ("slew.angle", "outer.angle"):
        lost = np.arange(len(log))[silent[name]]
        for begin in (rows, rows - 50):
            assert np.abs(begin[:, None] - lost).min() > 5  # 0.1 s
    assert np.all(np.diff(rows) >= 100)
    for k, name in enumerate(["slew.angle", "outer.p_a"]):
        lost = np.isnan([columns[name][row + 1 : row + 101] for row in rows])
        assert lost.any()
        assert np.array_equal(np.isnan(found.measured[:, :, k]), lost)
    whole = cut_windows(machine, log, ["slew.angle", "outer.p_a"], seconds=2.0, most=50)
    assert [c.noise for c in found.channels] == pytest.approx([c.noise for c in whole.channels], rel=0.2, abs=1.0)
    assert np.isfinite(found.position).all()


def test_a_row_between_two_gaps_is_no_window_and_no_obstacle():
    machine, log = commanded()
    kept = (log["time"] < 7.0) | (log["time"] > 9.0)
    kept[400] = True
    alone = Table({n: v[kept] for n, v in log.columns.items()}, log.units)
    found = cut_windows(machine, alone, ["slew.angle"], seconds=2.0, most=50)
    assert [len(command) for command in found.command][1] == 1
    assert set(found.piece.tolist()) == {0, 2}


def test_noise_is_what_differences_show():
    machine, log = commanded(noise=1.0)
    windows = cut_windows(machine, log, ["outer.angle", "outer.p_a"], seconds=2.0, most=50)
    assert [c.noise for c in windows.channels] == pytest.approx([5e-4, 1e5], rel=0.15)


def test_sensors_are_what_log_and_runs_share():
    machine, log = commanded()
    more = Table({**log.columns, "weather": log["time"]}, log.units)
    assert sensors_of(machine, more) == sensors_of(machine, log)
    assert "reach.position" in sensors_of(machine, log)
    assert "slew.voltage" not in sensors_of(machine, log)


@pytest.mark.parametrize(
    ("without", "said"), [("slew.voltage", "slew.voltage"), ("reach.position", "reach.position"), ("time", "time")]
)
def test_commands_and_positions_are_the_least(without, said):
    machine, log = commanded(seconds=5.0)
    table = Table({n: v for n, v in log.columns.items() if n != without}, log.units)
    with pytest.raises(InputError, match=f"no column '{said}'"):
        cut_windows(machine, table, ["slew.angle"], seconds=2.0, most=50)


def test_a_piece_lasts_as_long_as_a_refusal_says():
    """1 s leads in, a tenth of a second gives the rate at the start, and 2 s are run."""
    machine, log = commanded(seconds=4.0)
    enough, short = (Table({n: v[:rows] for n, v in log.columns.items()}, log.units) for rows in (157, 156))
    windows = cut_windows(machine, enough, ["slew.angle"], seconds=2.0, most=50)
    assert windows.time == pytest.approx([log["time"][55]])
    with pytest.raises(InputError, match=r"no piece of the log lasts 3.12 s without a gap"):
        cut_windows(machine, short, ["slew.angle"], seconds=2.0, most=50)


def test_another_unit_is_refused():
    machine, log = commanded(seconds=5.0)
    with pytest.raises(InputError, match=r"column 'slew.angle' is in 'deg'.*in 'rad'"):
        cut_windows(
            machine, Table(log.columns, {**log.units, "slew.angle": "deg"}), ["slew.angle"], seconds=2.0, most=50
        )
