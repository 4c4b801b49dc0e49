"""A policy that needs no learning: the tip is drawn to its goal through the inverse Jacobian. What a learner should come up to."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from polydraulic.gym.machine_env import MachineEnv
from polydraulic.gym.machine_vector_env import MachineVectorEnv
from polydraulic.gym.workspace import Workspace
from polydraulic.machine.reach.tip import joint_speeds, tip_jacobian

_PULL, _FASTEST = 1.5, 1.5  # 1/s, speed of the tip for its distance; m/s
_LEAD = 0.3  # s, by which levers lead the tip
_CREEP = 0.01  # of full speed, below which a lever stays centred
_AT_STOP = 0.97  # of the travel


def follow_goal(env: MachineEnv | MachineVectorEnv) -> Callable[[np.ndarray], np.ndarray]:
    """Build a policy: observations of the environment to levers.

    It knows the machine's links, how far each valve must open before its pump carries the load, and that a stroke takes some 5 s; not how pumps
    share their flow.

    Parameters
    ----------
    env : MachineEnv or MachineVectorEnv
        Of any task.

    Returns
    -------
    function
        From (n_number,) or (n, n_number) to (n_function,) or (n, n_function), float32.
    """
    workspace, machine = env.workspace, env.workspace.machine
    place = {number.name: k for k, number in enumerate(env.numbers)}
    goal = [place[f"goal.{axis}"] for axis in ("out", "left", "up")]
    seen = [(j, place[f"{f}.travel"]) for j, f in enumerate(machine.names) if f"{f}.travel" in place]
    joints, columns = [j for j, _ in seen], [column for _, column in seen]
    _, low, high, turns, full = workspace.travels
    rest = np.where(turns & (np.arange(len(low)) == 0), 0.0, 0.5 * (low + high))  # seen from the arm, it has not turned
    rated = [place.get(f"{f}.rate", place.get(f"{f}.speed", 0)) for f in machine.names]
    openings, loads = _openings(workspace), [place[f"{f}.load"] for f in machine.names]

    def policy(observation: np.ndarray) -> np.ndarray:
        shown = np.atleast_2d(np.asarray(observation, dtype=np.float64))
        travel = np.zeros((len(shown), len(low)))
        travel[:, joints] = shown[:, columns]
        position = rest + travel * 0.5 * (high - low)
        jacobian = tip_jacobian(machine, position)
        moves, mark = (jacobian @ shown[:, rated, None])[..., 0], np.zeros((len(shown), 3))
        if "mark.out" in place:
            mark[:, 0] = shown[:, place["mark.out"]]
        wanted = mark + _PULL * (shown[:, goal] - _LEAD * (moves - mark))
        speed = np.linalg.norm(wanted, axis=1, keepdims=True)
        wanted *= np.minimum(1.0, _FASTEST / np.maximum(speed, 1e-9))
        rates = joint_speeds(jacobian, wanted, full)
        held = (np.abs(travel) > _AT_STOP) & (rates * travel > 0.0)
        share = joint_speeds(jacobian, wanted, np.where(held, 0.0, full)) / full
        against = np.where(turns, 0.0, np.sign(share) * shown[:, loads])
        begin = np.stack([opening.at(load) for opening, load in zip(openings, against.T, strict=True)], axis=1)
        levers = np.sign(share) * (begin + (1.0 - begin) * np.abs(share)) * (np.abs(share) > _CREEP)
        found = np.clip(levers, -1.0, 1.0).astype(np.float32)
        return found if np.ndim(observation) == 2 else found[0]

    return policy


class _Opening(NamedTuple):
    """Where a valve begins to feed its actuator."""

    deadband: float  # share of the travel up to which the inlet is shut
    knots: np.ndarray  # shares of the travel
    bypass: np.ndarray  # m3/s/Pa^0.5, falling
    flow: float  # of its pump, m3/s
    relief: float  # of its line, Pa

    def at(self, load: np.ndarray) -> np.ndarray:
        """Share of full lever at which the bypass holds up the pump's flow enough for a load, in shares of the relief pressure."""
        needed = self.flow / np.sqrt(np.maximum(load, 1e-6) * self.relief)
        return np.maximum(np.interp(-needed, -self.bypass, self.knots), self.deadband)


def _openings(workspace: Workspace) -> list[_Opening]:
    found, machine = [], workspace.machine
    for f in machine.functions:
        knots = np.array(f.valve.knots) / f.valve.knots[-1]
        shut = knots[np.array(f.valve.inlet) == 0.0]
        flow = next(c.pump.flow for c in machine.circuits if f.name in c.functions)
        bypass = np.minimum.accumulate(f.valve.bypass)
        found.append(_Opening(shut.max(initial=0.0), knots, bypass, flow, f.line.relief))
    return found
