"""Grade: a mark moves along a level line; a step is worth its time if the tip is on the mark, and less beside it."""

import numpy as np
import pytest

from helpers.workspace_made import motion_at, workspace_made
from polydraulic.gym.tasks.grade import ACROSS, ALONG, AT_END, LEAST, STRAIGHT, WAIT, grade_task

TASK, WORK, PERIOD = grade_task(), workspace_made(), 0.05
NO_LEVERS = np.zeros((3, 1))
STEPS = round((WAIT + 1.0 / 0.2) / PERIOD)  # that the mark needs for its line of 1 m


def passed(tip_of):
    """Judge a whole pass: tips by the mark's place."""
    _, state = TASK.begin(WORK, np.zeros((1, 1)), {})
    found = []
    for k in range(STEPS + 1):
        time = (k + 1) * PERIOD
        mark = np.array([6.0 - np.clip(0.2 * (time - WAIT), 0.0, 1.0), 0.0, 1.0])
        now = motion_at(tip_of(mark))
        found.append(TASK.judge(state, now, now, NO_LEVERS, PERIOD))
        assert np.allclose(TASK.aim(state)[:, 0], mark)
        if found[-1].over[0]:
            break
    return found


def test_a_perfect_pass_is_worth_its_time():
    steps = passed(lambda mark: mark)
    assert len(steps) in (STEPS, STEPS + 1)  # times are sums of periods
    assert sum(step.reward[0] for step in steps) == pytest.approx(len(steps) * PERIOD)
    assert [step.success[0] for step in steps] == [False] * (len(steps) - 1) + [True]


@pytest.mark.parametrize(
    ("off", "reward", "good"),
    [
        ([0.0, 0.0, 0.5 * ACROSS], 0.5, True),
        ([0.0, 0.0, -1.1 * STRAIGHT], 1.0 - 1.1 * STRAIGHT / ACROSS, False),
        ([0.0, 0.5 * ACROSS, 0.0], 0.5, True),
        ([1.1 * AT_END, 0.0, 0.0], 1.0 - 1.1 * AT_END / ALONG, False),
        ([0.0, 0.0, 9.0], LEAST, False),
    ],
)
def test_beside_the_line_and_behind_the_mark_it_is_worth_less(off, reward, good):
    steps = passed(lambda mark: mark + off)
    assert all(step.reward[0] == pytest.approx(reward * PERIOD) for step in steps)
    assert steps[-1].over[0]
    assert steps[-1].success[0] == good


def test_who_rests_where_the_line_begins_loses():
    assert sum(step.reward[0] for step in passed(lambda mark: np.array([6.0, 0.0, 1.0]))) < -1.0


def test_the_mark_is_seen_with_its_speed_and_the_way_left():
    _, state = TASK.begin(WORK, np.zeros((1, 1)), {})
    still = TASK.observe(WORK, state, motion_at([6.0, 0.0, 1.0]))
    assert [part[:, 0].tolist() for part in still[1:]] == [[0.0], [1.0]]
    state["time"][:] = WAIT + 1.0
    to_mark, speed, left = TASK.observe(WORK, state, motion_at([6.0, 0.0, 1.0]))
    assert np.allclose(to_mark[:, 0], [-0.2, 0.0, 0.0])
    assert (speed[0, 0], left[0, 0]) == pytest.approx((-0.2, 0.8))
