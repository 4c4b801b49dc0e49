"""Alarms of a sensor's error that came at once, and of one that grows."""

import pytest

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.drift import with_course
from polydraulic.watch.kernels.evidence import KEPT
from polydraulic.watch.watch import FaultWatch


@pytest.mark.parametrize(
    ("fault", "named", "other"),
    [
        ("tilt.voltage.drift 4 % from 20 s over 200 s", "tilt.voltage.drift", "tilt.voltage.bias"),
        ("tilt.voltage.bias from 60 s", "tilt.voltage.bias", "tilt.voltage.drift"),
    ],
)
def test_a_drift_is_named_as_what_it_is_and_a_bias_too(fault, named, other):
    of, expected = known()
    watch = FaultWatch(of, expected)
    watch.judge(*blocks(of, log_of(of.machine, 26, 160.0, [fault])))
    (alarm,) = watch.alarms
    assert alarm.suspects[0].name == named
    assert sum(s.probability for s in alarm.suspects if s.name in (named, other)) > 0.9
    assert alarm.suspects[0].size == pytest.approx(0.028 if "drift" in named else 0.02, rel=0.3)


def test_a_drift_whose_beginning_is_no_longer_kept_keeps_its_name():
    of, expected = known()
    watch = FaultWatch(of, expected)
    found = {}

    def keep():
        found[watch.blocks] = watch.alarms[-1].suspects[0] if watch.alarms else None

    watch.judge(*blocks(of, log_of(of.machine, 26, 960.0, ["tilt.voltage.drift 8 % from 20 s over 800 s"])), keep)
    assert len(watch.alarms) == 1
    assert {suspect.name for blocks, suspect in found.items() if blocks > 160} == {"tilt.voltage.drift"}
    assert "by now" in found[KEPT].title
    assert watch.blocks > KEPT + 300
    assert "in the first minutes of the alarm" in found[watch.blocks].title
    assert found[watch.blocks].size == found[KEPT].size


def test_suspects_that_are_no_errors_of_sensors_stay_as_they_are():
    of, expected = known()
    watch = FaultWatch(of, expected)
    watch.judge(*blocks(of, log_of(of.machine, 22, 60.0, ["work.pump_worn from 20 s"])))
    suspects = watch.alarms[0].suspects
    assert watch.judge_parts.course is None
    assert with_course(suspects, of.directions, None) == suspects
    assert with_course((), of.directions, None) == ()
