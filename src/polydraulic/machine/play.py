"""Play between what drives and what follows, and flow forces: effects that a machine has if its file declares them.

Backlash. An actuator without mass, whose position is `gap` ahead of its joint, |gap| at most half the play. Between the ends it moves so
that its oil's forces balance, and the joint feels nothing; at an end it pushes the joint, and never pulls. With tau = a p_a - b p_b, a
motion d of the actuator changes the pressures by -a d / C_a and b d / C_b, so that tau falls by d (a^2 / C_a + b^2 / C_b): the step
to balance, or to the end of the play, is a closed form.

Flow forces. A jet leaves an orifice K a at the drop dp with the axial momentum sqrt(2 density) cos(angle) K a dp, which pulls the spool
towards its centre; over the spring's rate it is a shift of the spool's equilibrium.
"""

from math import cos, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.hose import LineStep, Pressures
from polydraulic.machine.pilot import PilotStep
from polydraulic.parameters.layout.parts import FlowForce


class LooseLine(NamedTuple):
    """Line pressures and outlet flow of an actuator with play, and how far it is ahead of its joint."""

    p_a: float
    p_b: float
    q_out: float
    gap: float


def prepare_shift(force: FlowForce) -> float:
    """Shift of a spool in m for each m3/s sqrt(Pa) of conductance times drop."""
    return sqrt(2.0 * force.density) * cos(force.jet_angle) / force.spring_rate


@kernel
def followed(position: float, driver: float, half: float) -> float:
    """Where something stands that lags behind its driver by half a width either way."""
    return min(max(position, driver - half), driver + half)


@kernel
def actuator_rate(gap: float, rate: float, half: float) -> float:
    """Rate at which an actuator sets out in a step: that of its joint while it touches, else none."""
    return rate if abs(gap) >= half else 0.0


@kernel
def felt_torque(torque: float, gap: float, half: float) -> float:
    """What the joint feels of an actuator's torque: pushes at either end of the play."""
    up, down = gap >= half and torque > 0.0, gap <= -half and torque < 0.0
    return torque if up or down else 0.0


@kernel
def taken_up(p: Pressures, ahead: float, a: float, b: float, line: LineStep, half: float, dt: float) -> LooseLine:
    """Let an actuator move to where its oil's forces balance, or to an end of its play.

    Parameters
    ----------
    p : Pressures
        After a step without this motion, Pa.
    ahead : float
        How far it would then be ahead of its joint, rad or m.
    a, b : float
        Levers towards the lines A and B.
    line : LineStep
    half : float
        Half the play.
    dt : float, s
    """
    torque, stiffness = a * p.p_a - b * p.p_b, a * a * line.gain_a + b * b * line.gain_b
    gap = min(max(ahead + torque * dt / (stiffness + 1e-300), -half), half)
    speed = (gap - ahead) / dt
    p_a = min(max(p.p_a - line.gain_a * a * speed, line.floor), line.relief)
    p_b = min(max(p.p_b + line.gain_b * b * speed, line.floor), line.relief)
    return LooseLine(p_a, p_b, p.q_out, gap)


@kernel
def jet(conductance: float, flow: float) -> float:
    """Conductance times drop of an orifice, m3/s sqrt(Pa), from the flow through it."""
    return flow * flow / (conductance + 1e-300)


@kernel
def pushed_back(spool: float, shift: float, pilot: PilotStep) -> float:
    """A spool in m after a step in which its equilibrium is shifted towards the centre, up to which it may go."""
    back = min(shift * (1.0 - pilot.decay), abs(spool))
    return spool - back if spool >= 0.0 else spool + back
