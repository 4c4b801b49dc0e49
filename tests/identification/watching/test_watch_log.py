"""Logs watched as a whole: what is found, what is said, what is refused."""

import numpy as np
import pytest

from helpers.watched_logs import healthy_log, log_of
from polydraulic import InputError, load_machine
from polydraulic.identification import watch_log
from polydraulic.identification.arguments import table_of, times_of_parts
from polydraulic.identification.watching import watch_log as watch_log_module
from polydraulic.identification.watching.watch_log import alarm_rows, learnt_from
from polydraulic.tables import Table
from polydraulic.watch import Alarm, Suspect
from polydraulic.watch.blocks import block_shape, starts_of
from polydraulic.watch.watched import watched


def part(log, names):
    return Table({n: log[n] for n in names}, {n: log.unit(n) for n in names})


@pytest.fixture(scope="module")
def worn():
    machine = load_machine("wheel_loader")
    return watch_log(log_of(machine, 31, 60.0, ["work.pump_worn from 20 s"]), machine, healthy=healthy_log())


def test_a_fault_is_named_with_its_size_and_time(worn):
    assert worn.faulty
    assert worn.alarms[0].suspects[0].size == pytest.approx(0.05, rel=0.2)
    said = str(worn)
    assert "pump of work worn: its flow is" in said
    assert "faults would have shown in their smallest sizes" in said
    assert worn.evidence.shape == (len(worn.time), len(worn.of.directions))
    assert worn.evidence.max() >= 1.0


def test_without_a_healthy_log_the_beginning_counts_as_healthy():
    log = log_of(load_machine("wheel_loader"), 32, 240.0)
    found = watch_log(log, "wheel_loader")
    assert "its first 80 s, taken for healthy" in str(found)
    assert "no alarm" in str(found)
    assert found.time[0] > 80.0
    assert "not judged: 1.4 of the 4.0 min that the rows last: 1.3 min are what is taken for healthy\n" in str(found)


def test_how_much_is_not_judged_is_said_with_the_reason():
    shape, time = block_shape(0.1), 0.1 * np.arange(600.0)
    # 20 s, then pieces of 2 s, of which none holds a block
    segment = np.where(np.arange(600) < 200, 0, np.arange(600) // 20)
    blocks = len(starts_of(time, segment, shape))
    said = watch_log_module._not_judged(Table({"time": time, "segment": segment}, {}), 0, blocks, shape)
    assert blocks == 18
    assert watch_log_module._not_judged(Table({"time": time}, {}), 0, 58, shape) == ""
    assert said.startswith(
        "0.7 of the 1.0 min that the rows last: 0.7 min are, of each of 21 pieces without a gap, the"
    )
    assert said.endswith("the first 1 s and the last 0.4 s, which filters need, and what fills no block of 1 s")


def test_a_pumps_pressure_is_read_where_the_log_has_it():
    """Its sensor's faults are watched for, and a relief setting that is low shows in it."""
    machine = load_machine("wheel_loader")
    healthy = log_of(machine, 33, 150.0, pumps=["work"])
    biased = watch_log(
        log_of(machine, 34, 40.0, ["work.p_pump.bias 5 % from 10 s"], pumps=["work"]), machine, healthy=healthy
    )
    assert "work.p_pump" in biased.of.columns
    assert biased.alarms[0].suspects[0].name == "work.p_pump.bias"
    assert biased.alarms[0].suspects[0].size == pytest.approx(0.05, rel=0.2)
    told = [
        watch_log(log_of(machine, 35, 40.0, pumps=["work"]), machine, healthy=healthy, sensors=sensors).findings
        for sensors in (None, ["*.p_?", "*.spool", "*.voltage", "*.angle", "*.q_*"])
    ]
    with_it, without = ({f.name: f.share for f in findings}["work.pump_relief_low"] for findings in told)
    assert with_it > without


def test_fewer_sensors_watch_fewer_faults():
    machine = load_machine("wheel_loader")
    log = log_of(machine, 33, 60.0, ["lift.p_a.bias from 20 s"])
    found = watch_log(log, machine, healthy=healthy_log(), sensors=["*.p_?", "*.angle", "*.voltage"])
    assert set(found.of.columns) == {f"{f}.{w}" for f in machine.names for w in ("p_a", "p_b", "angle", "voltage")}
    assert "lift.spool.bias" not in [f.name for f in found.findings]
    assert found.faulty


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (lambda log: part(log, [n for n in log.names if n != "time"]), "no column 'time'"),
        (lambda log: part(log, ["time", "lift.q_in"]), "nothing of the machine can be watched"),
        (lambda log: Table({**log.columns, "lift.p_a": log["lift.p_a"]}, {**log.units, "lift.p_a": "bar"}), "in 'bar'"),
        (lambda log: part(log, ["time"]), "no column is of a sensor of .* such as lift.spool, .*; it has time"),
        (lambda log: Table({n: v[:60] for n, v in log.columns.items()}, log.units), "no piece of"),
    ],
)
def test_a_log_that_cannot_be_watched_is_refused(changed, words):
    log = log_of(load_machine("wheel_loader"), 34, 10.0)
    with pytest.raises(InputError, match=words):
        watch_log(changed(log), "wheel_loader", healthy=healthy_log())


