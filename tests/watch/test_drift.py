"""A sensor's error that came at once, and one that grows."""

import numpy as np
import pytest

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.drift import course_of, course_so_far, with_course
from polydraulic.watch.kernels.evidence import KEPT
from polydraulic.watch.watch import FaultWatch

KNOWN = 20.0  # information of a block


def pulled(amounts, seed=1):
    """Pull and information of blocks in which an error of these amounts is seen."""
    noise = np.random.default_rng(seed).normal(0.0, np.sqrt(KNOWN), len(amounts))
    return KNOWN * amounts + noise, np.full(len(amounts), KNOWN)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_what_came_at_once_is_told_from_what_grows(sign):
    at = np.arange(200.0)
    step = course_of(*pulled(sign * (at >= 130.0)), 1.0)
    assert step.grows < 0.01
    ramp = course_of(*pulled(sign * 0.8 * np.clip((at - 40.0) / 160.0, 0.0, 1.0)), 1.0)
    assert ramp.grows > 0.99
    assert ramp.size == pytest.approx(sign * 0.8, abs=3.0 * ramp.error)
    assert 0.0 < ramp.error < 0.1


def test_few_blocks_that_say_little_leave_it_open():
    pull, information = pulled(np.full(6, 0.7))
    assert 0.05 < course_of(0.05 * pull, 0.05 * information, 1.0).grows < 0.95


def test_no_block_that_says_anything_leaves_it_open():
    assert course_of(np.zeros(10), np.zeros(10), 1.0).grows == pytest.approx(0.5)


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
    assert course_so_far(suspects, of.directions, watch.judge_parts, None) is None
    assert course_so_far((), of.directions, watch.judge_parts, None) is None
    assert with_course(suspects, of.directions, None) == suspects
    assert with_course((), of.directions, None) == ()
