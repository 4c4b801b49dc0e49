"""A log of a random operator's work on the exact machine, as an import would give it."""

from functools import cache

import numpy as np

from polydraulic import load_machine, random_operator, simulate
from polydraulic.tables import Table
from polydraulic.thesis.excavator import LINKS

NOISE = {"spool": 2e-5, "p_a": 5e4, "p_b": 5e4, "q_in": 1e-5, "q_out": 1e-5, "voltage": 1e-3, "angle": 3e-4}


@cache
def machine_log(seconds=90.0, seed=1):
    # coarse steps, since plain Python makes them slowly
    run = simulate(load_machine("cat215b"), "exact", random_operator(seed, seconds), dt=0.02)
    rng = np.random.default_rng(seed)
    names = [f"{link}.{what}" for link in LINKS for what in NOISE]
    noisy = {name: run[name] + rng.normal(0.0, NOISE[name.split(".")[1]], len(run)) for name in names}
    columns = {"time": run["time"], "segment": np.zeros(len(run)), **noisy}
    return Table(columns, {"time": "s", "segment": "1"} | {name: run.unit(name) for name in names})


def changed(table, **columns):
    """A table with other values in some columns; LINK_WHAT names LINK.WHAT."""
    new = {name.replace("_", ".", 1): values for name, values in columns.items()}
    return Table({**table.columns, **new}, table.units)