def test_healthy_work_must_be_read_by_the_same_sensors():
    log = log_of(load_machine("wheel_loader"), 34, 10.0)
    fewer = part(healthy_log(), [n for n in healthy_log().names if not n.endswith("q_out")])
    with pytest.raises(InputError, match="no column 'lift.q_out'"):
        watch_log(log, "wheel_loader", healthy=fewer)
    slower = Table({n: v[::2] for n, v in healthy_log().columns.items()}, healthy_log().units)
    with pytest.raises(InputError, match="import both on one raster"):
        watch_log(log, "wheel_loader", healthy=slower)
    with pytest.raises(InputError, match="no column of table is called so|is called so"):
        watch_log(log, "wheel_loader", healthy=healthy_log(), sensors=["*.torque"])
    assert np.isfinite(log.matrix(log.names)).all()


def test_arguments_are_checked_before_anything_is_learnt():
    log = log_of(load_machine("wheel_loader"), 34, 10.0)
    with pytest.raises(InputError, match="rate = nan false alarms per hour"):
        watch_log(log, "wheel_loader", rate=np.nan)
    with pytest.raises(InputError, match=r"sensors = '\*.spool': must be a list, for example \['\*.spool'\]"):
        watch_log(log, "wheel_loader", sensors="*.spool")
    with pytest.raises(InputError, match="its first 3 s, taken for healthy: healthy work has .*give more healthy work"):
        watch_log(log, "wheel_loader")


def refused_while_learning(of, log, own, rate):
    raise InputError(f"{own.sum()} rows are learnt from")


@pytest.mark.parametrize(("rows", "said"), [(20_000, "its first 600 s"), (17_900, "its first 597 s")])
def test_a_third_of_a_log_is_taken_for_healthy_and_ten_minutes_at_most(monkeypatch, rows, said):
    monkeypatch.setattr(watch_log_module, "learnt_from", refused_while_learning)
    short = log_of(load_machine("wheel_loader"), 34, 10.0)
    columns = {name: np.resize(short[name], rows) for name in short.names} | {"time": 5.0 + 0.1 * np.arange(rows)}
    with pytest.raises(InputError, match=f"{said}, taken for healthy: {min(6000, -(-(rows - 1) // 3))} rows"):
        watch_log(Table(columns, short.units), "wheel_loader")


