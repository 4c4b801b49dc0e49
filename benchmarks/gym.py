"""Environments: steps a second and core, what share of them the simulator takes, and what simple policies make of every task.

``python benchmarks/gym.py [MACHINE ...]``. Speed is that of Reach with `FAST`, one thread, processor time; levers change with every call, and the
simulator alone is moved by the same levers as often. "single" is a `MachineEnv`, 1 a `MachineVectorEnv` of one machine. Policies play 64 episodes
of every task with every machine. Compilation is in none of it.
"""

import sys
import time

import gymnasium
import numpy as np

from polydraulic.gym import follow_goal
from polydraulic.gym.arguments import TASKS
from polydraulic.parameters.load import machine_names
from polydraulic.thesis.timing import paired_times
from show import table

FAST, PERIODS, LANES = "wheel_loader", (0.01, 0.05), (None, 1, 64, 4096)
CALLS = {None: 1000, 1: 1000, 64: 500, 4096: 50}
EPISODES = 64


def calls_of(env, n, period):
    """Calls of the environment, of its simulator alone, and what both begin with."""
    one, inner = env.unwrapped, env.unwrapped.simulator
    shape, within = (CALLS[n], *one.action_space.shape), round(period / inner.dt)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, shape).astype(np.float32)
    volts = actions * one.workspace.lever

    def whole():
        one.reset(seed=0)
        return sum(np.sum(one.step(action)[1]) for action in actions)

    def alone():
        one.reset(seed=0)
        for volt in volts:
            inner.step(volt, within)
        return np.sum(inner["effector.x"])

    return {"whole": whole, "alone": alone, "begun": lambda: np.sum(one.reset(seed=0)[0])}


def speed(period, n):
    """A row: what a call takes, steps a second, share of the simulator."""
    options = {"machine": FAST, "period": period, "max_episode_steps": 10**6}
    name = "polydraulic/Reach-v0"
    env = gymnasium.make(name, **options) if n is None else gymnasium.make_vec(name, num_envs=n, **options)
    found = paired_times(calls_of(env, n, period), clock=time.process_time, pairs=5)
    whole, alone = (found[key][0] - found["begun"][0] for key in ("whole", "alone"))
    env.close()
    each, rate = 1e6 * whole / CALLS[n], CALLS[n] * (n or 1) / whole
    kind = "single" if n is None else str(n)
    return [f"{1e3 * period:.0f}", kind, f"{each:.0f}", f"{rate / 1e3:.0f}", f"{100.0 * alone / whole:.0f}"]


def played(env, policy):
    """Mean return of each machine's first episode, and how many did the task, %."""
    seen, _ = env.reset(seed=0)
    total, success, going = np.zeros(EPISODES), np.zeros(EPISODES, dtype=bool), np.ones(EPISODES, dtype=bool)
    while going.any():
        seen, rewards, over, cut, infos = env.step(policy(seen))
        total += going * rewards
        success |= going & infos.get("is_success", False)
        going &= ~(over | cut)
    return f"{total.mean():.2f}", f"{100.0 * success.mean():.0f}"


def policies(task, machine):
    """A row: return and success of three policies."""
    env = gymnasium.make_vec(f"polydraulic/{task}-v0", num_envs=EPISODES, machine=machine)
    rng, shape = np.random.default_rng(0), env.action_space.shape
    known = played(env, follow_goal(env))
    chance = played(env, lambda seen: rng.uniform(-1.0, 1.0, shape))
    rest = played(env, lambda seen: np.zeros(shape))
    env.close()
    return [task, machine, *known, *chance, *rest]


def main():
    begun = time.perf_counter()
    header = ["period, ms", "machines", "a call, us", "thousand steps a second and core", "simulator, %"]
    table(f"Reach, {FAST}", header, [speed(period, n) for period in PERIODS for n in LANES])
    header = ["task", "machine", "inverse Jacobian", "done, %", "chance", "done, %", "rest", "done, %"]
    rows = (policies(task, machine) for task in TASKS for machine in sys.argv[1:] or machine_names())
    table("mean return and success", header, rows)
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
