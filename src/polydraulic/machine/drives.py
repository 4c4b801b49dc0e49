"""Drives: what a line's oil does to a joint, whatever stands between them - motor and gear, cylinder, bucket linkage, ram.

Each drive has a kernel `drive_KIND` that gives the two levers of a joint: the volume in m3 that a radian (or a metre) of it draws from
line A and gives to line B, which is also torque (or force) over pressure.
"""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import SinCos
from polydraulic.machine.actuator import Triangle, lever_arm, motor_displacement
from polydraulic.parameters.layout import geometry
from polydraulic.parameters.layout.schema import CylinderSize, FourBar, LinkParameters, MachineFunction, Pins
from polydraulic.parameters.schema import SwingMotor


class Motor(NamedTuple):
    """Hydraulic motor behind a gear: m3 per rad of the joint (per m of a rack)."""

    displacement: float


class Ram(NamedTuple):
    """Cylinders along a prismatic joint; A pushes towards positive positions."""

    area_a: float
    area_b: float


class Rocker(NamedTuple):
    """A bucket's linkage in the plane of its joint, which is the origin; m and m2."""

    base_u: float
    base_v: float
    hinge_u: float
    hinge_v: float
    pin_u: float
    pin_v: float
    difference: float  # rocker^2 - coupler^2
    rocker: float  # squared
    side: float
    direction: float
    area_a: float
    area_b: float


class JointLevers(NamedTuple):
    """Of one joint, towards line A and line B."""

    a: float
    b: float


Drive = Motor | Ram | Triangle | Rocker


def prepare_drive(function: MachineFunction, link: LinkParameters) -> Drive:
    """Numbers of a function's drive."""
    drive = function.drive
    if isinstance(drive, SwingMotor):
        return Motor(motor_displacement(drive))
    head, rod = _areas(drive)
    if function.pins is None:
        return Ram(head, rod)
    middle = 0.5 * (function.stops.low + function.stops.high)
    lengthens = (geometry.lever(function, link, middle) or 0.0) > 0.0
    area_a, area_b = (head, rod) if lengthens else (rod, head)
    return (
        _triangle(function.pins, link, area_a, area_b)
        if isinstance(function.pins, Pins)
        else _rocker(function.pins, link, 1.0 if lengthens else -1.0, area_a, area_b)
    )


def _areas(cylinder: CylinderSize) -> tuple[float, float]:
    """Head and rod side of all cylinders, m2."""
    return (
        cylinder.number * pi / 4.0 * cylinder.bore**2,
        cylinder.number * pi / 4.0 * (cylinder.bore**2 - cylinder.rod**2),
    )


def _triangle(pins: Pins, link: LinkParameters, area_a: float, area_b: float) -> Triangle:
    t = geometry.triangle(pins, link)
    product = 2.0 * t.r_base * t.r_rod
    return Triangle(
        squares=t.r_base**2 + t.r_rod**2 + t.aside**2,
        product_cos=product * cos(t.offset),
        product_sin=product * sin(t.offset),
        direction=t.direction,
        area_a=area_a,
        area_b=area_b,
    )


def _rocker(pins: FourBar, link: LinkParameters, direction: float, area_a: float, area_b: float) -> Rocker:
    r = geometry.rocker(pins, link)
    return Rocker(*r.base, *r.hinge, *r.pin, r.rocker**2 - r.coupler**2, r.rocker**2, r.side, direction, area_a, area_b)


@kernel
def drive_motor(joint: object, m: Motor) -> JointLevers:
    """Levers of a motor: the same anywhere."""
    return JointLevers(m.displacement, m.displacement)


@kernel
def drive_ram(joint: object, r: Ram) -> JointLevers:
    """Levers of a cylinder along a prismatic joint: its areas."""
    return JointLevers(r.area_a, r.area_b)


@kernel
def drive_cylinder(joint: SinCos, t: Triangle) -> JointLevers:
    """Levers of a cylinder between two pins."""
    arm = lever_arm(joint, t)
    return JointLevers(arm * t.area_a, arm * t.area_b)


@kernel
def drive_four_bar(joint: SinCos, r: Rocker) -> JointLevers:
    """Levers of a bucket's cylinder: two circles give the knee, rigid rocker, coupler and link its speed."""
    pin_u = r.pin_u * joint.cos - r.pin_v * joint.sin
    pin_v = r.pin_u * joint.sin + r.pin_v * joint.cos
    du, dv = pin_u - r.hinge_u, pin_v - r.hinge_v
    square = du * du + dv * dv
    along = 0.5 * (square + r.difference) / square
    across = -r.side * sqrt(max(r.rocker / square - along * along, 0.0))
    rocker_u, rocker_v = along * du - across * dv, along * dv + across * du  # from the hinge to the knee
    coupler_u, coupler_v = du - rocker_u, dv - rocker_v
    # the coupler keeps its length: rates of the rocker over that of the link
    turn = (coupler_v * pin_u - coupler_u * pin_v) / (coupler_v * rocker_u - coupler_u * rocker_v)
    ram_u, ram_v = r.hinge_u + rocker_u - r.base_u, r.hinge_v + rocker_v - r.base_v
    arm = r.direction * turn * (ram_v * rocker_u - ram_u * rocker_v) / sqrt(ram_u * ram_u + ram_v * ram_v)
    return JointLevers(arm * r.area_a, arm * r.area_b)
