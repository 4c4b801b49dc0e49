"""Actuators: cylinder triangle and pressure areas, joint friction, end stops."""

from math import pi, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, sincos, tanh
from polydraulic.parameters.schema import Cylinder, Friction, Stops


class Triangle(NamedTuple):
    """Cylinders between two pins, prepared: L^2 = squares - product cos(psi), psi = offset + direction * angle."""

    squares: float  # r_base^2 + r_link^2
    product: float  # 2 r_base r_link
    offset: float
    direction: float  # +1: a growing joint angle extends the cylinder (boom); -1: it retracts it (stick)
    area_a: float  # area that pushes the joint towards positive angles, all cylinders
    area_b: float


def prepare_cylinder(cylinder: Cylinder, direction: float) -> Triangle:
    """Areas and triangle; port A is the head side for the boom, the rod side for the stick."""
    head = cylinder.number * pi / 4.0 * cylinder.bore**2
    rod = cylinder.number * pi / 4.0 * (cylinder.bore**2 - cylinder.rod**2)
    return Triangle(
        squares=cylinder.r_base**2 + cylinder.r_link**2,
        product=2.0 * cylinder.r_base * cylinder.r_link,
        offset=cylinder.angle_offset,
        direction=direction,
        area_a=head if direction > 0.0 else rod,
        area_b=rod if direction > 0.0 else head,
    )


@kernel
def lever_arm(angle: float, t: Triangle) -> float:
    """Lever arm in m: cylinder speed towards positive joint motion over joint rate, r_b r_l sin(psi) / L."""
    psi = sincos(t.offset + t.direction * angle)
    return 0.5 * t.product * psi.sin / sqrt(t.squares - t.product * psi.cos)


@kernel
def friction_torque(rate: float, f: Friction) -> float:
    """Friction torque in N m at a joint rate in rad/s: Coulomb with Stribeck rise, smoothed at rest, and viscous."""
    w = rate / f.stribeck
    dry = f.coulomb + (f.static - f.coulomb) * exp(-(w * w))
    return dry * tanh(rate / f.smoothing) + f.viscous * rate


class Joint(NamedTuple):
    """Angle and rate of one joint."""

    angle: float
    rate: float


@kernel
def end_stop(angle: float, rate: float, stops: Stops) -> Joint:
    """Inelastic end stops: a joint that reached one stands there until it is pulled away."""
    low, high = angle <= stops.low, angle >= stops.high
    rate = max(rate, 0.0) if low else (min(rate, 0.0) if high else rate)
    return Joint(min(max(angle, stops.low), stops.high), rate)
