"""Classic Runge-Kutta method of order 4 with fixed steps: the continuous equations, four evaluations per step.

For comparison: it costs four valve evaluations where the semi-implicit step needs one. The voltage is not held over
a step. Pressures are put back within their bounds and joints within their stops at the ends of the steps, and a joint is held or free
for a whole step, so that the order is 4 only between such events.
"""

from typing import Any

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.interface import NOT_CONVERGED, OUT_OF_DOMAIN
from polydraulic.flow.record import from_vector, record_flows, store
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.loop import reasonable
from polydraulic.simulation.solvers.right_hand_side import (
    Derivative,
    bounded_pressures,
    derivative,
    held_at_stops,
    landed,
    resting,
)


@kernel
def _plus(x: Links, d: Links, dt: float) -> Links:
    return Links(x.swing + dt * d.swing, x.boom + dt * d.boom, x.stick + dt * d.stick)


@kernel
def _along(x: State, d: State, dt: float) -> State:
    return State(
        _plus(x.spool, d.spool, dt),
        _plus(x.p_a, d.p_a, dt),
        _plus(x.p_b, d.p_b, dt),
        _plus(x.angle, d.angle, dt),
        _plus(x.rate, d.rate, dt),
    )


@kernel
def _settled(x: State, plant: Plant) -> State:
    """State with pressures within their bounds and joints within their stops."""
    joints = landed(x.angle, x.rate, plant)
    return State(x.spool, bounded_pressures(x.p_a, plant), bounded_pressures(x.p_b, plant), joints.angle, joints.rate)


@kernel
def _volts(voltage: np.ndarray, k: int) -> Links:
    return Links(voltage[k, 0], voltage[k, 1], voltage[k, 2])


@driver
def _slope(
    model: Any, memory: np.ndarray, plant: Plant, tau: Links, held: Held, voltage: np.ndarray, k: int, x: State
) -> Derivative:
    # a function of its own, so that it is compiled once and not six times
    return derivative(model, memory, plant, tau, held, _volts(voltage, k), x)


@driver
def run_runge_kutta(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    tau: Links,
    dt: float,
    x0: np.ndarray,
    voltage: np.ndarray,
    every: int,
    rows: np.ndarray,
    counts: np.ndarray,
) -> int:
    """Run through all steps, as `loop.run`.

    Here `plant` is prepared for dt = 1 s, `tau` are the pilots' time constants, and `voltage` has shape (2 n_step + 1, 3),
    values at the ends and middles of the steps.
    """
    n_step = voltage.shape[0] // 2
    x = from_vector(x0)
    for k in range(n_step + 1):
        held = resting(x, 0.0, plant)
        first = _slope(model, memory, plant, tau, held, voltage, 2 * k, x)
        left = held_at_stops(held, x, first.rates, plant)
        if left.swing != held.swing or left.boom != held.boom or left.stick != held.stick:
            held = left
            first = _slope(model, memory, plant, tau, held, voltage, 2 * k, x)
        counts[0] += 1 if first.rates.flows.status == NOT_CONVERGED else 0
        counts[1] += 1 if first.rates.flows.status == OUT_OF_DOMAIN else 0
        sound = reasonable(x.rate)
        if k % every == 0 or not sound:
            row = rows[k // every] if sound else rows[0]
            store(x, row)
            record_flows(first.rates.flows, first.rates.q_out, row)
        if not sound:
            return k - 1
        if k < n_step:
            a = first.state
            b = _slope(model, memory, plant, tau, held, voltage, 2 * k + 1, _along(x, a, 0.5 * dt)).state
            c = _slope(model, memory, plant, tau, held, voltage, 2 * k + 1, _along(x, b, 0.5 * dt)).state
            d = _slope(model, memory, plant, tau, held, voltage, 2 * k + 2, _along(x, c, dt)).state
            x = _along(_along(x, a, dt / 6.0), b, dt / 3.0)
            x = _settled(_along(_along(x, c, dt / 3.0), d, dt / 6.0), plant)
    return n_step