@pytest.mark.parametrize(("factor", "one"), [(1.009, True), (0.991, True), (1.011, False), (0.989, False)])
def test_rasters_of_a_log_and_of_healthy_work_are_one_within_a_hundredth(monkeypatch, factor, one):
    monkeypatch.setattr(watch_log_module, "learnt_from", refused_while_learning)
    log = log_of(load_machine("wheel_loader"), 34, 10.0)
    other = Table({**log.columns, "time": factor * log["time"]}, log.units)
    with pytest.raises(InputError, match="rows are learnt from" if one else "import both on one raster"):
        watch_log(log, "wheel_loader", healthy=other)


@pytest.mark.parametrize(
    ("left", "told"), [(29, False), (30, True)]
)  # of 0.1 s, 3 s of which are a twentieth of a minute
def test_three_seconds_that_are_not_judged_are_told(left, told):
    shape = block_shape(0.1)
    rows = 20 * shape.inside + left
    said = watch_log_module._not_judged(Table({"time": 0.1 * np.arange(rows)}, {}), 0, 20, shape)
    assert bool(said) == told


def test_sensors_that_stay_are_told_together():
    """Each for itself: one is no explanation of the other."""
    stays = [
        Suspect(f"{c}.freeze", f"sensor of {c} stays at what it reads", 1.0, np.nan, np.nan, False)
        for c in ("lift.p_b", "tilt.p_b")
    ]
    ((*_, what, sure, more),) = alarm_rows([Alarm(1.0, 2.0, 3.0, tuple(stays))])
    assert what == "sensor of lift.p_b stays at what it reads and sensor of tilt.p_b stays at what it reads"
    assert (sure, more) == ("99%", "-")


def test_of_much_healthy_work_runs_from_all_over_are_learnt_from(monkeypatch):
    log = healthy_log()
    of = watched(load_machine("wheel_loader"), [n for n in log.names if n != "time"], 0.02)
    asked = []
    monkeypatch.setattr(watch_log_module, "learn_expected", lambda of, readings, *more: asked.append(readings))
    many = Table(
        {name: np.tile(values, 20) for name, values in log.columns.items() if name != "time"}
        | {"time": 0.02 * np.arange(20 * len(log))},
        log.units,
    )
    learnt_from(of, many, np.ones(len(many), dtype=bool), 0.1)
    assert 1700 < len(asked[0]["lift.angle"]) <= 1900


def test_alarms_of_joined_logs_are_told_in_the_time_of_their_log():
    first, second = (
        healthy_log(seconds=150.0),
        log_of(load_machine("wheel_loader"), 22, 60.0, ["lift.leak_across 10 % from 20 s"]),
    )
    joined, _ = table_of([first, second])
    parts = times_of_parts(joined)
    assert [part.name for part in parts] == ["table (1)", "table (2)"]
    assert parts[0].shift == 0.0
    assert joined["time"][len(first)] == second["time"][0] + parts[1].shift
    found = watch_log([first, second], "wheel_loader", healthy=first)
    (row,) = alarm_rows(found.alarms, found.began, found.parts)
    own, name = row[0].split(" s of ")
    assert name == "table (2)"
    assert float(own) == pytest.approx(found.alarms[0].since - parts[1].shift, abs=0.06)
    assert 15.0 < float(own) < 60.0
    assert row[1].endswith(" s")
    assert times_of_parts(first) == ()


def test_a_sensor_that_is_silent_for_a_while_is_said_and_the_rest_is_watched():
    log = log_of(load_machine("wheel_loader"), 32, 120.0)
    columns = dict(log.columns) | {"lift.p_a": log["lift.p_a"].copy(), "cab.heat": np.full(len(log), np.nan)}
    raster = float(np.median(np.diff(log["time"])))
    columns["lift.p_a"][round(60.0 / raster) : round(90.0 / raster)] = np.nan
    found = watch_log(Table(columns, log.units).partial(), "wheel_loader", healthy=healthy_log())
    assert "0.5 min are rows in which a sensor that is watched has no value" in str(found)
    assert "no alarm" in str(found)
    assert not ((found.time > 62.0) & (found.time < 90.0)).any()
    assert (found.time > 92.0).any()
