"""Actuators: cylinder triangle and pressure areas, motor, joint friction."""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import SinCos, exp, tanh
from polydraulic.parameters.schema import Friction, SwingMotor


class Triangle(NamedTuple):
    """Cylinders between two pins, prepared: L^2 = squares - product cos(psi), psi = offset + direction * angle."""

    squares: float  # r_base^2 + r_link^2
    product_cos: float  # 2 r_base r_link cos(offset)
    product_sin: float
    direction: float  # +1: a growing joint angle extends the cylinder; -1: it retracts it
    area_a: float  # area that pushes the joint towards positive angles, all cylinders
    area_b: float


def motor_displacement(motor: SwingMotor) -> float:
    """Volume in m3 for a radian of the upper structure."""
    return motor.displacement * motor.gear_ratio


@kernel
def lever_arm(joint: SinCos, t: Triangle) -> float:
    """Lever arm in m: cylinder speed towards positive joint motion over joint rate, r_b r_l sin(psi) / L."""
    product_sin = t.product_sin * joint.cos + t.direction * t.product_cos * joint.sin
    product_cos = t.product_cos * joint.cos - t.direction * t.product_sin * joint.sin
    return 0.5 * product_sin / sqrt(t.squares - product_cos)


@kernel
def friction_torque(rate: float, f: Friction) -> float:
    """Friction torque in N m at a joint rate in rad/s: Coulomb with Stribeck rise, smoothed at rest, and viscous."""
    w = rate / f.stribeck
    dry = f.coulomb + (f.static - f.coulomb) * exp(-(w * w))
    return dry * tanh(rate / f.smoothing) + f.viscous * rate


@kernel
def dry_friction(rate: float, f: Friction) -> float:
    """Dry friction in N m that opposes a joint rate in rad/s, or, at rest, the most that it can hold."""
    w = rate / f.stribeck
    return f.coulomb + (f.static - f.coulomb) * exp(-(w * w))


@kernel
def viscous_torque(rate: float, f: Friction) -> float:
    """The part of friction in N m that grows with the joint rate in rad/s."""
    return f.viscous * rate


@kernel
def sliding_torque(rate: float, f: Friction) -> float:
    """Friction torque in N m of a joint that slides at a rate in rad/s; 0 of one that rests."""
    dry = dry_friction(rate, f)
    return (dry if rate > 0.0 else (-dry if rate < 0.0 else 0.0)) + f.viscous * rate


@kernel
def lever_slope(joint: SinCos, arm: float, t: Triangle) -> float:
    """Slope of `lever_arm` over the joint angle, m/rad; `arm` is the lever arm itself."""
    product_cos = t.product_cos * joint.cos - t.direction * t.product_sin * joint.sin
    return t.direction * (0.5 * product_cos - arm * arm) / sqrt(t.squares - product_cos)


@kernel
def friction_slope(rate: float, f: Friction) -> float:
    """Slope of `friction_torque` over the joint rate, N m s."""
    w, s = rate / f.stribeck, tanh(rate / f.smoothing)
    rise = (f.static - f.coulomb) * exp(-(w * w))
    return (f.coulomb + rise) * (1.0 - s * s) / f.smoothing - 2.0 * w / f.stribeck * rise * s + f.viscous
