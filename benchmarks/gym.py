"""Environments side by side: steps a second and core, and what share of them the simulator takes.

``python benchmarks/gym.py [MACHINE ...]``; Reach, one thread, processor time. Levers change with every call. The simulator alone is moved by the
same levers as often. One machine is both a single environment, and one of its own side by side. Compilation is not in it.
"""

import sys
import time

import gymnasium
import numpy as np

import polydraulic.gym  # noqa: F401
from polydraulic.thesis.timing import paired_times
from show import table

MACHINES, PERIODS, LANES = ("wheel_loader", "excavator_22t"), (0.01, 0.05), (1, 64, 4096)
CALLS = {1: 1000, 64: 500, 4096: 50}


def calls_of(env, n):
    """Calls of the environment, and of its simulator alone."""
    one, inner, within = env.unwrapped, env.unwrapped._simulator, env.unwrapped._given.steps
    shape = (CALLS[n], *one.action_space.shape)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, shape).astype(np.float32)
    volts = actions * one.workspace.full

    def whole():
        one.reset(seed=0)
        return sum(np.sum(one.step(action)[1]) for action in actions)

    def alone():
        one.reset(seed=0)
        for volt in volts:
            inner.step(volt, within)
        return np.sum(inner["effector.x"])

    def begun():
        return np.sum(one.reset(seed=0)[0])

    return {"whole": whole, "alone": alone, "begun": begun}


def main():
    begun = time.perf_counter()
    for machine in sys.argv[1:] or MACHINES:
        rows = []
        for period in PERIODS:
            for n in (None, *LANES):
                options = {"machine": machine, "period": period, "max_episode_steps": 10**6}
                name = "polydraulic/Reach-v0"
                env = gymnasium.make(name, **options) if n is None else gymnasium.make_vec(name, num_envs=n, **options)
                found = paired_times(calls_of(env, n or 1), clock=time.process_time)
                whole, alone = (found[key][0] - found["begun"][0] for key in ("whole", "alone"))
                steps = CALLS[n or 1] * (n or 1)
                rows.append(
                    [
                        f"{1e3 * period:.0f}",
                        "single" if n is None else str(n),
                        f"{1e6 * whole / CALLS[n or 1]:.0f}",
                        f"{steps / whole:.0f}",
                        f"{100.0 * alone / whole:.0f}",
                    ]
                )
                env.close()
        header = ["period, ms", "machines", "a call, us", "environment steps a second and core", "simulator, %"]
        table(f"{machine}: Reach", header, rows)
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
