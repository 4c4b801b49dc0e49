"""The machine's equations in continuous time: state -> time derivatives, shared by the methods that need them.

The component kernels are those of `step`, but no stage lags behind another. Line pressures have bounds that are not part of
the smooth equations: `rates` knows none, so that a solver may look across them; `derivative` keeps to them.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.dispatch import flow_step
from polydraulic.flow.interface import Flows
from polydraulic.flow.record import from_vector, record_flows, store
from polydraulic.machine.joints import Joints, Position, net_torque, position, stopped
from polydraulic.machine.linkage import Held, solve_motion, times
from polydraulic.machine.pilot import spool_target
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.solvers.line_rates import held_back, line_rates, within_bounds
from polydraulic.simulation.solvers.stop_conditions import BLINK, between_stops, rests, stands, strikes
from polydraulic.simulation.step import seen_pressures


class Rates(NamedTuple):
    """What all but the pilots do at a state."""

    p_a: Links  # Pa/s
    p_b: Links
    acceleration: Links  # rad/s2
    reaction: Links  # torques in N m that hold the joints which are held
    flows: Flows
    q_out: Links
    position: Position


class Derivative(NamedTuple):
    """Time derivative of the state, and what it was made from."""

    state: State
    rates: Rates


@kernel
def rates(model: Any, memory: np.ndarray, plant: Plant, held: Held, x: State) -> Rates:
    """Rates at a state, whatever its pressures; `plant` is prepared for dt = 1 s."""
    seen = seen_pressures(x.spool, x.p_a, x.p_b)
    flows = flow_step(model, memory, x.spool, seen.p_in, seen.p_out, plant.dt)
    here = position(x.angle, x.rate, plant)
    a, b, w, q, k = here.levers.a, here.levers.b, x.rate, flows.q_in, flows.k_out
    p, r = x.p_a, x.p_b
    swing = line_rates(
        x.spool.swing, p.swing, r.swing, q.swing, k.swing, a.swing * w.swing, b.swing * w.swing, plant.swing.line
    )
    boom = line_rates(x.spool.boom, p.boom, r.boom, q.boom, k.boom, a.boom * w.boom, b.boom * w.boom, plant.boom.line)
    stick = line_rates(
        x.spool.stick, p.stick, r.stick, q.stick, k.stick, a.stick * w.stick, b.stick * w.stick, plant.stick.line
    )
    torque = net_torque(here, x.p_a, x.p_b, x.rate, plant)
    acceleration = solve_motion(here.motion.mass, held, torque)
    needed = times(here.motion.mass, acceleration)
    return Rates(
        Links(swing.p_a, boom.p_a, stick.p_a),
        Links(swing.p_b, boom.p_b, stick.p_b),
        acceleration,
        Links(needed.swing - torque.swing, needed.boom - torque.boom, needed.stick - torque.stick),
        flows,
        Links(swing.q_out, boom.q_out, stick.q_out),
        here,
    )


@kernel
def bounded_pressures(p: Links, plant: Plant) -> Links:
    """Line pressures between make-up floor and relief."""
    swing, boom, stick = plant.swing.line, plant.boom.line, plant.stick.line
    return Links(
        within_bounds(p.swing, swing),
        within_bounds(p.boom, boom),
        within_bounds(p.stick, stick),
    )


@kernel
def _all_held_back(p: Links, rate: Links, plant: Plant) -> Links:
    return Links(
        held_back(p.swing, rate.swing, plant.swing.line),
        held_back(p.boom, rate.boom, plant.boom.line),
        held_back(p.stick, rate.stick, plant.stick.line),
    )


@kernel
def derivative(
    model: Any, memory: np.ndarray, plant: Plant, tau: Links, held: Held, voltage: Links, x: State
) -> Derivative:
    """Time derivative of a state whose pressures count, and move, only within their bounds.

    Parameters
    ----------
    model : flow model
    memory : (n_memory,) array
        Of the flow model; changed in place.
    plant : Plant
        Prepared for dt = 1 s.
    tau : Links, s
        Time constants of the pilots.
    held : Held
        Joints that stand still.
    voltage : Links, V
    x : State
    """
    within = State(x.spool, bounded_pressures(x.p_a, plant), bounded_pressures(x.p_b, plant), x.angle, x.rate)
    r = rates(model, memory, plant, held, within)
    spool = Links(
        (spool_target(voltage.swing, plant.swing.pilot) - x.spool.swing) / tau.swing,
        (spool_target(voltage.boom, plant.boom.pilot) - x.spool.boom) / tau.boom,
        (spool_target(voltage.stick, plant.stick.pilot) - x.spool.stick) / tau.stick,
    )
    p_a, p_b = _all_held_back(x.p_a, r.p_a, plant), _all_held_back(x.p_b, r.p_b, plant)
    return Derivative(State(spool, p_a, p_b, x.rate, r.acceleration), r)


@kernel
def landed(angle: Links, rate: Links, plant: Plant) -> Joints:
    """Joints after the impulses of the stops that they have just reached or passed; the stops put them in their place."""
    swing, boom, stick = plant.swing.stops, plant.boom.stops, plant.stick.stops
    now = Plant(BLINK, plant.swing, plant.boom, plant.stick, plant.linkage, plant.locked)
    there = Links(
        between_stops(angle.swing, swing),
        between_stops(angle.boom, boom),
        between_stops(angle.stick, stick),
    )
    struck = (
        strikes(angle.swing, rate.swing, swing)
        or strikes(angle.boom, rate.boom, boom)
        or strikes(angle.stick, rate.stick, stick)
    )
    after = stopped(there, rate, position(there, rate, now).motion.mass, now).rate if struck else rate
    return Joints(there, after)


@kernel
def resting(x: State, creep: float, plant: Plant) -> Held:
    """Joints that are locked, or stand at a stop: no faster than `creep` in rad/s."""
    return Held(
        plant.locked.swing or rests(x.angle.swing, x.rate.swing, creep, plant.swing.stops),
        plant.locked.boom or rests(x.angle.boom, x.rate.boom, creep, plant.boom.stops),
        plant.locked.stick or rests(x.angle.stick, x.rate.stick, creep, plant.stick.stops),
    )


@kernel
def held_at_stops(resting: Held, x: State, r: Rates, plant: Plant) -> Held:
    """Which of the joints that rest at a stop their stops hold: those which a stop pushes, while no other moves into its own.

    Joints feel each other's stops, so that all choices are tried, the one with most joints held first; since the mass matrix is
    positive definite, exactly one is right, but for ties. `r` are rates at the state, whatever is held in them.
    """
    mass, locked = r.position.motion.mass, plant.locked
    needed = times(mass, r.acceleration)
    torque = Links(needed.swing - r.reaction.swing, needed.boom - r.reaction.boom, needed.stick - r.reaction.stick)
    found = resting
    for choice in range(7, -1, -1):
        held = Held(
            locked.swing or (resting.swing and (choice & 1) != 0),
            locked.boom or (resting.boom and (choice & 2) != 0),
            locked.stick or (resting.stick and (choice & 4) != 0),
        )
        acceleration = solve_motion(mass, held, torque)
        push = times(mass, acceleration)
        swing = stands(x.angle.swing, push.swing - torque.swing, acceleration.swing, held.swing, plant.swing.stops)
        boom = stands(x.angle.boom, push.boom - torque.boom, acceleration.boom, held.boom, plant.boom.stops)
        stick = stands(x.angle.stick, push.stick - torque.stick, acceleration.stick, held.stick, plant.stick.stops)
        right = (
            (swing or locked.swing or not resting.swing)
            and (boom or locked.boom or not resting.boom)
            and (stick or locked.stick or not resting.stick)
        )
        if right:
            found = held
            break
    return found


@driver
def fill_flows(model: Any, memory: np.ndarray, plant: Plant, rows: np.ndarray) -> None:
    """Flows at recorded states, whose pressures are put within their bounds."""
    for k in range(rows.shape[0]):
        x = from_vector(rows[k])
        x = State(x.spool, bounded_pressures(x.p_a, plant), bounded_pressures(x.p_b, plant), x.angle, x.rate)
        r = rates(model, memory, plant, plant.locked, x)
        store(x, rows[k])
        record_flows(r.flows, r.q_out, rows[k])
