"""Joints of logs that we make ourselves, and of a machine that is simulated."""

import re

import numpy as np
import pytest

from helpers.joint_log import joint_log
from polydraulic import save_models
from polydraulic.errors import InputError
from polydraulic.identification import check_models, fit_joints, write_card
from polydraulic.identification.joint_fit import _check_goes_on, _went_round
from polydraulic.identification.run_plot import plot_separately
from polydraulic.measure import import_log, load_channels, load_sensors, record, suggest_channels
from polydraulic.tables import Table


@pytest.fixture(scope="module")
def joints():
    return fit_joints(joint_log(), ["lever.a", "lever.b"], ["a", "b"], horizon=5.0)


def test_joints_state_how_they_follow_their_commands(joints, tmp_path):
    for fit in joints.outputs:
        assert fit.errors.free_run.rms < 0.5 * fit.others["linear, same lags"].free_run.rms
        assert fit.errors.free_run.rms < 0.1 * fit.others["last value held"].free_run.rms
    a = joints.outputs[0].model.training["response"]
    assert (a["command"], a["unit"], a["stops"][1]) == ("lever.a", "V", True)
    assert a["dead_time"] + a["lag"] == pytest.approx(0.05 * 2.5, abs=0.03)
    text = str(joints)
    assert "lever.b moves it beyond 0." in text
    assert "never driven against a stop" in text or "driven against its" in text
    save_models(joints.models, tmp_path / "j.json")
    assert str(check_models(tmp_path / "j.json", data=joint_log(seed=3))).startswith("a [deg]: holds")
    write_card(joints, tmp_path / "j.html", max_boxes=20)
    assert "fully at" in (tmp_path / "j.html").read_text()


def test_more_rows_than_are_read_are_refused():
    told = r"longest = 7 s takes 140 rows of 0.05 s, 120 are the most: .* raster of 58.4 ms or more .*, or give --longest 6 or less"
    with pytest.raises(InputError, match=told):
        fit_joints(joint_log(gap=False), ["lever.a"], ["a"], longest=7.0)


SENSORS = """
seed = 5

[[sensor]]
column = "boom.voltage"
unit = "V"
raster = "50 ms"

[[sensor]]
column = "boom.angle"
unit = "deg"
raster = "50 ms"
noise = 0.05
resolution = 0.05
"""


def test_the_valve_of_an_excavator_is_found_from_lever_and_angle(machine, tmp_path):
    (tmp_path / "sensors.toml").write_text(SENSORS)
    record(machine, ["random:1:60", "random:2:60"], load_sensors(tmp_path / "sensors.toml"), tmp_path / "log.csv")
    (tmp_path / "map.toml").write_text(suggest_channels(tmp_path / "log.csv"))
    import_log(tmp_path / "log.csv", load_channels(tmp_path / "map.toml"), tmp_path / "log.parquet")
    fit = fit_joints(tmp_path / "log.parquet", ["boom.voltage"], ["boom.angle"], horizon=5.0).outputs[0]
    facts, pilot = fit.model.training["response"], machine.functions[1].pilot
    opens = (
        0.188 * 0.0254 / pilot.gain
    )  # V, where the deadband ends; motion begins there or a little later, by the load
    assert [edge for edge, _ in facts["edges"]] == pytest.approx([opens, -opens], abs=0.02)
    assert facts["dead_time"] + facts["lag"] == pytest.approx(pilot.dead_time + pilot.time_constant, abs=0.04)
    assert fit.errors.free_run.rms < 0.1 * fit.others["last value held"].free_run.rms


def test_a_joint_that_turns_without_end_is_not_stopped_and_nothing_depends_on_its_angle(tmp_path):
    log = joint_log(gap=False)
    columns = {name: log[name] for name in log.names} | {"b": 3.0 * np.pi * log["b"] / np.ptp(log["b"])}
    units = {name: log.unit(name) for name in log.names} | {"b": "rad"}
    round_ = Table(columns, units)  # one and a half turns
    fit = fit_joints(round_, ["lever.a", "lever.b"], ["a", "b"], horizon=5.0)
    a, b = fit.outputs
    assert [one.model.training["response"]["continuous"] for one in (a, b)] == [False, True]
    assert "b" not in {lag.signal for lag in a.model.dynamics.lags}
    assert "turn without end" in str(fit)
    low, high = b.model.domain()[[str(v) for v in b.model.inputs].index("b[t-1] [rad]")]
    assert high - low > 1000.0 * np.ptp(round_["b"])
    panels = plot_separately(b.model, b.held).axes
    assert not any(panels[0].get_shared_y_axes().joined(panels[0], other) for other in panels[1:])
    panels = plot_separately(a.model, a.held).axes
    assert all(panels[0].get_shared_y_axes().joined(panels[0], other) for other in panels[1:])
    with pytest.raises(InputError, match=r"continuous joints \['swing'\] are not among the joints: \['a'\]"):
        fit_joints(log, ["lever.a"], ["a"], continuous=["swing"])


