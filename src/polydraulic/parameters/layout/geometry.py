"""Pins of cylinders and bucket linkages as the kernels want them: seen along the joint's axis.

A revolute joint turns the plane across its axis. In it lie two axes whose cross product is the joint's axis, so that a positive angle turns
the first towards the second; (u, v) are coordinates along them, from the joint.
"""

from math import atan2, cos, hypot, pi, sin, sqrt
from typing import NamedTuple

from polydraulic.parameters.layout.parts import FourBar, LinkParameters, MachineFunction, Pins, Point

_ACROSS = {"x": ("y", "z"), "y": ("z", "x"), "z": ("x", "y")}


class PinTriangle(NamedTuple):
    """Base pin, joint, rod pin: L^2 = r_base^2 + r_rod^2 + aside^2 - 2 r_base r_rod cos(psi), psi = offset + direction * angle."""

    r_base: float
    r_rod: float
    aside: float  # how far the pins are from each other along the joint's axis
    offset: float  # rad, above 0
    direction: float  # 1 where a positive angle lengthens the cylinder, -1 where it shortens it


class BucketLinkage(NamedTuple):
    """A bucket's linkage in the plane across its joint's axis, m; the joint is the origin."""

    base: tuple[float, float]
    hinge: tuple[float, float]
    pin: tuple[float, float]
    rocker: float
    coupler: float
    side: float  # 1 where hinge, knee, pin turn to the left, -1 to the right


def across_axis(point: Point, axis: str) -> tuple[float, float]:
    """Coordinates of a point across an axis."""
    first, second = _ACROSS[axis[-1]]
    u, v = point.get(first, 0.0), point.get(second, 0.0)
    return (u, v) if axis[0] != "-" else (v, u)


def from_joint(point: Point, link: LinkParameters) -> tuple[float, float]:
    """The same of a point in the parent's frame, seen from the link's joint."""
    u, v = across_axis(point, link.axis)
    u0, v0 = across_axis(link.at, link.axis)
    return u - u0, v - v0


def triangle(pins: Pins, link: LinkParameters) -> PinTriangle:
    """Triangle of a cylinder that moves a link."""
    base, rod = from_joint(pins.base, link), across_axis(pins.rod, link.axis)
    psi = atan2(rod[1], rod[0]) - atan2(base[1], base[0])
    psi = (psi + pi) % (2.0 * pi) - pi
    along = link.axis[-1]
    aside = pins.base.get(along, 0.0) - link.at.get(along, 0.0) - pins.rod.get(along, 0.0)
    return PinTriangle(hypot(*base), hypot(*rod), aside, abs(psi), 1.0 if psi >= 0.0 else -1.0)


def is_plane(pins: FourBar, link: LinkParameters) -> bool:
    """Whether all pins of a bucket's linkage lie in one plane across the joint's axis."""
    along = link.axis[-1]
    places = [point.get(along, 0.0) - link.at.get(along, 0.0) for point in (pins.base, pins.hinge, pins.knee)]
    return max(abs(place - pins.pin.get(along, 0.0)) for place in places) < 1e-9


def rocker(pins: FourBar, link: LinkParameters) -> BucketLinkage:
    """Linkage of a bucket."""
    base, hinge, knee = (from_joint(point, link) for point in (pins.base, pins.hinge, pins.knee))
    pin = across_axis(pins.pin, link.axis)
    arm, rest = (knee[0] - hinge[0], knee[1] - hinge[1]), (pin[0] - knee[0], pin[1] - knee[1])
    turn = arm[0] * rest[1] - arm[1] * rest[0]
    return BucketLinkage(base, hinge, pin, hypot(*arm), hypot(*rest), 1.0 if turn >= 0.0 else -1.0)


def knee_at(r: BucketLinkage, angle: float) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Knee and pin at a joint angle in rad, None where rocker and coupler do not reach each other."""
    c, s = cos(angle), sin(angle)
    pin = (r.pin[0] * c - r.pin[1] * s, r.pin[0] * s + r.pin[1] * c)
    dx, dy = pin[0] - r.hinge[0], pin[1] - r.hinge[1]
    square = dx * dx + dy * dy
    along = 0.5 * (square + r.rocker**2 - r.coupler**2) / max(square, 1e-300)
    across = r.rocker**2 / max(square, 1e-300) - along * along
    if across <= 0.0:
        return None
    h = -r.side * sqrt(across)
    return (r.hinge[0] + along * dx - h * dy, r.hinge[1] + along * dy + h * dx), pin


def lever(function: MachineFunction, link: LinkParameters, angle: float) -> float | None:
    """Extension of the cylinder per joint motion, m/rad (or 1), None where the linkage cannot be there."""
    if isinstance(function.pins, Pins):
        t = triangle(function.pins, link)
        psi = t.offset + t.direction * angle
        length = sqrt(max(t.r_base**2 + t.r_rod**2 + t.aside**2 - 2.0 * t.r_base * t.r_rod * cos(psi), 1e-300))
        return t.direction * t.r_base * t.r_rod * sin(psi) / length
    if isinstance(function.pins, FourBar):
        r = rocker(function.pins, link)
        found = knee_at(r, angle)
        if found is None:
            return None
        (kx, ky), (px, py) = found
        cx, cy, hx, hy = px - kx, py - ky, kx - r.hinge[0], ky - r.hinge[1]
        below = -cx * hy + cy * hx  # coupler on the knee's motion
        bx, by = kx - r.base[0], ky - r.base[1]
        turn = (-cx * py + cy * px) / below if below else 0.0
        return turn * (-bx * hy + by * hx) / max(hypot(bx, by), 1e-300)
    return 1.0
