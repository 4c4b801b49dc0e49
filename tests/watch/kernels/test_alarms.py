"""Alarms of sensors that stay, with no test beyond its threshold: that they stay is all that is known."""

import numpy as np
import pytest

from helpers.watched_logs import known
from polydraulic.watch.kernels.alarms import ALONE, BEGINS, GOES_ON, NONE, decide
from polydraulic.watch.kernels.numbers import SEEN, SINCE
from polydraulic.watch.kernels.stays import FLAT, MOVES, RESTS
from polydraulic.watch.watch import FaultWatch


@pytest.fixture
def judge():
    of, expected = known()
    return FaultWatch(of, expected).judge_parts


def means(judge, k, state):
    """What a block that begins at k s means, in which a sensor has a state; the machine does as it should, and the others move."""
    judge.rows[judge.plan.shape.before, 0] = float(k)
    judge.states[:] = MOVES
    judge.states[2] = state
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
