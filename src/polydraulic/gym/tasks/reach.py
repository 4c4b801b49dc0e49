"""Reach: bring the tip to a place in space, and hold it there."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from polydraulic.gym.motion import Motion
from polydraulic.gym.tasks.task import (
    SLOW,
    GymTask,
    Judged,
    Number,
    State,
    asked_places,
    chosen,
    distance,
    effort,
    tip_speed,
)
from polydraulic.gym.workspace import Workspace
from polydraulic.machine.reach.tip import to_arm

NEARBY = 0.15  # m, which counts as there
TIME_COST, EFFORT_COST, DONE = 0.1, 0.05, 1.0  # 1/s; 1/s of the mean square of full levers; once
TO_GOAL = tuple(
    Number(f"goal.{axis}", "m", 50.0, f"from the tip to the goal, {words}")
    for axis, words in (("out", "outward in the plane of the arm"), ("left", "to its left"), ("up", "upward"))
)


def reach_task() -> GymTask:
    """Build the task."""
    return GymTask("Reach", 2, TO_GOAL, False, False, ("target",), _begin, _aim, _observe, _judge)


def _begin(workspace: Workspace, draws: np.ndarray, options: Mapping[str, Any]) -> tuple[np.ndarray, State]:
    start = chosen(draws[0], len(workspace.starts))
    goal = asked_places(workspace, options, "target", workspace.tips[chosen(draws[1], len(workspace.tips))].T)
    return start, {"goal": goal}


def _aim(state: State) -> np.ndarray:
    return state["goal"]


def _observe(workspace: Workspace, state: State, motion: Motion) -> list[np.ndarray]:
    return [seen_from_arm(workspace, motion, state["goal"])]


def seen_from_arm(workspace: Workspace, motion: Motion, place: np.ndarray) -> np.ndarray:
    """From the tip to a place (3, n), along the axes of the arm, (3, n) m."""
    return to_arm(workspace.slews * motion.position[0], place - motion.tip)


def _judge(state: State, before: Motion, now: Motion, levers: np.ndarray, period: float) -> Judged:
    left = distance(state["goal"], now)
    success = (left < NEARBY) & (tip_speed(before, now, period) < SLOW)
    reward = distance(state["goal"], before) - left - spent(levers, period) + DONE * success
    return Judged(reward, success, success, {"distance": left})


def spent(levers: np.ndarray, period: float) -> np.ndarray:
    """What a step costs: its time, and how far levers stand from their centres, (n,)."""
    return period * (TIME_COST + EFFORT_COST * effort(levers))
