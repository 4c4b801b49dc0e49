"""Logs of machines at work as sensors read them, healthy and with faults, for tests of what watches them."""

from functools import cache

import numpy as np

from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification.watching.watch_log import learnt_from, log_blocks, watched_columns
from polydraulic.networks.model.table import Network, Node
from polydraulic.parameters.fault_catalogue import timed_faults
from polydraulic.parameters.faults import faulty_column
from polydraulic.tables import Table
from polydraulic.watch.blocks import starts_of
from polydraulic.watch.naming import FaultNetworks, inputs_of, kinds_of
from polydraulic.watch.watch import FaultWatch
from polydraulic.watch.watched import watched

NOISE = {"p_pump": 1e5, "spool": 4e-5, "p_a": 1e5, "p_b": 1e5, "q_in": 8e-6, "q_out": 8e-6, "voltage": 2e-3, "angle": 5e-4, "position": 1e-3}  # fmt: skip
RASTER, EVERY = 0.02, 4
RATE = 0.1


def log_of(machine, seed, seconds, faults=(), payload=0.0, pumps=()):
    """What sensors read of a random operator's work, in SI; pressures of pumps of circuits that are asked for."""
    from polydraulic.parameters.layout.payload import with_payload

    timed = timed_faults(machine, list(faults))
    run = simulate(
        with_payload(machine, payload) if payload else machine,
        "exact",
        random_operator(seed, seconds, limit=1.1, functions=machine.names),
        every=EVERY,
        faults=timed,
    )
    rng, columns = np.random.default_rng(seed), {"time": run["time"]}
    for name in run.names:
        owner, _, what = name.partition(".")
        if (owner in machine.names and what in NOISE and what != "p_pump") or name in [f"{c}.p_pump" for c in pumps]:
            read = faulty_column(name, run["time"], run[name], timed, {})
            columns[name] = read + rng.normal(0.0, NOISE[what], len(run))
    return Table(columns, {name: run.unit(name) for name in columns})


@cache
def healthy_log(name="wheel_loader", seconds=150.0, pumps=()):
    return log_of(load_machine(name), 11, seconds, pumps=pumps)


@cache
def known(name="wheel_loader", pumps=()):
    """A machine that is watched, and what is to be expected of it."""
    machine, log = load_machine(name), healthy_log(name, pumps=pumps)
    of = watched(machine, watched_columns(machine, log, "log", None), RASTER)
    return of, learnt_from(of, log, np.ones(len(log), dtype=bool), RATE)


def blocks(of, log):
    """Readings of all blocks of a log, and when they begin."""
    starts = starts_of(log["time"], np.zeros(len(log)), of.shape)
    return log_blocks(of, log, starts), log["time"][starts + of.shape.before]


def watched_by(of, expected, log, rate=RATE):
    watch = FaultWatch(of, expected, rate)
    watch.judge(*blocks(of, log))
    return watch


def held(log, column, begin, end):
    """A log in which a sensor reads the same from one time to another."""
    time, values = log["time"], log[column].copy()
    values[(time >= begin) & (time < end)] = values[time >= begin][0]
    return Table({n: values if n == column else log[n] for n in log.names}, {n: log.unit(n) for n in log.names})


def made_networks(directions, seed=3):
    """Networks of three kinds, of nodes of every kind with coefficients by chance."""
    from polydraulic.networks import Model, Variable
    from polydraulic.networks.model.nodes import KIND_NAMES, terms

    rng, inputs = np.random.default_rng(seed), [Variable(name) for name in inputs_of(directions)]
    n, reads = len(inputs), {"single": 1, "double": 2, "triple": 3, "linear": 4, "sigmoid": 3, "ramp": 2}
    models = []
    for kind in kinds_of(directions)[:3]:
        nodes = []
        for name, count in reads.items():
            number = KIND_NAMES.index(name)
            slots = (*rng.choice(n, count - 1, replace=False).tolist(), n + len(nodes) - 1 if nodes else 0)
            nodes.append(Node(number, slots, tuple(rng.normal(0.0, 0.6, len(terms(number, count))).tolist())))
        network = Network(tuple(nodes), (0.2,) * n, (1.5,) * n, (-4.0,) * n, (3.0,) * n, 0.1, 2.0)
        models.append(Model(tuple(inputs), Variable(kind), (network,)))
    link = np.column_stack([2.0 * np.eye(3) + 0.3 * rng.normal(size=(3, 3)), rng.normal(size=3)])
    return FaultNetworks(tuple(d.name for d in directions), tuple(models), link)
