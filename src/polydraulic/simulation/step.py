"""One time step of the machine, semi-implicit: each stage uses what the stages before it have just found.

Pilot (exact) -> flows (one evaluation) -> line pressures (outlet implicit) -> acceleration -> rate -> angle. Explicit
Euler would amplify the oil-spring modes; this order keeps them stable at 5 ms with one valve evaluation a step.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.flow.dispatch import flow_step
from polydraulic.machine.actuator import Joint, end_stop, friction_torque, lever_arm
from polydraulic.machine.hose import Ports, Pressures, line_step, ports
from polydraulic.machine.linkage import Linkage, boom_load
from polydraulic.machine.pilot import pilot_step
from polydraulic.machine.plant import BoomPlant, Plant
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links, State


class Step(NamedTuple):
    """State after a step, and the flows during it."""

    state: State
    q_in: Links
    q_out: Links
    boom: Circuit
    status: int


@kernel
def boom_ports(x: State, spool: float) -> Ports:
    """Pressures that the boom's valve sees."""
    return ports(spool, x.p_a.boom, x.p_b.boom)


@kernel
def boom_acceleration(arm: float, p: Pressures, x: State, boom: BoomPlant, linkage: Linkage) -> float:
    """Angular acceleration of the boom in rad/s2, swing and stick held."""
    load = boom_load(x.angle.boom, x.angle.stick, linkage)
    push = arm * (boom.cylinder.area_a * p.p_a - boom.cylinder.area_b * p.p_b)
    return (push - load.gravity - friction_torque(x.rate.boom, boom.friction)) / load.inertia


@kernel
def boom_motion(acceleration: float, x: State, boom: BoomPlant, dt: float) -> Joint:
    """Angle and rate after a step: the new rate moves the angle."""
    rate = x.rate.boom + dt * acceleration
    return end_stop(x.angle.boom + dt * rate, rate, boom.stops)


@kernel
def machine_step(model: Any, memory: np.ndarray, plant: Plant, x: State, voltage: Links) -> Step:
    """Advance the machine by one step with constant voltages; swing and stick stand still.

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
    boom = plant.boom
    spool = Links(x.spool.swing, pilot_step(x.spool.boom, voltage.boom, boom.pilot), x.spool.stick)

    p = boom_ports(x, spool.boom)
    p_in = Links(x.p_a.swing, p.p_in, x.p_a.stick)
    p_out = Links(x.p_b.swing, p.p_out, x.p_b.stick)
    flows = flow_step(model, memory, spool, p_in, p_out, plant.dt)

    arm = lever_arm(x.angle.boom, boom.cylinder)
    speed = arm * x.rate.boom
    swept_a, swept_b = boom.cylinder.area_a * speed, -boom.cylinder.area_b * speed
    lines = line_step(
        spool.boom, x.p_a.boom, x.p_b.boom, flows.q_in.boom, flows.k_out.boom, swept_a, swept_b, boom.line
    )

    joint = boom_motion(boom_acceleration(arm, lines, x, boom, plant.linkage), x, boom, plant.dt)

    state = State(
        spool,
        Links(x.p_a.swing, lines.p_a, x.p_a.stick),
        Links(x.p_b.swing, lines.p_b, x.p_b.stick),
        Links(x.angle.swing, joint.angle, x.angle.stick),
        Links(x.rate.swing, joint.rate, x.rate.stick),
    )
    return Step(state, flows.q_in, Links(0.0, lines.q_out, 0.0), flows.boom, flows.status)
