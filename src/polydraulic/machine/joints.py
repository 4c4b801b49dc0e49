"""Subsystem 4 put together: line pressures -> joint torques -> accelerations -> motion, with end stops.

End stops are inelastic. A joint that would pass its stop is brought to rest by an impulse, which the other joints feel through
the mass matrix; one that is pushed into its stop is held by the same rule, and leaves when it is pulled away.
"""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.machine.actuator import friction_torque, lever_arm
from polydraulic.machine.linkage import Held, Motion, Symmetric, motion, solve_motion, times
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links
from polydraulic.parameters.schema import Stops


class Levers(NamedTuple):
    """Volume in m3 that a radian of each joint draws from line A and gives to line B; also torque over pressure."""

    a: Links
    b: Links


class Position(NamedTuple):
    """What follows from angles and rates alone."""

    levers: Levers
    motion: Motion


class Joints(NamedTuple):
    """Angles and rates of the joints."""

    angle: Links
    rate: Links


@kernel
def position(angle: Links, rate: Links, plant: Plant) -> Position:
    """Levers, mass matrix and bias torques; the only sines and cosines of a step."""
    b, s = sincos(angle.boom), sincos(angle.stick)
    boom, stick = plant.boom.cylinder, plant.stick.cylinder
    arm_boom, arm_stick = lever_arm(b, boom), lever_arm(s, stick)
    motor = plant.swing.displacement
    levers = Levers(
        Links(motor, arm_boom * boom.area_a, arm_stick * stick.area_a),
        Links(motor, arm_boom * boom.area_b, arm_stick * stick.area_b),
    )
    return Position(levers, motion(b, s, rate, plant.linkage))


@kernel
def net_torque(here: Position, p_a: Links, p_b: Links, rate: Links, plant: Plant) -> Links:
    """Torque in N m that is left to accelerate: oil pressure less friction, gravity and what motion itself needs."""
    a, b = here.levers.a, here.levers.b
    bias, gravity = here.motion.bias, here.motion.gravity
    return Links(
        a.swing * p_a.swing
        - b.swing * p_b.swing
        - bias.swing
        - gravity.swing
        - friction_torque(rate.swing, plant.swing.friction),
        a.boom * p_a.boom
        - b.boom * p_b.boom
        - bias.boom
        - gravity.boom
        - friction_torque(rate.boom, plant.boom.friction),
        a.stick * p_a.stick
        - b.stick * p_b.stick
        - bias.stick
        - gravity.stick
        - friction_torque(rate.stick, plant.stick.friction),
    )


@kernel
def passes_stop(angle: float, rate: float, stops: Stops, dt: float) -> bool:
    """Whether a joint would pass a stop within the step."""
    end = angle + dt * rate
    return (rate > 0.0 and end >= stops.high) or (rate < 0.0 and end <= stops.low)


@kernel
def passing(angle: Links, rate: Links, plant: Plant) -> Held:
    """Which joints would pass a stop within the step."""
    return Held(
        passes_stop(angle.swing, rate.swing, plant.swing.stops, plant.dt),
        passes_stop(angle.boom, rate.boom, plant.boom.stops, plant.dt),
        passes_stop(angle.stick, rate.stick, plant.stick.stops, plant.dt),
    )


@kernel
def _either(x: Held, y: Held) -> Held:
    return Held(x.swing or y.swing, x.boom or y.boom, x.stick or y.stick)


class Stopped(NamedTuple):
    """Rates after the impulses of end stops, and the joints that stand at one."""

    rate: Links
    there: Held


@kernel
def stopped(angle: Links, rate: Links, mass: Symmetric, plant: Plant) -> Stopped:
    """Impulses of the stops that joints would pass within the step.

    A second pass releases joints that a stop would have to pull, and stops those that the first impulses drive into theirs.
    """
    met = passing(angle, rate, plant)
    momentum = times(mass, rate)
    after = solve_motion(mass, _either(plant.locked, met), momentum)
    then = times(mass, after)
    pushed = Held(
        met.swing and (then.swing - momentum.swing) * rate.swing <= 0.0,
        met.boom and (then.boom - momentum.boom) * rate.boom <= 0.0,
        met.stick and (then.stick - momentum.stick) * rate.stick <= 0.0,
    )
    met = _either(pushed, passing(angle, after, plant))
    after = solve_motion(mass, _either(plant.locked, met), momentum)
    late = passing(angle, after, plant)  # driven into a stop by the second impulses: rare, and without impulse
    rate = Links(
        0.0 if late.swing else after.swing,
        0.0 if late.boom else after.boom,
        0.0 if late.stick else after.stick,
    )
    return Stopped(rate, _either(met, late))


@kernel
def turned_joint(angle: float, rate: float, there: bool, stops: Stops, dt: float) -> float:
    """Position of a joint after a step at this rate; one that stands `there` is at its nearer stop."""
    stop = stops.high if stops.high - angle < angle - stops.low else stops.low
    return stop if there else min(max(angle + dt * rate, stops.low), stops.high)


@kernel
def accelerated(rate: Links, acceleration: Links, dt: float) -> Links:
    """Rates after a step without stops."""
    return Links(
        rate.swing + dt * acceleration.swing,
        rate.boom + dt * acceleration.boom,
        rate.stick + dt * acceleration.stick,
    )


@kernel
def turned(angle: Links, rate: Links, there: Held, plant: Plant) -> Links:
    """Angles after a step at these rates, up to the stops; joints that stand `there` are at the nearer one."""
    dt = plant.dt
    return Links(
        turned_joint(angle.swing, rate.swing, there.swing, plant.swing.stops, dt),
        turned_joint(angle.boom, rate.boom, there.boom, plant.boom.stops, dt),
        turned_joint(angle.stick, rate.stick, there.stick, plant.stick.stops, dt),
    )


@kernel
def moved(angle: Links, rate: Links, acceleration: Links, mass: Symmetric, plant: Plant) -> Joints:
    """Angles and rates after a step: the new rates move the angles, up to the stops."""
    free = accelerated(rate, acceleration, plant.dt)
    met = passing(angle, free, plant)
    after = stopped(angle, free, mass, plant) if (met.swing or met.boom or met.stick) else Stopped(free, met)
    return Joints(turned(angle, after.rate, after.there, plant), after.rate)
