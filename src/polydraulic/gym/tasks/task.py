"""What a task is: how an episode begins, what is to be seen of it, and how a step is judged. All of many machines side by side, a column each."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.gym.motion import Motion
from polydraulic.gym.workspace import Workspace

State = dict[str, np.ndarray]  # what a task remembers of an episode, (..., n) by name
NEAR = 0.03  # of the largest reach, between a place that is asked for and the nearest that is known to be reached
SLOW = 0.25  # m/s, of a tip that is to be somewhere


class Number(NamedTuple):
    """A number of an observation; what is beyond `limit`, to either side, is shown as that."""

    name: str
    unit: str
    limit: float
    means: str


class Judged(NamedTuple):
    """A step of n machines.

    Attributes
    ----------
    reward : (n,) array
    success, over : (n,) arrays of bool
        Whether the task is done; whether the episode ends, done or not.
    told : mapping from name to (n,) array
        What `info` says.
    """

    reward: np.ndarray
    success: np.ndarray
    over: np.ndarray
    told: dict[str, np.ndarray]


class GymTask(NamedTuple):
    """A task.

    Attributes
    ----------
    name : str
    draws : int
        Uniform numbers that an episode begins with.
    seen : tuple of Number
        What is seen of it beside the machine.
    lines, carries : bool
        Whether it needs lines to follow, and a payload at the tip.
    options : tuple of str
        What `reset` may be told.
    begin : function (workspace, draws (n_draw, n), options) -> (which starts (n,), state)
    aim : function (state) -> (3, n) array, m
        Where the tip should be now.
    observe : function (workspace, state, motion) -> list of rows (n,) or (k, n), one number for each of `seen`
    judge : function (state, before, now, levers (n_function, n), period) -> Judged
        Changes the state to that after the step.
    carried : function (state) -> (n,) array, kg, or None
        What hangs at the tip.
    """

    name: str
    draws: int
    seen: tuple[Number, ...]
    lines: bool
    carries: bool
    options: tuple[str, ...]
    begin: Callable[[Workspace, np.ndarray, Mapping[str, Any]], tuple[np.ndarray, State]]
    aim: Callable[[State], np.ndarray]
    observe: Callable[[Workspace, State, Motion], list[np.ndarray]]
    judge: Callable[[State, Motion, Motion, np.ndarray, float], Judged]
    carried: Callable[[State], np.ndarray] | None = None


def chosen(draw: np.ndarray, n: int) -> np.ndarray:
    """Which of n things uniform numbers mean."""
    return np.minimum((draw * n).astype(np.int64), n - 1)


def effort(levers: np.ndarray) -> np.ndarray:
    """Mean square of all levers, (n,)."""
    return np.asarray((levers * levers).mean(axis=0))


def distance(place: np.ndarray, motion: Motion) -> np.ndarray:
    """From the tip to a place (3, n), (n,) m."""
    return np.sqrt(((place - motion.tip) ** 2).sum(axis=0))


def tip_speed(before: Motion, now: Motion, period: float) -> np.ndarray:
    """Of the tip in a step, (n,) m/s."""
    return distance(before.tip, now) / period


def asked_places(workspace: Workspace, options: Mapping[str, Any], name: str, drawn: np.ndarray) -> np.ndarray:
    """Places that are asked for, else those that were drawn, (3, n) m.

    Raises
    ------
    InputError
        What is no place, or one that the machine does not reach.
    """
    if name not in options:
        return drawn
    try:
        given = np.asarray(options[name], dtype=np.float64)
    except (TypeError, ValueError):
        given = np.full(1, np.nan)
    n = drawn.shape[1]
    if given.shape not in ((3,), (n, 3)) or not np.isfinite(given).all():
        raise InputError(f"options: {name} = {briefly(options[name])}: must be x, y and z in m, or ({n}, 3) of them")
    far = _beyond(workspace, np.atleast_2d(given))
    if far.any():
        low, high = workspace.tips.min(axis=0), workspace.tips.max(axis=0)
        raise InputError(
            f"options: {name} = {np.atleast_2d(given)[far][0].tolist()} m: the tip of {workspace.machine.title!r} does not get there; "
            f"it reaches x, y, z from {np.round(low, 2).tolist()} to {np.round(high, 2).tolist()} m"
        )
    return np.array(np.broadcast_to(given.T if given.ndim == 2 else given[:, None], (3, n)))


def _beyond(workspace: Workspace, places: np.ndarray) -> np.ndarray:
    """Which of places (n, 3) are far from all that the tip is known to reach."""
    from scipy.spatial import KDTree

    apart, _ = KDTree(workspace.tips).query(places)
    return np.asarray(apart > NEAR * np.linalg.norm(workspace.tips, axis=1).max())
