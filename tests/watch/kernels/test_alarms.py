"""Alarms of sensors that stay, with no test beyond its threshold: that they stay is all that is known."""

import numpy as np
import pytest

from helpers.watched_logs import known
from polydraulic.watch.kernels.alarms import ALONE, BEGINS, GOES_ON, NONE, QUIET, decide
from polydraulic.watch.kernels.evidence import LEAST_BLOCKS
from polydraulic.watch.kernels.numbers import SEEN, SINCE
from polydraulic.watch.kernels.stays import FLAT, MOVES, RESTS
from polydraulic.watch.watch import FaultWatch

PUMP = "work.pump_worn"


@pytest.fixture
def judge():
    of, expected = known()
    return FaultWatch(of, expected).judge_parts


def means(judge, k, state, worn=0.0):
    """What a block that begins at k s means, in which a sensor has a state; the others move, and as much speaks for a worn pump."""
    judge.rows[judge.plan.shape.before, 0] = float(k)
    judge.states[:] = MOVES
    judge.states[2] = state
    pump = [d.name for d in judge.plan.directions].index(PUMP)
    judge.white_pull[pump] = judge.white_information[pump] = worn
    return decide(judge.numbers, judge.work, judge.live, judge.marks)


def test_a_sensor_that_stays_stays_since_it_did(judge):
    enough = ALONE * int(judge.numbers.limits[2])
    became = [means(judge, k, FLAT if k >= 7 else MOVES) for k in range(7 + enough + 2)]
    assert became == [NONE] * (6 + enough) + [BEGINS, GOES_ON, GOES_ON]
    assert judge.stuck == [2]
    assert judge.live[SINCE] == 7.0
    assert judge.live[SEEN] == pytest.approx(6.0 + enough + judge.plan.shape.seconds)


def test_blocks_in_which_a_function_rests_are_none_in_which_its_sensors_could_have_moved(judge):
    states = [FLAT, RESTS, MOVES, RESTS, RESTS]
    assert all(means(judge, k, state) == NONE for k, state in enumerate(states))
    assert judge.worked[2] == 2
    assert np.all(np.delete(judge.worked, 2) == len(states))


def test_a_sensor_stays_since_it_did_however_long_its_function_rested(judge):
    enough, rests = ALONE * int(judge.numbers.limits[2]), 40
    states = [MOVES] * 7 + [FLAT, FLAT] + [RESTS] * rests + [FLAT] * (enough - 2)
    assert [means(judge, k, state) for k, state in enumerate(states)][-2:] == [NONE, BEGINS]
    assert judge.live[SINCE] == 7.0


def test_of_a_sensor_that_stays_again_the_last_time_counts(judge):
    enough = ALONE * int(judge.numbers.limits[2])
    states = [FLAT] * 3 + [MOVES] * 2 + [FLAT] * enough
    assert [means(judge, k, state) for k, state in enumerate(states)][-1] == BEGINS
    assert judge.live[SINCE] == 5.0


def stays_first(judge):
    """A sensor that stays until that is an alarm; the number of blocks."""
    enough = ALONE * int(judge.numbers.limits[2])
    assert [means(judge, k, FLAT) for k in range(enough)][-1] == BEGINS
    assert judge.stuck == [2]
    return enough


def named(judge):
    return [judge.plan.directions[k].name for k in judge.listed[:1]]


def test_what_goes_on_when_a_sensor_moves_again_is_named(judge):
    begin = stays_first(judge)
    strong = judge.numbers.threshold
    for k in range(LEAST_BLOCKS):
        means(judge, begin + k, FLAT, strong)
    assert judge.stuck == [2]
    for k in range(1 + LEAST_BLOCKS):
        assert means(judge, begin + LEAST_BLOCKS + k, MOVES, strong) == GOES_ON
        assert judge.told == (k == LEAST_BLOCKS)
    assert judge.stuck == []
    assert named(judge) == [PUMP]
    assert judge.seen[0].max() == pytest.approx(LEAST_BLOCKS * strong)


def test_an_alarm_after_which_nothing_goes_on_keeps_its_sensor(judge):
    begin = stays_first(judge)
    for k in range(LEAST_BLOCKS):
        means(judge, begin + k, FLAT, judge.numbers.threshold)
    after = [means(judge, begin + LEAST_BLOCKS + k, MOVES) for k in range(QUIET)]
    assert judge.stuck == [2]
    assert after == [GOES_ON] * QUIET  # nothing is known of those blocks, and evidence stays what it was
