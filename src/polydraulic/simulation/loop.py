"""The compiled time loop: step, record, repeat; compiled once for each type of flow model."""

from math import sqrt
from typing import Any

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.dispatch import flow_step
from polydraulic.flow.interface import NOT_CONVERGED, OUT_OF_DOMAIN
from polydraulic.flow.record import from_vector, record_flows, store
from polydraulic.machine.hose import LineStep
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.step import Step, machine_step, seen_pressures

FASTEST = 1e3  # rad/s; beyond it the numbers mean nothing
DIVERGED = 4  # status of a step that is not made, beside OK, NOT_CONVERGED and OUT_OF_DOMAIN of the flows


@kernel
def record(step: Step, row: np.ndarray) -> None:
    """Write a step into the places of a row."""
    store(step.state, row)
    record_flows(step.flows, step.q_out, row)


@kernel
def rest_outlet(k: float, p_out: float, line: LineStep) -> float:
    """Flow in m3/s from a line whose pressure stays as it is."""
    return k * sqrt(max(p_out - line.p_return, 0.0))


@kernel
def rest_outlets(k: Links, p_out: Links, plant: Plant) -> Links:
    """Outlet flows at line pressures that stay as they are."""
    return Links(
        rest_outlet(k.swing, p_out.swing, plant.swing.line),
        rest_outlet(k.boom, p_out.boom, plant.boom.line),
        rest_outlet(k.stick, p_out.stick, plant.stick.line),
    )


@kernel
def reasonable(rate: Links) -> bool:
    """Whether the rates are numbers that still mean something."""
    return abs(rate.swing) < FASTEST and abs(rate.boom) < FASTEST and abs(rate.stick) < FASTEST


@kernel
def at_rest(model: Any, memory: np.ndarray, plant: Plant, x: State) -> Step:
    """Flows at a state, without advancing it."""
    seen = seen_pressures(x.spool, x.p_a, x.p_b)
    flows = flow_step(model, memory, x.spool, seen.p_in, seen.p_out, plant.dt)
    return Step(x, flows, rest_outlets(flows.k_out, seen.p_out, plant))


@driver
def run(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    x0: np.ndarray,
    voltage: np.ndarray,
    every: int,
    rows: np.ndarray,
    counts: np.ndarray,
) -> int:
    """Run through all voltages.

    Parameters
    ----------
    model, memory, plant
        As for `machine_step`.
    x0 : (15,) array
        State at the start.
    voltage : (n_step, 3) array, V
        Constant over each step.
    every : int
        Every how many steps a row is recorded.
    rows : (1 + n_step // every, N_RECORD) array
        Filled: the start, then state and flows at the end of every recorded step.
    counts : (2,) array of int
        Filled: steps that did not converge, and steps outside the flow model's domain.

    Returns
    -------
    int
        Steps made; fewer than asked for if a rate became too large or not a number: then the first row holds that step.
    """
    step = at_rest(model, memory, plant, from_vector(x0))
    record(step, rows[0])
    for k in range(voltage.shape[0]):
        step = machine_step(model, memory, plant, step.state, Links(voltage[k, 0], voltage[k, 1], voltage[k, 2]))
        counts[0] += 1 if step.flows.status == NOT_CONVERGED else 0
        counts[1] += 1 if step.flows.status == OUT_OF_DOMAIN else 0
        if not reasonable(step.state.rate):
            record(step, rows[0])
            return k
        if (k + 1) % every == 0:
            record(step, rows[(k + 1) // every])
    return voltage.shape[0]
