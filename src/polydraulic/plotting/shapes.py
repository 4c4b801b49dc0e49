"""The linkage as it is drawn: pins and cylinders from the parameter set, and outlines round them.

Each link has its own frame: x along its pin line from its joint, y upward where the link is level. Upper structure and tracks have
the swing axis at the height of the boom foot as origin. Pins, lengths, cylinder triangles and end stops are the machine's; outlines,
ground, cab and bucket are there for the eye alone.
"""

from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from polydraulic.parameters.schema import Cylinder, Machine, Stops

Points = list[tuple[float, float]]

AT_STOP = 2e-3  # rad; the loop halts a joint up to a step short of its stop
GROUND = -1.65  # m, below the boom foot
_ABOVE_BOOM = (
    12.0 * pi / 180.0
)  # where the stick cylinder's base pin lies, seen from the stick joint; the rod pin makes up for it


class Ram(NamedTuple):
    """A cylinder as drawn."""

    base: tuple[float, float]  # pin, in the frame of the link that carries it
    rod: tuple[float, float]  # pin, in the frame of the link that it moves
    barrel: float  # m


class Shapes(NamedTuple):
    """What is drawn of a machine, m and rad."""

    a1: float
    d: float
    boom_length: float
    stick_length: float
    boom_ram: Ram  # base in the upper structure's frame
    stick_ram: Ram  # base in the boom's frame
    stops: dict[str, tuple[float, float]]  # joints that have any
    boom: Points
    stick: Points
    bucket: Points
    upper: Points
    cab: Points
    window: Points
    track: Points
    upper_top: Points
    cab_top: Points
    tracks_top: tuple[Points, Points]


class Pose(NamedTuple):
    """Pins in the plane of boom and stick, m: outward from the swing axis, upward from the boom foot."""

    foot: np.ndarray
    boom_base: np.ndarray
    boom_rod: np.ndarray
    stick_base: np.ndarray
    joint: np.ndarray
    stick_rod: np.ndarray
    tip: np.ndarray


def linkage_shapes(machine: Machine) -> Shapes:
    """Collect what is drawn of a machine.

    Parameters
    ----------
    machine : Machine
    """
    g, boom, stick = machine.geometry, machine.boom.cylinder, machine.stick.cylinder
    long, short = g.boom_length, g.stick_length
    below = stick.angle_offset + _ABOVE_BOOM
    boom_ram = Ram(
        (g.a1 + boom.r_base * cos(boom.angle_offset), -boom.r_base * sin(boom.angle_offset)),
        (boom.r_link, 0.0),
        _barrel(boom, machine.boom.stops, 1.0),
    )
    stick_ram = Ram(
        (long - stick.r_base * cos(_ABOVE_BOOM), stick.r_base * sin(_ABOVE_BOOM)),
        (-stick.r_link * cos(below), stick.r_link * sin(below)),
        _barrel(stick, machine.stick.stops, -1.0),
    )
    stops = {link: getattr(machine, link).stops for link in ("swing", "boom", "stick")}
    tail, ahead = stick_ram.rod, g.a1 + 0.55
    return Shapes(
        a1=g.a1,
        d=g.d,
        boom_length=long,
        stick_length=short,
        boom_ram=boom_ram,
        stick_ram=stick_ram,
        stops={link: (s.low, s.high) for link, s in stops.items() if s.high - s.low < 2.0 * pi},
        boom=[
            (-0.12, -0.1), (-0.12, 0.12), (0.34 * long, 0.35), (0.46 * long, 0.44), (0.6 * long, 0.42), (long, 0.13),
            (long + 0.1, 0.0), (long, -0.13), (0.56 * long, 0.06), (boom.r_link + 0.15, -0.05), (boom.r_link, -0.1),
            (boom.r_link - 0.2, -0.05), (0.0, -0.16),
        ],
        stick=[
            (tail[0] - 0.08, tail[1] - 0.06), (tail[0] - 0.04, tail[1] + 0.09), (0.0, 0.22), (short, 0.09),
            (short + 0.06, 0.0), (short, -0.09), (0.1, -0.2), (-0.12, -0.12),
        ],
        bucket=[
            (short - 0.12, 0.02), (short + 0.18, 0.1), (short + 0.62, -0.05), (short + 0.78, -0.5),
            (short + 0.42, -0.98), (short + 0.3, -0.62), (short + 0.05, -0.45),
        ],
        upper=[
            (-2.6, -0.72), (-2.72, -0.1), (-2.6, 0.42), (-1.3, 0.5), (-0.35, 0.5), (0.3, 0.3), (ahead - 0.25, 0.14),
            (ahead, -0.3), (ahead, -0.72),
        ],
        cab=[(-0.42, -0.3), (-0.42, 1.3), (0.42, 1.3), (0.78, 0.35), (0.78, -0.3)],
        window=[(-0.3, 0.42), (-0.3, 1.18), (0.35, 1.18), (0.62, 0.42)],
        track=[
            (-1.75, GROUND), (-2.05, GROUND + 0.3), (-1.85, GROUND + 0.78), (1.85, GROUND + 0.78), (2.05, GROUND + 0.3),
            (1.75, GROUND),
        ],
        upper_top=[(-2.55, -1.25), (-2.72, -0.7), (-2.72, 0.7), (-2.55, 1.25), (ahead, 1.25), (ahead, -1.25)],
        cab_top=[(-0.45, 0.45), (-0.45, 1.2), (ahead, 1.2), (ahead, 0.45)],
        tracks_top=(_rectangle(-2.0, -1.5, 2.0, -0.9), _rectangle(-2.0, 0.9, 2.0, 1.5)),
    )  # fmt: skip


def pose(shapes: Shapes, boom: float, stick: float) -> Pose:
    """Pins at a boom angle and a stick angle in rad."""
    foot = np.array([shapes.a1, 0.0])
    joint = placed([(shapes.boom_length, 0.0)], foot, boom)[0]
    return Pose(
        foot=foot,
        boom_base=np.array(shapes.boom_ram.base),
        boom_rod=placed([shapes.boom_ram.rod], foot, boom)[0],
        stick_base=placed([shapes.stick_ram.base], foot, boom)[0],
        joint=joint,
        stick_rod=placed([shapes.stick_ram.rod], joint, boom + stick)[0],
        tip=placed([(shapes.stick_length, 0.0)], joint, boom + stick)[0],
    )


def placed(points: Points, origin: np.ndarray, angle: float) -> np.ndarray:
    """Points of a frame that is turned by `angle` and moved to `origin`, (n, 2)."""
    c, s = cos(angle), sin(angle)
    return np.asarray(origin + np.asarray(points) @ np.array([[c, s], [-s, c]]))


def seen_from_above(shapes: Shapes, reach: float, start: float, half_width: float) -> Points:
    """A link in the upper structure's frame, between two distances from the swing axis."""
    return _rectangle(start, shapes.d - half_width, reach, shapes.d + half_width)


def _barrel(cylinder: Cylinder, stops: Stops, direction: float) -> float:
    """Nine tenths of the cylinder's shortest length."""
    both = cylinder.r_base**2 + cylinder.r_link**2, 2.0 * cylinder.r_base * cylinder.r_link
    lengths = [(both[0] - both[1] * cos(cylinder.angle_offset + direction * angle)) ** 0.5 for angle in stops]
    return 0.9 * min(lengths)


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> Points:
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
