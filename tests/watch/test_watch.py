"""A machine watched: nothing of healthy work, faults by their names, row by row as block by block."""

import numpy as np
import pytest

from helpers.watched_logs import blocks, healthy_log, held, known, log_of, watched_by
from polydraulic import InputError
from polydraulic.watch.learning import learn_expected
from polydraulic.watch.watch import FaultWatch
from polydraulic.watch.watched import watched


def test_healthy_work_of_another_operator_raises_no_alarm():
    of, expected = known()
    watch = watched_by(of, expected, log_of(of.machine, 21, 240.0))
    assert watch.alarms == []
    told = {f.name: f.could_show for f in watch.findings()}
    assert told["work.pump_worn"]
    assert told["lift.spool_slow"]
    assert all(told[f"{column}.freeze"] for column in of.columns if column.startswith("lift."))


@pytest.mark.parametrize(
    "fault",
    [
        "work.pump_worn",
        "lift.spool_slow",
        "tilt.spool.bias",
        "lift.p_a.bias",
        "lift.q_in.freeze",
        "tip.payload_unknown",
    ],
)
def test_a_fault_is_found_and_named(fault):
    of, expected = known()
    watch = watched_by(of, expected, log_of(of.machine, 22, 80.0, [f"{fault} from 20 s"]))
    (alarm,) = watch.alarms
    assert alarm.suspects[0].name == fault
    assert 15.0 < alarm.since < 60.0
    assert alarm.since < alarm.seen <= alarm.until
    assert alarm.suspects[0].harmless == (fault == "tip.payload_unknown")


@pytest.mark.slow
@pytest.mark.parametrize(
    "fault", ["main_taking.pump_worn", "boom.leak_across 10 %", "stick.orifices_worn", "stick.q_in.bias"]
)
def test_a_fault_of_circuits_that_a_crossover_joins_is_found_and_named(fault):
    of, expected = known("cat215b_crossover")
    (alarm,) = watched_by(of, expected, log_of(of.machine, 22, 90.0, [f"{fault} from 20 s"])).alarms
    assert alarm.suspects[0].name == fault.split()[0]
    assert 15.0 < alarm.since < 60.0


def test_a_fault_that_begins_during_unusual_work_is_an_alarm_of_its_own():
    of, expected = known()
    faults = ["tip.payload_unknown from 10 s", "lift.leak_across 10 % from 100 s"]
    watch = watched_by(of, expected, log_of(of.machine, 25, 180.0, faults))
    first, second = watch.alarms
    assert first.suspects[0].name == "tip.payload_unknown"
    assert second.suspects[0].name == "lift.leak_across"
    assert 85.0 < second.since < second.seen < 180.0
    assert not second.suspects[0].harmless
    (alone,) = watched_by(of, expected, log_of(of.machine, 25, 180.0, faults[:1])).alarms
    assert alone.suspects[0].harmless


def test_a_fault_behind_a_sensor_that_moves_again_is_named():
    of, expected = known()
    log = held(log_of(of.machine, 28, 130.0, ["lift.leak_across 10 % from 20 s"]), "lift.q_in", 50.0, 90.0)
    watch, names = FaultWatch(of, expected), []
    watch.judge(*blocks(of, log), lambda: names.append(watch.alarms[-1].suspects[0].name if watch.alarms else ""))
    assert names[45] == "lift.leak_across"
    assert set(names[70:90]) == {"lift.q_in.freeze"}
    assert set(names[100:]) == {"lift.leak_across"}
    (alarm,) = watch.alarms
    assert watch.seen.blocks < 45
    assert alarm.suspects[0].size == pytest.approx(0.1, rel=0.1)


def test_a_sensor_that_stayed_for_a_while_keeps_its_name_where_nothing_goes_on():
    of, expected = known()
    watch = watched_by(of, expected, held(log_of(of.machine, 28, 130.0), "lift.q_in", 50.0, 90.0))
    assert [alarm.suspects[0].name for alarm in watch.alarms] == ["lift.q_in.freeze"]
    assert watch.alarms[0].until < 120.0


def test_of_sensors_that_stay_nothing_is_told_before_their_functions_work():
    of, expected = known()
    told = {f.name: f for f in watched_by(of, expected, log_of(of.machine, 21, 8.0)).findings()}
    stays = [told[f"{column}.freeze"] for column in of.columns]
    assert all(not outlook.could_show and outlook.share < 1.0 for outlook in stays)
    assert any(outlook.share > 0.0 for outlook in stays)


