"""One time step of the machine, semi-implicit: each stage uses what the stages before it have just found.

Pilots (exact) -> flows (one evaluation) -> line pressures (outlets implicit) -> accelerations -> rates -> angles. Explicit
Euler would amplify the oil-spring modes; this order keeps them stable at 5 ms with one valve evaluation per step.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.flow.dispatch import flow_step
from polydraulic.flow.interface import Flows
from polydraulic.machine.hose import Pressures, line_step, ports
from polydraulic.machine.joints import Levers, moved, net_torque, position
from polydraulic.machine.linkage import solve_motion
from polydraulic.machine.pilot import pilot_step
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State


class Step(NamedTuple):
    """State after a step, and the flows during it."""

    state: State
    flows: Flows
    q_out: Links


class Seen(NamedTuple):
    """Pressures that the valves see."""

    p_in: Links
    p_out: Links


class Lines(NamedTuple):
    """Line pressures and outlet flows of the three actuators."""

    p_a: Links
    p_b: Links
    q_out: Links


@kernel
def spools(x: Links, voltage: Links, plant: Plant) -> Links:
    """Spool displacements after a step."""
    return Links(
        pilot_step(x.swing, voltage.swing, plant.swing.pilot),
        pilot_step(x.boom, voltage.boom, plant.boom.pilot),
        pilot_step(x.stick, voltage.stick, plant.stick.pilot),
    )


@kernel
def seen_pressures(spool: Links, p_a: Links, p_b: Links) -> Seen:
    """Pressures at the pressurised ports and at the outlets."""
    swing = ports(spool.swing, p_a.swing, p_b.swing)
    boom = ports(spool.boom, p_a.boom, p_b.boom)
    stick = ports(spool.stick, p_a.stick, p_b.stick)
    return Seen(Links(swing.p_in, boom.p_in, stick.p_in), Links(swing.p_out, boom.p_out, stick.p_out))


@kernel
def lines(spool: Links, x: State, flows: Flows, levers: Levers, plant: Plant) -> Lines:
    """Line pressures after a step, with the joints moving as before it."""
    q, k, a, b, w = flows.q_in, flows.k_out, levers.a, levers.b, x.rate
    swing: Pressures = line_step(
        spool.swing,
        x.p_a.swing,
        x.p_b.swing,
        q.swing,
        k.swing,
        a.swing * w.swing,
        -b.swing * w.swing,
        plant.swing.line,
    )
    boom: Pressures = line_step(
        spool.boom, x.p_a.boom, x.p_b.boom, q.boom, k.boom, a.boom * w.boom, -b.boom * w.boom, plant.boom.line
    )
    stick: Pressures = line_step(
        spool.stick,
        x.p_a.stick,
        x.p_b.stick,
        q.stick,
        k.stick,
        a.stick * w.stick,
        -b.stick * w.stick,
        plant.stick.line,
    )
    return Lines(
        Links(swing.p_a, boom.p_a, stick.p_a),
        Links(swing.p_b, boom.p_b, stick.p_b),
        Links(swing.q_out, boom.q_out, stick.q_out),
    )


@kernel
def machine_step(model: Any, memory: np.ndarray, plant: Plant, x: State, voltage: Links) -> Step:
    """Advance the machine by one step with constant voltages.

    Parameters
    ----------
    model : flow model
    memory : (n_memory,) array
        Of the flow model; changed in place.
    plant : Plant
        The machine, prepared for the step size.
    x : State
    voltage : Links, V
    """
    spool = spools(x.spool, voltage, plant)
    seen = seen_pressures(spool, x.p_a, x.p_b)
    flows = flow_step(model, memory, spool, seen.p_in, seen.p_out, plant.dt)
    here = position(x.angle, x.rate, plant)
    after = lines(spool, x, flows, here.levers, plant)
    torque = net_torque(here, after.p_a, after.p_b, x.rate, plant)
    acceleration = solve_motion(here.motion.mass, plant.locked, torque)
    joints = moved(x.angle, x.rate, acceleration, here.motion.mass, plant)
    return Step(State(spool, after.p_a, after.p_b, joints.angle, joints.rate), flows, after.q_out)
