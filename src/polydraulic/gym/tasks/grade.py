"""Grade: draw the tip along a level line at a given height, as fast as the line's mark moves."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from polydraulic.gym.motion import Motion
from polydraulic.gym.tasks.reach import TO_GOAL, seen_from_arm
from polydraulic.gym.tasks.task import GymTask, Judged, Number, State, chosen
from polydraulic.gym.workspace import Workspace
from polydraulic.machine.reach.tip import to_arm

WAIT = 0.5  # s before the mark moves
ACROSS, ALONG = 0.1, 0.25  # m off the line, and m before or behind the mark, that cost what a second brings
LEAST = -2.0  # reward of a second
STRAIGHT, AT_END = 0.1, 0.2  # m: rms error across the line, and distance from its end, of a pass that is well done
SEEN = (
    *TO_GOAL,
    Number("mark.out", "m/s", 1.0, "speed of the mark, outward in the plane of the arm"),
    Number("line.left", "m", 10.0, "way that the mark has before it"),
)


def grade_task() -> GymTask:
    """Build the task."""
    return GymTask("Grade", 1, SEEN, True, False, (), _begin, _aim, _observe, _judge)


def _begin(workspace: Workspace, draws: np.ndarray, options: Mapping[str, Any]) -> tuple[np.ndarray, State]:
    start = chosen(draws[0], len(workspace.starts))
    lines = workspace.lines
    if lines is None:
        raise ValueError("the workspace was found without lines")
    first, last = lines.first[start].T, lines.last[start].T
    length = np.sqrt(((last - first) ** 2).sum(axis=0))
    speed, (time, square, steps) = lines.speed[start], np.zeros((3, len(start)))
    way = (last - first) / length
    return start, {
        "first": first,
        "way": way,
        "length": length,
        "speed": speed,
        "time": time,
        "square": square,
        "steps": steps,
    }


def _marked(state: State) -> np.ndarray:
    """How far the mark has come, (n,) m."""
    return np.clip(state["speed"] * (state["time"] - WAIT), 0.0, state["length"])


def _aim(state: State) -> np.ndarray:
    return np.asarray(state["first"] + state["way"] * _marked(state))


def _observe(workspace: Workspace, state: State, motion: Motion) -> list[np.ndarray]:
    moving = (state["time"] >= WAIT) & (_marked(state) < state["length"])
    speed = to_arm(workspace.slews * motion.position[0], state["way"] * state["speed"] * moving)
    return [seen_from_arm(workspace, motion, _aim(state)), speed[:1], (state["length"] - _marked(state))[None]]


def _judge(state: State, before: Motion, now: Motion, levers: np.ndarray, period: float) -> Judged:
    state["time"] += period
    apart = now.tip - _aim(state)
    along = (apart * state["way"]).sum(axis=0)
    across = np.sqrt(np.maximum((apart * apart).sum(axis=0) - along * along, 0.0))
    state["square"] += across * across
    state["steps"] += 1.0
    rms = np.sqrt(state["square"] / state["steps"])
    over = _marked(state) >= state["length"]
    success = over & (rms < STRAIGHT) & (np.abs(along) < AT_END)
    reward = period * np.maximum(1.0 - across / ACROSS - np.abs(along) / ALONG, LEAST)
    return Judged(reward, success, over, {"across": across, "along": along, "across_rms": rms})
