"""PickPlace: the load is fetched at the lower place, then hangs at the tip until it is put down at the other."""

import numpy as np

from helpers.workspace_made import motion_at, workspace_made
from polydraulic.gym.tasks.pick_place import pick_place_task
from polydraulic.gym.tasks.reach import DONE, TIME_COST

TASK, WORK, PERIOD = pick_place_task(200.0), workspace_made(), 0.05
PICK, PLACE, FAR = [4.0, 0.0, -1.0], [5.0, 1.0, 2.0], [6.0, 0.0, 1.0]


def judge(state, *tips):
    now = motion_at(*tips)
    return TASK.judge(state, now, now, np.zeros((3, len(tips))), PERIOD)


def test_the_lower_place_comes_first():
    _, state = TASK.begin(WORK, np.random.default_rng(0).random((3, 60)), {})
    assert np.all(TASK.aim(state)[2] <= state["place"][2])
    assert len({tuple(goal) for goal in TASK.aim(state).T}) > 1


def test_a_load_is_fetched_carried_and_put_down():
    options = {"pick": PICK, "place": PLACE}
    _, state = TASK.begin(WORK, np.zeros((3, 3)), options)
    assert np.array_equal(TASK.carried(state), np.zeros(3))
    judged = judge(state, PICK, PLACE, FAR)  # the second is where the load is to go, and has none yet
    assert judged.told["loaded"].tolist() == [True, False, False]
    assert not judged.over.any()
    assert np.allclose(judged.reward, np.array([DONE, 0.0, 0.0]) - PERIOD * TIME_COST)
    assert np.array_equal(TASK.carried(state), [200.0, 0.0, 0.0])
    assert np.array_equal(TASK.aim(state).T, [PLACE, PICK, PICK])
    judged = judge(state, PICK, PICK, FAR)
    assert judged.told["loaded"].tolist() == [True, True, False]
    assert not judged.over.any()
    judged = judge(state, PLACE, PICK, FAR)
    assert judged.success.tolist() == judged.over.tolist() == [True, False, False]
    assert judged.reward[0] == DONE - PERIOD * TIME_COST


def test_both_places_and_the_load_are_seen():
    _, state = TASK.begin(WORK, np.zeros((3, 1)), {"pick": PICK, "place": PLACE})
    seen = np.concatenate(TASK.observe(WORK, state, motion_at(FAR)))[:, 0]
    assert np.allclose(seen, [-2.0, 0.0, -2.0, -1.0, 1.0, 1.0, 0.0])
    judge(state, PICK)
    seen = np.concatenate(TASK.observe(WORK, state, motion_at(FAR)))[:, 0]
    assert np.allclose(seen, [-1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
