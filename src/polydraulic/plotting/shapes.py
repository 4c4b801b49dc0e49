"""The machine of the older form as it is drawn: pins and cylinders from the parameter set, and outlines around them.

Each link has its own frame: x along its pin line from its joint, z upward where the link is level. The ground's origin is the swing axis at the
height of the boom foot. Pins, lengths, cylinder triangles and end stops are the machine's; outlines, ground, cab and bucket are there for
the eye alone.
"""

from collections.abc import Sequence
from math import cos, pi, sin

from polydraulic.parameters.layout.parts import GROUND, LinkParameters
from polydraulic.parameters.schema import LINKS, Cylinder, Machine, Stops
from polydraulic.plotting.carrier import DEPTH, excavator_bodies
from polydraulic.plotting.drawing import OF_RUN, OPEN, Drawing, DrawnCylinder, Outline, Spot
from polydraulic.plotting.travel import joint_stops

# where the stick cylinder's base pin lies, seen from the stick joint; the rod pin makes up for it
_ABOVE_BOOM = 12.0 * pi / 180.0


def excavator_drawing(machine: Machine) -> Drawing:
    """Collect what is drawn of swing, boom and stick.

    Parameters
    ----------
    machine : Machine
    """
    g, boom, stick = machine.geometry, machine.boom.cylinder, machine.stick.cylinder
    long, short = g.boom_length, g.stick_length
    below = stick.angle_offset + _ABOVE_BOOM
    links = (
        _link("swing", GROUND, "z", {}),
        _link("boom", "swing", "-y", {"x": g.a1, "y": g.d}),
        _link("stick", "boom", "-y", {"x": long}),
    )
    pins = {
        "boom joint": Spot("boom", (0.0, 0.0, 0.0)),
        "boom base": Spot("swing", (g.a1 + boom.r_base * cos(boom.angle_offset), g.d, -boom.r_base * sin(boom.angle_offset))),
        "boom rod pin": Spot("boom", (boom.r_link, 0.0, 0.0)),
        "stick joint": Spot("stick", (0.0, 0.0, 0.0)),
        "stick base": Spot("boom", (long - stick.r_base * cos(_ABOVE_BOOM), 0.0, stick.r_base * sin(_ABOVE_BOOM))),
        "stick rod pin": Spot("stick", (-stick.r_link * cos(below), 0.0, stick.r_link * sin(below))),
        "tip": Spot("stick", (short, 0.0, 0.0)),
    }  # fmt: skip
    tail = pins["stick rod pin"].at
    outlines = (
        _plate("stick", [
            (short - 0.12, 0.02), (short + 0.18, 0.1), (short + 0.62, -0.05), (short + 0.78, -0.5),
            (short + 0.42, -0.98), (short + 0.3, -0.62), (short + 0.05, -0.45),
        ], OPEN),
        _plate("stick", [
            (tail[0] - 0.08, tail[2] - 0.06), (tail[0] - 0.04, tail[2] + 0.09), (0.0, 0.22), (short, 0.09),
            (short + 0.06, 0.0), (short, -0.09), (0.1, -0.2), (-0.12, -0.12),
        ], OF_RUN),
        _plate("boom", [
            (-0.12, -0.1), (-0.12, 0.12), (0.34 * long, 0.35), (0.46 * long, 0.44), (0.6 * long, 0.42), (long, 0.13),
            (long + 0.1, 0.0), (long, -0.13), (0.56 * long, 0.06), (boom.r_link + 0.15, -0.05), (boom.r_link, -0.1),
            (boom.r_link - 0.2, -0.05), (0.0, -0.16),
        ], OF_RUN),
        _beam("stick", short, 0.17),
        _beam("boom", long, 0.24),
    )  # fmt: skip
    parts = [getattr(machine, link) for link in LINKS]
    travel = [(part.stops.low, part.stops.high) for part in parts]
    stops = [
        joint_stops(place, links[place], travel[place], radius)
        for place, radius in enumerate((2.9, 1.25, 0.95))
        if travel[place][1] - travel[place][0] < 2.0 * pi
    ]
    return Drawing(
        names=LINKS,
        initial=tuple(part.initial.angle for part in parts),
        travel=tuple(travel),
        links=links,
        followers=(),
        slews=True,
        bodies=(*excavator_bodies("swing", (0.0, 0.0, 0.0), (g.a1, 0.0, 0.0), 1.0), *outlines),
        rams=(
            DrawnCylinder(pins["boom base"], pins["boom rod pin"], _barrel(boom, machine.boom.stops, 1.0)),
            DrawnCylinder(pins["stick base"], pins["stick rod pin"], _barrel(stick, machine.stick.stops, -1.0)),
        ),
        stops=tuple(stops),
        pins=pins,
        tip=pins["tip"],
        clear=((pins["tip"], 1.0), (pins["stick joint"], 0.9)),
        corners={"side": ((-3.1, -DEPTH - 0.75), (4.0, 1.7)), "top": ((-3.1, -3.1), (3.1, 3.1))},
        ground=-DEPTH,
        scale=1.0,
    )


def _link(name: str, parent: str, axis: str, at: dict[str, float]) -> LinkParameters:
    return LinkParameters(name, parent, "revolute", axis, at, 0.0, {}, {})


def _plate(link: str, corners: Sequence[tuple[float, float]], fill: str) -> Outline:
    """A link from the side."""
    return Outline(tuple(Spot(link, (x, 0.0, z)) for x, z in corners), (), ("side",), fill)


def _beam(link: str, length: float, half_width: float) -> Outline:
    """A link from above."""
    corners = [(0.0, -half_width), (length, -half_width), (length, half_width), (0.0, half_width)]
    return Outline(tuple(Spot(link, (x, y, 0.0)) for x, y in corners), (), ("top",), OF_RUN)


def _barrel(cylinder: Cylinder, stops: Stops, direction: float) -> float:
    """Nine tenths of the cylinder's shortest length."""
    both = cylinder.r_base**2 + cylinder.r_link**2, 2.0 * cylinder.r_base * cylinder.r_link
    lengths = [(both[0] - both[1] * cos(cylinder.angle_offset + direction * angle)) ** 0.5 for angle in stops]
    return 0.9 * min(lengths)