def test_a_continuous_angle_that_jumps_back_after_a_turn_is_refused():
    log = joint_log(gap=False)
    turned = np.degrees(3.0 * np.pi * log["b"] / np.ptp(log["b"]))
    wrapped = (turned + 180.0) % 360.0 - 180.0
    row = 1 + int(np.flatnonzero(np.abs(np.diff(wrapped)) > 180.0)[0])
    columns = {name: log[name] for name in log.names} | {"b": wrapped}
    units = {name: log.unit(name) for name in log.names} | {"b": "deg"}
    with pytest.raises(InputError, match=rf"'b' goes from .* deg in row {row + 1}, .* unwrap it first, .* period=360"):
        fit_joints(Table(columns, units), ["lever.b"], ["b"], continuous=["b"])


def short_segments(rows):
    """Forty segments, and one of ten rows, of a joint behind a lever with play."""
    n = 40 * rows + 10
    lever = np.sin(0.05 * np.arange(n)) + 0.5 * np.sin(0.131 * np.arange(n) + 1.0)
    valve, angle = 0.0, np.zeros(n)
    for t in range(1, n):
        valve = np.clip(valve, lever[t - 1] - 0.12, lever[t - 1] + 0.12)
        angle[t] = angle[t - 1] + 0.02 * (max(valve - 0.2, 0.0) - max(-0.2 - valve, 0.0))
    columns = {"time": 0.05 * np.arange(n), "segment": np.arange(n) // rows, "lever": lever, "angle": angle}
    return Table(columns, {"angle": "rad"})


@pytest.mark.parametrize("rows", [39, 42])
def test_logs_of_short_segments_are_learnt_without_play_and_what_is_too_short_is_named(rows):
    found = fit_joints(short_segments(rows), ["lever"], ["angle"], longest=0.8, horizon=1.0)
    (fit,) = found.outputs
    assert fit.errors.free_run.r2 > 0.99
    if rows == 39:
        assert fit.model.training["response"]["play"] == 0.0
        without_play = "play was not looked for: that takes 68 rows after 40 others without a gap between them, and the log has 0: shorten"
        assert found.doubts[-2].startswith(without_play)
    only, left_out = found.doubts[0], found.doubts[-1]
    assert re.match(
        rf"\d+ of {40 * rows + 10} rows are read and teach nothing: the first \d+ of each of 41 pieces", only
    )
    assert left_out.startswith("1 of 41 runs of rows without a gap were left out")
    assert f"rows {40 * rows + 1} to {40 * rows + 10}; shorten the longest lag of 16 rows" in left_out
    assert f"warning: {left_out}" in str(found)


def test_joints_need_a_command_each():
    with pytest.raises(InputError, match="1 commands for 2 joints"):
        fit_joints(joint_log(), ["lever.a"], ["a", "b"])
    with pytest.raises(InputError, match=r"horizon = 0.0 s: must be a time above 0"):
        fit_joints(joint_log(), ["lever.a"], ["a"], horizon=0.0)
    with pytest.raises(InputError, match="'lever.b' explains"):
        fit_joints(joint_log(), ["lever.b"], ["a"])


@pytest.mark.parametrize(("unit", "turn"), [("rad", 2.0 * np.pi), ("deg", 360.0), ("m", np.inf), ("", np.inf)])
def test_an_angle_goes_round_beyond_a_turn_and_back_beyond_half_a_turn_a_row(unit, turn):
    size = turn if turn < np.inf else 1e9
    table = Table({"time": np.arange(9.0), "a": np.linspace(-0.3, 0.7, 9) * size * 1.001}, {"a": unit})
    assert _went_round(table, "a") == (turn < np.inf)
    assert not _went_round(Table(table.columns | {"a": 0.998 * table["a"]}, {"a": unit}), "a")
    for way in (1.0, -1.0):
        angle = np.where(np.arange(9) < 4, 0.0, way * 0.499 * size)
        _check_goes_on(Table(table.columns | {"a": angle}, {"a": unit}), "a")
        angle = np.where(np.arange(9) < 4, 0.0, way * 0.501 * size)
        further = Table(table.columns | {"a": angle}, {"a": unit})
        if turn < np.inf:
            with pytest.raises(
                InputError, match=rf"in row 5, and so by more than half a turn in 1 row\(s\).* period={turn:.6g}"
            ):
                _check_goes_on(further, "a")
        else:
            _check_goes_on(further, "a")
        # where rows do not follow each other nobody knows how far it went between
        _check_goes_on(Table(further.columns | {"segment": 1.0 * (np.arange(9) >= 4)}, {"a": unit}), "a")
