"""What is said of channels that contradict each other, by all who read a log of a machine."""

import pytest

from helpers.machine_log import changed
from polydraulic import InputError
from polydraulic.identification import identify, replay, watch_log
from polydraulic.identification.doubts.channels import channel_doubts
from polydraulic.tables import Table


@pytest.fixture(scope="module")
def turned(log):
    return changed(log, boom_angle=-log["boom.angle"])


def test_pressures_are_not_judged_by_positions_that_are_wrong(true, turned, log):
    assert channel_doubts(true, log) == []
    [doubt] = channel_doubts(true, turned)
    assert doubt.columns == ("boom.angle",)
    assert "boom.angle goes against boom.spool" in doubt.text


def test_a_log_whose_times_do_not_rise_is_left_to_others(true, turned):
    back = Table({**turned.columns, "time": turned["time"][::-1].copy()}, {})
    assert channel_doubts(true, back) == []


def test_identify_uses_no_channel_that_is_in_doubt(true, turned, log):
    swapped = changed(log, boom_p_a=log["boom.p_b"], boom_p_b=log["boom.p_a"])
    found = identify(swapped, true, free=["functions.*.pilot.*"])
    assert [line for line in found.kept if line.startswith("not used: boom.p_a, boom.p_b; torques of the oil")]
    assert not {"boom.p_a", "boom.p_b"} & set(found.table.names)
    assert found.pilots.keys() == {"swing", "boom", "stick"}
    with pytest.raises(InputError, match="nothing of this machine; .*the log has no boom.voltage, .*wrong sign"):
        keep = [n for n in log.names if n == "time" or n.endswith((".voltage", ".angle"))]
        levers = Table({n: -log[n] if n == "boom.voltage" else log[n] for n in keep}, log.units)
        identify(levers, true, free=["functions.*.pilot.gain"])


def test_replay_and_watch_say_what_contradicts_what(true, turned, log):
    run = replay(turned, true, "iterative", seconds=50.0)
    assert "warning: boom.angle goes against boom.spool in " in run.text()
    assert not [text for text in replay(log, true, "iterative", seconds=50.0).doubts if "boom.angle" in text]
    few = ["*.voltage", "*.spool", "*.angle"]
    watched = watch_log(log, true, healthy=turned, sensors=few)
    assert "\nwarning: table: boom.angle goes against boom.spool in " in watched.text()
    assert watched.faulty
    assert not watch_log(turned, true, healthy=log, sensors=few[:2]).doubts  # what is not watched by is not looked at
