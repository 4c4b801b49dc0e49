"""The compiled time loop: step, record, repeat; compiled once for each type of flow model."""

from math import sqrt
from typing import Any

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.dispatch import flow_step
from polydraulic.flow.interface import NOT_CONVERGED, OUT_OF_DOMAIN
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import N_STATE, Links, State, from_vector
from polydraulic.simulation.step import Step, boom_ports, machine_step

N_RECORD = N_STATE + 10  # state, q_in and q_out of three links, four flows and pressures of the boom circuit
_FASTEST = 1e3  # rad/s; beyond it the numbers mean nothing


@kernel
def _record(step: Step, row: np.ndarray) -> None:
    x = step.state
    row[0], row[1], row[2] = x.spool.swing, x.spool.boom, x.spool.stick
    row[3], row[4], row[5] = x.p_a.swing, x.p_a.boom, x.p_a.stick
    row[6], row[7], row[8] = x.p_b.swing, x.p_b.boom, x.p_b.stick
    row[9], row[10], row[11] = x.angle.swing, x.angle.boom, x.angle.stick
    row[12], row[13], row[14] = x.rate.swing, x.rate.boom, x.rate.stick
    row[15], row[16], row[17] = step.q_in.swing, step.q_in.boom, step.q_in.stick
    row[18], row[19], row[20] = step.q_out.swing, step.q_out.boom, step.q_out.stick
    row[21], row[22] = step.boom.q_pump, step.boom.q_bypass
    row[23], row[24] = step.boom.q_relief, step.boom.p_pump


@kernel
def at_rest(model: Any, memory: np.ndarray, plant: Plant, x: State) -> Step:
    """Flows at a state, without advancing it."""
    p = boom_ports(x, x.spool.boom)
    p_in = Links(x.p_a.swing, p.p_in, x.p_a.stick)
    p_out = Links(x.p_b.swing, p.p_out, x.p_b.stick)
    flows = flow_step(model, memory, x.spool, p_in, p_out, plant.dt)
    q_out = flows.k_out.boom * sqrt(max(p.p_out - plant.boom.line.p_return, 0.0))
    return Step(x, flows.q_in, Links(0.0, q_out, 0.0), flows.boom, flows.status)


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
        Steps made; fewer than asked for if a rate became too large or not a number.
    """
    step = at_rest(model, memory, plant, from_vector(x0))
    _record(step, rows[0])
    for k in range(voltage.shape[0]):
        step = machine_step(model, memory, plant, step.state, Links(voltage[k, 0], voltage[k, 1], voltage[k, 2]))
        counts[0] += 1 if step.status == NOT_CONVERGED else 0
        counts[1] += 1 if step.status == OUT_OF_DOMAIN else 0
        if not abs(step.state.rate.boom) < _FASTEST:
            return k
        if (k + 1) % every == 0:
            _record(step, rows[(k + 1) // every])
    return voltage.shape[0]