def test_rows_one_by_one_are_as_blocks():
    of, expected = known()
    log = log_of(of.machine, 23, 30.0, ["work.pump_worn from 8 s"])
    whole, streamed = watched_by(of, expected, log), FaultWatch(of, expected)
    values = log.matrix(list(of.columns))
    for time, row in zip(log["time"].tolist(), values, strict=True):
        streamed.update(time, row)
    assert streamed.blocks == whole.blocks > 20
    assert np.allclose(streamed.shares, whole.shares, rtol=1e-9, atol=1e-9)
    (one,), (other,) = streamed.alarms, whole.alarms
    assert one[:3] == other[:3]
    assert [s.name for s in one.suspects] == [s.name for s in other.suspects] == ["work.pump_worn"]
    assert one.suspects[0].size == pytest.approx(other.suspects[0].size, rel=1e-9)


def test_a_gap_begins_a_new_block():
    of, expected = known()
    log = healthy_log()
    values, watch = log.matrix(list(of.columns)), FaultWatch(of, expected)
    rows = of.shape.rows
    for k in [*range(rows - 1), *range(rows + 200, 2 * rows + 199)]:
        watch.update(log["time"][k], values[k])
    assert watch.blocks == 0
    watch.update(log["time"][2 * rows + 199], values[2 * rows + 199])
    assert watch.blocks == 1


def test_blocks_between_rows_do_not_stand_in_for_them():
    of, expected = known()
    expected = expected._replace(slow=np.zeros(len(of.directions)))  # so that evidence adds up
    log = log_of(of.machine, 21, 4.0)
    times, values, half = log["time"].tolist(), log.matrix(list(of.columns)), of.shape.rows // 2
    plain, mixed = FaultWatch(of, expected), FaultWatch(of, expected)
    for k in range(half, half + of.shape.rows):
        plain.update(times[k], values[k])
    for k in range(half):
        mixed.update(times[k], values[k])
    readings, begins = blocks(of, log)
    mixed.judge({column: 2.0 * r[:1] for column, r in readings.items()}, begins[:1])
    before = mixed.judge_parts.showing.copy()
    for k in range(half, half + of.shape.rows):
        mixed.update(times[k], values[k])
    assert (plain.blocks, mixed.blocks) == (1, 2)
    assert np.allclose(mixed.judge_parts.showing - before, plain.judge_parts.showing)


def test_what_cannot_be_watched_is_refused():
    of, expected = known()
    with pytest.raises(InputError, match="nothing of the machine can be watched by lift.q_in"):
        watched(of.machine, ["lift.q_in"], 0.02)
    readings, _ = blocks(of, log_of(of.machine, 24, 20.0))
    with pytest.raises(InputError, match="what is to be expected takes 60"):
        learn_expected(of, readings, {})
    with pytest.raises(InputError, match="must be above 0"):
        FaultWatch(of, expected, 0.0)


def test_rows_that_are_not_those_of_the_machine_are_refused():
    of, expected = known()
    log = healthy_log()
    row = log.matrix(list(of.columns))[0]
    watch = FaultWatch(of, expected)
    with pytest.raises(InputError, match=r"row at 1 s: its shape is \(1,\); it must have one value for each of"):
        watch.update(1.0, row[:1])
    unread = np.where(np.arange(len(row)) == 1, np.nan, row)
    with pytest.raises(InputError, match=f"row at 1 s: {of.columns[1]} is no finite number; leave the row out"):
        watch.update(1.0, unread)
    with pytest.raises(InputError, match="row at nan s: time is no finite number"):
        watch.update(np.nan, row)
    assert watch.blocks == 0


@pytest.mark.parametrize(
    ("share", "words"),
    [(0.5, "are 0.01 s apart, those that were learnt from 0.02 s"), (2.0, "none of the last 100 rows")],
)
def test_rows_at_another_raster_are_refused(share, words):
    of, expected = known()
    row = healthy_log().matrix(list(of.columns))[0]
    watch = FaultWatch(of, expected)
    with pytest.raises(InputError, match=words):
        for k in range(of.shape.rows + 1):
            watch.update(share * of.shape.raster * k, row)
    assert watch.blocks == 0
    if share < 1.0:
        watch.update(share * of.shape.raster * of.shape.rows, row)  # a block begins anew, and whoever watches can go on


def test_rows_that_come_too_seldom_are_refused():
    of, _ = known()
    with pytest.raises(
        InputError, match=r"rows come every 0.2 s; a machine is watched by rows every 0.1 s or more often"
    ):
        watched(of.machine, of.columns, 0.2)
    assert watched(of.machine, of.columns, 0.1).shape.raster == 0.1
