"""Reach: goals are places that the tip reaches; a step is worth the way that it brings, less what it costs."""

import numpy as np
import pytest

from helpers.workspace_made import motion_at, workspace_made
from polydraulic import InputError
from polydraulic.gym.tasks.reach import DONE, EFFORT_COST, NEARBY, TIME_COST, reach_task
from polydraulic.gym.tasks.task import SLOW

TASK, WORK, PERIOD = reach_task(), workspace_made(), 0.05


def begun(n=3, options=None):
    return TASK.begin(WORK, np.full((TASK.draws, n), 0.3), options or {})


def test_goals_are_drawn_among_places_that_are_reached():
    draws = np.random.default_rng(0).random((TASK.draws, 50))
    start, state = TASK.begin(WORK, draws, {})
    assert set(start) == {0, 1}
    assert {tuple(goal) for goal in state["goal"].T} == {tuple(tip) for tip in WORK.tips}
    assert TASK.begin(WORK, np.full((2, 1), np.nextafter(1.0, 0.0)), {})[0] == [1]


def test_goals_that_are_asked_for():
    _, state = begun(options={"target": [5.0, 1.0, 2.05]})
    assert np.array_equal(TASK.aim(state), np.tile([[5.0], [1.0], [2.05]], 3))
    each = [[6.0, 0.0, 1.0], [5.0, 1.0, 2.0], [4.0, 0.0, -1.0]]
    assert np.array_equal(begun(options={"target": each})[1]["goal"].T, each)


@pytest.mark.parametrize(
    ("target", "said"),
    [
        ([50.0, 0.0, 0.0], "does not get there"),
        ([1.0, 2.0], "must be x, y and z"),
        ([1.0, 2.0, float("nan")], "must be x, y and z"),
        ("there", "must be x, y and z"),
        ([[6.0, 0.0, 1.0]] * 2, "must be x, y and z"),
    ],
)
def test_goals_that_cannot_be_used_are_named(target, said):
    with pytest.raises(InputError, match=said):
        begun(options={"target": target})


def test_a_step_is_worth_its_way_less_its_cost():
    _, state = begun(2, {"target": [6.0, 0.0, 1.0]})
    before, now = motion_at([4.0, 0.0, 1.0], [4.0, 0.0, 1.0]), motion_at([4.5, 0.0, 1.0], [3.0, 0.0, 1.0])
    levers = np.array([[0.0, 1.0], [0.0, 1.0], [0.0, -1.0]])
    judged = TASK.judge(state, before, now, levers, PERIOD)
    assert np.allclose(judged.reward, [0.5 - PERIOD * TIME_COST, -1.0 - PERIOD * (TIME_COST + EFFORT_COST)])
    assert np.allclose(judged.told["distance"], [1.5, 3.0])
    assert not judged.over.any()


def test_there_is_only_who_is_near_and_slow():
    _, state = begun(3, {"target": [6.0, 0.0, 1.0]})
    near, slow, fast = 6.0 - 0.9 * NEARBY, 0.9 * SLOW * PERIOD, 1.1 * SLOW * PERIOD
    before = motion_at([near - slow, 0.0, 1.0], [near - fast, 0.0, 1.0], [6.0 - 1.1 * NEARBY, 0.0, 1.0])
    now = motion_at([near, 0.0, 1.0], [near, 0.0, 1.0], [6.0 - 1.1 * NEARBY, 0.0, 1.0])
    judged = TASK.judge(state, before, now, np.zeros((3, 3)), PERIOD)
    assert judged.success.tolist() == judged.over.tolist() == [True, False, False]
    assert judged.reward[0] == pytest.approx(slow - PERIOD * TIME_COST + DONE)


def test_the_goal_is_seen_from_the_arm():
    _, state = begun(1, {"target": [5.0, 1.0, 2.0]})
    (seen,) = TASK.observe(WORK, state, motion_at([4.0, 1.0, 1.0], heading=0.5 * np.pi))
    assert np.allclose(seen[:, 0], [0.0, -1.0, 1.0])  # ahead along x is to the right of an arm that points along y
