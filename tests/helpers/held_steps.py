"""Machines moved step by step by levers that stand still, one and many, held to the bits of runs."""

import pickle

import numpy as np

from helpers.held_levers import held_scenario, random_levers, random_split
from polydraulic import Simulator, simulate

DT = 5e-3
MANY = 70  # more than stand side by side
TIP = ("effector.x", "effector.y", "effector.z")  # compiled there, and in NumPy behind a run: equal but for rounding


def assert_row(sim, run, row):
    """All outputs are those of a row of a run."""
    for name in run.names:
        if name in TIP:
            assert abs(float(sim[name]) - run[name][row]) < 1e-12
        elif name != "time" and not name.endswith("voltage"):
            assert float(sim[name]) == run[name][row], (name, row)


def played(sim, levers, seed, events, *, disturb=False):
    """Play levers in calls of random lengths; gives the step at their ends, and adds to a list of events."""
    rng, k = np.random.default_rng(seed), 0
    while k < len(levers):
        same = next((i for i in range(k, len(levers)) if (levers[i] != levers[k]).any()), len(levers))
        for n in random_split(rng, same - k):
            if disturb and rng.random() < 0.3:
                kept = pickle.loads(pickle.dumps(sim.save()))
                sim.step(np.full(levers.shape[1], 0.1), n=int(rng.integers(1, 9)))
                if rng.random() < 0.5:
                    sim.reset()
                sim.restore(kept)
            sim.step(levers[k], n=n)
            events += sim.events
            k += n
            yield k


def held_to_run(machine, levers, flow="exact", *, locked=(), load=None, dt=DT, seeds=(1, 2)):
    """Run of a machine whose steps, however they are divided among calls, have its bits."""
    run = simulate(machine, flow, held_scenario(machine, levers, dt, locked=locked, load=load), dt=dt)
    for seed in seeds:
        with Simulator(machine, flow, dt=dt, locked=locked, load=load) as sim:
            assert_row(sim, run, 0)
            events = []
            for k in played(sim, levers, seed, events, disturb=seed == seeds[-1]):
                assert_row(sim, run, k)
            assert sim.steps == len(levers)
            assert sim.time == run["time"][-1]
            assert sorted(events) == sorted(run.info["events"])
            assert sim.steps_not_converged == run.info["steps_not_converged"]
            assert sim.steps_out_of_domain == run.info["steps_out_of_domain"]
    return run


def levers_of(n_step, n_function, seed=0, n=MANY):
    """Voltages of many machines, (n, n_step, n_function) V, that change every six steps."""
    return np.stack([random_levers(seed + i, n_step, n_function, each=6, limit=1.0) for i in range(n)])


def play(sim, levers, seed=0, begin=0):
    """Play levers in calls of random lengths."""
    rng = np.random.default_rng(seed)
    for k in range(begin, levers.shape[1], 6):
        for n in random_split(rng, min(6, levers.shape[1] - k)):
            sim.step(levers[:, k], n=n)
