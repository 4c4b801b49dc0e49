"""Drives: what a line's oil does to a joint, whatever stands between them - motor and gear, cylinder, bucket linkage, ram.

Each drive has a kernel `drive_KIND` that gives the two levers of a joint: the volume in m3 that a radian (or a metre) of it draws from
line A and gives to line B, which is also torque (or force) over pressure; and one `drive_KIND_slopes` for their slopes over the joint.
"""

from math import cos, pi, sin, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import SinCos
from polydraulic.machine.actuator import Triangle, lever_arm, lever_slope, motor_displacement
from polydraulic.parameters.layout import geometry
from polydraulic.parameters.layout.parts import CylinderSize, FourBar, LinkParameters, MachineFunction, Pins
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


class Knee(NamedTuple):
    """A bucket's linkage at a position: where its parts are, and how fast they turn over the joint; m."""

    pin_u: float
    pin_v: float
    rocker_u: float  # from the hinge to the knee
    rocker_v: float
    coupler_u: float  # from the knee to the pin
    coupler_v: float
    ram_u: float  # from the cylinder's base to the knee
    ram_v: float
    turn: float  # rate of the rocker over that of the link


@kernel
def _knee(joint: SinCos, r: Rocker) -> Knee:
    """Two circles give the knee, rigid rocker, coupler and link its speed."""
    pin_u = r.pin_u * joint.cos - r.pin_v * joint.sin
    pin_v = r.pin_u * joint.sin + r.pin_v * joint.cos
    du, dv = pin_u - r.hinge_u, pin_v - r.hinge_v
    square = du * du + dv * dv
    along = 0.5 * (square + r.difference) / square
    across = -r.side * sqrt(max(r.rocker / square - along * along, 0.0))
    rocker_u, rocker_v = along * du - across * dv, along * dv + across * du
    coupler_u, coupler_v = du - rocker_u, dv - rocker_v
    # the coupler keeps its length
    turn = (coupler_v * pin_u - coupler_u * pin_v) / (coupler_v * rocker_u - coupler_u * rocker_v)
    ram_u, ram_v = r.hinge_u + rocker_u - r.base_u, r.hinge_v + rocker_v - r.base_v
    return Knee(pin_u, pin_v, rocker_u, rocker_v, coupler_u, coupler_v, ram_u, ram_v, turn)


@kernel
def drive_four_bar(joint: SinCos, r: Rocker) -> JointLevers:
    """Levers of a bucket's cylinder."""
    k = _knee(joint, r)
    arm = r.direction * k.turn * (k.ram_v * k.rocker_u - k.ram_u * k.rocker_v)
    arm = arm / sqrt(k.ram_u * k.ram_u + k.ram_v * k.ram_v)
    return JointLevers(arm * r.area_a, arm * r.area_b)


@kernel
def drive_motor_slopes(joint: object, m: Motor) -> JointLevers:
    """Slopes of a motor's levers: none."""
    return JointLevers(0.0, 0.0)


@kernel
def drive_ram_slopes(joint: object, r: Ram) -> JointLevers:
    """Slopes of the levers of a cylinder along a prismatic joint: none."""
    return JointLevers(0.0, 0.0)


@kernel
def drive_cylinder_slopes(joint: SinCos, t: Triangle) -> JointLevers:
    """Slopes of the levers of a cylinder between two pins, m3/rad2."""
    slope = lever_slope(joint, lever_arm(joint, t), t)
    return JointLevers(slope * t.area_a, slope * t.area_b)


@kernel
def drive_four_bar_slopes(joint: SinCos, r: Rocker) -> JointLevers:
    """Slopes of the levers of a bucket's cylinder, m3/rad2: the pin turns with the link, the rocker `turn` times as fast."""
    k = _knee(joint, r)
    rocker_du, rocker_dv = -k.turn * k.rocker_v, k.turn * k.rocker_u
    coupler_du, coupler_dv = -k.pin_v - rocker_du, k.pin_u - rocker_dv
    right = k.coupler_v * k.pin_u - k.coupler_u * k.pin_v
    left = k.coupler_v * k.rocker_u - k.coupler_u * k.rocker_v
    right_d = coupler_dv * k.pin_u - k.coupler_v * k.pin_v - coupler_du * k.pin_v - k.coupler_u * k.pin_u
    left_d = coupler_dv * k.rocker_u + k.coupler_v * rocker_du - coupler_du * k.rocker_v - k.coupler_u * rocker_dv
    turn_d = (right_d - right / left * left_d) / left
    reach = k.ram_v * k.rocker_u - k.ram_u * k.rocker_v
    # the knee moves with the rocker, and so does the cylinder's end
    reach_d = rocker_dv * k.rocker_u + k.ram_v * rocker_du - rocker_du * k.rocker_v - k.ram_u * rocker_dv
    length = sqrt(k.ram_u * k.ram_u + k.ram_v * k.ram_v)
    length_d = (k.ram_u * rocker_du + k.ram_v * rocker_dv) / length
    slope = r.direction * (turn_d * reach + k.turn * (reach_d - reach / length * length_d)) / length
    return JointLevers(slope * r.area_a, slope * r.area_b)
