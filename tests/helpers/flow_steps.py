"""Flow models of cat215b at single points and at random ones."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.pump import Circuit
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.thesis.excavator import spool_of, with_pumps
from polydraulic.units import to_si

PSI = to_si(1.0, "psi")
_READY = {}  # machines and models that have been prepared, with what was made of them


class Links(NamedTuple):
    """One float per function."""

    swing: float
    boom: float
    stick: float


class Flows(NamedTuple):
    """What the text of cat215b gives, by short names."""

    q_in: Links
    k_out: Links
    boom: Circuit
    series: Circuit
    p_between: float
    status: int


def flow_step(machine, model, memory, spool, p_in, p_out, dt=0.005):
    key = id(machine), id(model), dt
    if key not in _READY:
        _READY[key] = machine, model, prepare_layout(machine, dt, flow=model)
    ready = _READY[key][-1]
    points = (ready.module.Functions(*x) for x in (spool, p_in, p_out))
    found = ready.module.flow_step(ready.valves, memory, *points, dt)
    circuits = found.circuit_boom, found.circuit_series
    return Flows(Links(*found.q_in), Links(*found.k_out), *circuits, found.between_series_1, found.status)


def held_still(machine, model, memory, spool, p_in, steps):
    """Flows after so many steps with nothing moved, or as soon as a step changes nothing that is kept: all later ones are alike."""
    for _ in range(steps):
        before = memory.copy()
        flows = flow_step(machine, model, memory, spool, p_in, p_in)
        if np.array_equal(before, memory):
            break
    return flows


def step(machine, model, spool, p_in, p_out):
    """Flows with the boom's valve moved and the other two centred."""
    return step_all(machine, model, Links(0.0, spool, 0.0), Links(0.0, p_in, 0.0), Links(0.0, p_out, 0.0))


def step_all(machine, model, spool, p_in, p_out):
    return flow_step(machine, model, np.zeros(model.n_memory), spool, p_in, p_out)


def layout_step(machine, flow, dt=0.005):
    """A step of a flow model of a machine of any layout, of spools and pressures in the order of its functions; its memory goes on."""
    ready = prepare_layout(machine, dt, flow=flow)
    functions, memory = ready.module.Functions, np.zeros(ready.n_memory)

    def step(spool, p_in, p_out):
        return ready.module.flow_step(ready.valves, memory, *(functions(*x) for x in (spool, p_in, p_out)), dt)

    return step


def with_limit(machine):
    return with_pumps(machine, torque_limit_enabled=True)


def points(machine, n=200):
    """Spool, inlet and outlet pressure of the boom at random, the same ones for every model."""
    rng, travel = np.random.default_rng(0), spool_of(machine).end
    return zip(
        rng.uniform(-travel, travel, n), rng.uniform(0, 3000 * PSI, n), rng.uniform(0, 3000 * PSI, n), strict=True
    )


def states(machine, n=200, seed=4):
    """Spools and line pressures of all functions at random."""
    rng, travel = np.random.default_rng(seed), spool_of(machine).end
    for _ in range(n):
        spool, p_in, p_out = rng.uniform(-travel, travel, 3), *rng.uniform(0.0, 4000 * PSI, (2, 3))
        yield Links(*spool), Links(*p_in), Links(*p_out)
