"""Values in which a sensor says nothing are left out; what merely repeats numbers is not."""

import numpy as np
import pytest

from helpers.machine_log import changed
from polydraulic.display import amount
from polydraulic.identification.doubts.stuck import without_stuck
from polydraulic.tables import Table


def test_a_healthy_log_is_left_as_it_is(true, log):
    assert without_stuck(true, log) == (log, [])
    quantities = {
        "p_a": 5e4,
        "p_b": 5e4,
        "angle": np.radians(1.0),
        "spool": 1e-4,
        "voltage": 0.05,
        "q_in": 1e-4,
        "q_out": 1e-4,
    }
    for factor in (1.0, 0.1):
        steps = {n: factor * quantities[n.split(".")[1]] for n in log.names if "." in n}
        coarse = Table({**log.columns, **{n: np.round(log[n] / s) * s for n, s in steps.items()}}, log.units)
        assert without_stuck(true, coarse).texts == []
    without_noise = changed(log, boom_voltage=np.where(log["time"] < 60.0, 0.0, np.round(log["boom.voltage"], 1)))
    assert without_stuck(true, without_noise).texts == []


def test_rows_at_the_end_of_a_range_are_left_out(true, log):
    found = without_stuck(true, changed(log, boom_p_b=np.minimum(log["boom.p_b"], 1.5e7)))
    assert np.array_equal(found.table.known(["boom.p_b"]), log["boom.p_b"] < 1.5e7)
    assert len(found.table.whole(["boom.p_a"])) == len(log)
    [text] = found.texts
    assert text.startswith("boom.p_b reads 150 bar, the end of its range, in ")
    assert text.endswith("% of the rows: not used there")


def test_an_end_at_which_a_signal_may_stay_is_not_told_besides_the_other_one(true, log):
    flow = np.minimum(np.abs(log["boom.q_in"]), 0.7 * log["boom.q_in"].max())
    flow[0] = 0.0  # the smallest value
    [text] = without_stuck(true, changed(log, boom_q_in=flow)).texts
    assert text.count("the end of its range") == 1
    assert text.startswith(f"boom.q_in reads {amount(flow.max(), 'm3/s')}, the end of its range")


@pytest.mark.parametrize("name", ["boom.p_a", "boom.q_in", "boom.spool", "boom.voltage", "boom.angle"])
def test_rows_of_a_sensor_that_has_stopped_are_left_out(true, log, name):
    inside = (log["time"] > 50.0) & (log["time"] < 70.0)
    values = np.where(inside, log[name][np.argmax(inside)], log[name])
    found = without_stuck(true, changed(log, **{name.replace(".", "_", 1): values}))
    assert not found.table.known([name])[inside].any()
    assert found.table.known([name]).sum() == pytest.approx(len(log) - inside.sum(), abs=2)
    assert len(found.texts) == 1
    assert f"{name} stays at " in found.texts[0]
    assert "for 20 s: not used there" in found.texts[0]


def test_a_sensor_that_says_nothing_most_of_the_time_is_not_used(true, log):
    found = without_stuck(true, changed(log, boom_q_out=np.where(log["time"] > 40.0, 1e-3, log["boom.q_out"])))
    assert len(found.table) == len(log)
    assert "boom.q_out" not in found.table.names
    assert found.texts[0].endswith("the sensor is not used")
