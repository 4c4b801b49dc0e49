"""What an environment shows of machine and task: which numbers, in which order and unit."""

from collections.abc import Sequence

import numpy as np

from polydraulic.gym.motion import Motion
from polydraulic.gym.tasks.task import GymTask, Number, State
from polydraulic.gym.workspace import Workspace


def numbers_seen(workspace: Workspace, task: GymTask) -> list[Number]:
    """Numbers of an observation, in their order."""
    found = []
    for f, turns in zip(workspace.machine.functions, workspace.travels.turns, strict=True):
        slides = workspace.machine.link(f.moves).joint == "prismatic"
        if not turns:
            found.append(Number(f"{f.name}.travel", "1", 1.5, "place of the joint between its stops, -1 to 1"))
        found.append(
            Number(f"{f.name}.{'speed' if slides else 'rate'}", "m/s" if slides else "rad/s", 10.0, "of the joint")
        )
        found.append(Number(f"{f.name}.spool", "1", 1.5, "share of the spool's full travel, -1 to 1"))
        found.append(
            Number(f"{f.name}.load", "1", 5.0, "pressure at A less that at B, in shares of the line's relief pressure")
        )
    return [*found, *task.seen]


def limits_seen(numbers: Sequence[Number]) -> np.ndarray:
    """Limits of an observation, (n_number,) of float32."""
    return np.array([number.limit for number in numbers], dtype=np.float32)


def observation(workspace: Workspace, task: GymTask, state: State, motion: Motion, limits: np.ndarray) -> np.ndarray:
    """Observations of n machines within `limits_seen`, (n, n_number) of float32."""
    low, high = workspace.travels.low[:, None], workspace.travels.high[:, None]
    travel = (2.0 * motion.position - low - high) / (high - low)
    spool = motion.spool / workspace.spool[:, None]
    load = (motion.p_a - motion.p_b) / workspace.relief[:, None]
    rows: list[np.ndarray] = []
    for j, turns in enumerate(workspace.travels.turns):
        rows += [motion.rate[j], spool[j], load[j]] if turns else [travel[j], motion.rate[j], spool[j], load[j]]
    found = np.empty((len(limits), motion.tip.shape[1]), dtype=np.float32)
    found[: len(rows)] = rows
    at = len(rows)
    for part in task.observe(workspace, state, motion):
        found[at : at + len(part)] = part
        at += len(part)
    np.clip(found, -limits[:, None], limits[:, None], out=found)
    return np.ascontiguousarray(found.T)
