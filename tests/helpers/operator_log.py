"""Logs of a random operator's work on a machine of any layout, with the noise of sensors or without."""

from functools import cache

import numpy as np

from polydraulic import load_machine, random_operator, simulate
from polydraulic.tables import Table

NOISE = {"angle": 5e-4, "position": 1e-3, "p_a": 1e5, "p_b": 1e5}


@cache
def operator_log(name, seconds=20.0, seed=5, noise=1.0):
    machine = load_machine(name)
    run = simulate(machine, "exact", random_operator(seed, seconds, functions=machine.names), dt=5e-3, every=4)
    rng = np.random.default_rng(seed)
    columns = {n: run[n] + noise * NOISE.get(n.split(".")[-1], 0.0) * rng.normal(size=len(run)) for n in run.names}
    return Table(columns, {n: run.unit(n) for n in run.names})
