"""PickPlace: fetch a load at one place and put it down at another, as in the thesis' task (5.3.4)."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from polydraulic.gym.motion import Motion
from polydraulic.gym.tasks.reach import DONE, NEARBY, TO_GOAL, seen_from_arm, spent
from polydraulic.gym.tasks.task import SLOW, GymTask, Judged, Number, State, asked_places, chosen, distance, tip_speed
from polydraulic.gym.workspace import Workspace

SEEN = (
    *TO_GOAL,
    *(
        goal._replace(name=goal.name.replace("goal", "place"), means=goal.means.replace("goal", "place"))
        for goal in TO_GOAL
    ),
    Number("loaded", "1", 1.0, "whether the load hangs at the tip"),
)


def pick_place_task(load: float) -> GymTask:
    """Build the task with a load in kg."""

    def begin(workspace: Workspace, draws: np.ndarray, options: Mapping[str, Any]) -> tuple[np.ndarray, State]:
        return _begin(workspace, draws, options, load)

    return GymTask("PickPlace", 3, SEEN, False, True, ("pick", "place"), begin, _aim, _observe, _judge, _carried)


def _begin(
    workspace: Workspace, draws: np.ndarray, options: Mapping[str, Any], load: float
) -> tuple[np.ndarray, State]:
    one, other = (workspace.tips[chosen(draw, len(workspace.tips))].T for draw in draws[1:3])
    lower = one[2] <= other[2]
    pick = asked_places(workspace, options, "pick", np.where(lower, one, other))
    place = asked_places(workspace, options, "place", np.where(lower, other, one))
    n = draws.shape[1]
    mass = np.full(n, load)
    return chosen(draws[0], len(workspace.starts)), {
        "goal": pick.copy(),
        "place": place,
        "mass": mass,
        "loaded": np.zeros(n, dtype=bool),
    }


def _aim(state: State) -> np.ndarray:
    return state["goal"]


def _observe(workspace: Workspace, state: State, motion: Motion) -> list[np.ndarray]:
    to_goal, to_place = (seen_from_arm(workspace, motion, state[name]) for name in ("goal", "place"))
    return [to_goal, to_place, state["loaded"][None]]


def _judge(state: State, before: Motion, now: Motion, levers: np.ndarray, period: float) -> Judged:
    left = distance(state["goal"], now)
    there = (left < NEARBY) & (tip_speed(before, now, period) < SLOW)
    picked, success = there & ~state["loaded"], there & state["loaded"]
    reward = distance(state["goal"], before) - left - spent(levers, period) + DONE * there
    state["loaded"] |= picked
    np.copyto(state["goal"], state["place"], where=picked)
    return Judged(
        reward, success, success, {"distance": distance(state["goal"], now), "loaded": state["loaded"].copy()}
    )


def _carried(state: State) -> np.ndarray:
    return np.asarray(np.where(state["loaded"], state["mass"], 0.0))
