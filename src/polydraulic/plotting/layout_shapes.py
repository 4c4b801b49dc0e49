"""A machine of any layout as it is drawn: what its file says, and bars around it.

A link is the hull of balls round its joint, the joints of its children, its pins and the tip; one that a four-bar linkage moves and that holds
the tip is a bucket, and a first link that turns about an upright axis and outweighs its arm is the upper structure of an excavator. All sizes that
no file gives follow the machine's reach.
"""

from collections.abc import Iterator
from math import cos, floor, hypot, log10, pi, sqrt
from typing import NamedTuple

import numpy as np

from polydraulic.machine.frames import vector
from polydraulic.machine.reach.tip import slewing_function
from polydraulic.parameters.layout.geometry import knee_at, rocker, triangle
from polydraulic.parameters.layout.parts import GROUND, FourBar, LinkParameters, MachineFunction, Pins
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.plotting.carrier import DEPTH, block, excavator_bodies, scale_of
from polydraulic.plotting.drawing import OF_RUN, Drawing, DrawnCylinder, Follower, Outline, Spot, Travel
from polydraulic.plotting.travel import across, joint_stops, signed_axis

_THICK, _SLIMMER = 0.026, 0.86  # radius of a first link by reach, and of each next link by the one before
_PIN = 0.55  # radius round a pin, by that of its link
_BROAD = 0.75  # half of a link's breadth, by its radius
# a bucket seen along its joint: from joint to teeth, and to the side of its shell, by its length
_SHELL = ((0.1, 0.42), (0.42, 0.55), (0.76, 0.47), (1.0, 0.0), (0.68, 0.05), (0.4, -0.06))


class _Bones(NamedTuple):
    """Points that a link must reach, in its frame: joints and tip, and pins."""

    joints: list[np.ndarray]
    pins: list[np.ndarray]

    @property
    def far(self) -> np.ndarray:
        """The one that is farthest from the link's joint."""
        return max([*self.joints, *self.pins], key=lambda point: float(np.linalg.norm(point)))


class _Linkage(NamedTuple):
    """A four-bar linkage: its function's name, its joint's place, the link that it moves."""

    name: str
    joint: int
    link: LinkParameters
    pins: FourBar


def layout_drawing(machine: LayoutMachine) -> Drawing:
    """Collect what is drawn of a machine of any layout.

    Parameters
    ----------
    machine : LayoutMachine
    """
    moved = [machine.link(f.moves) for f in machine.functions]
    linkages = [
        _Linkage(f.name, k, moved[k], f.pins) for k, f in enumerate(machine.functions) if isinstance(f.pins, FourBar)
    ]
    rockers = [
        LinkParameters(_rocker(x.name), x.link.parent, "revolute", x.link.axis, x.pins.hinge, 0.0, {}, {})
        for x in linkages
    ]
    bones = {link.name: _bones(machine, link) for link in moved}
    reach = _reach(machine, bones)
    slews = slewing_function(machine) is not None
    sizes = _sizes(moved, reach, slews)
    arms = [body for link in reversed(moved) for body in _bodies(machine, link, bones[link.name], sizes[link.name])]
    bars = [bar for linkage in linkages for bar in _bars(linkage, 0.45 * sizes[linkage.link.parent])]
    standing, ground = _standing(machine, bones, reach, slews)
    hidden = {spot.link for body in standing for spot in body.spots}
    tip = _spot(machine.tip[0], vector(machine.tip[1]))
    shown = [body for body in [*arms, *bars] if body.spots[0].link not in hidden]
    side = 0.38 * reach
    x, y, _ = vector(moved[0].at)
    outward = 0.0 if slews else x
    return Drawing(
        names=machine.names,
        initial=tuple(f.initial.angle for f in machine.functions),
        travel=tuple((f.stops.low, f.stops.high) for f in machine.functions),
        links=(*moved, *rockers),
        followers=tuple(Follower(x.joint, rocker(x.pins, x.link)) for x in linkages),
        slews=slews,
        bodies=(*standing, *shown),
        rams=tuple(ram for f in machine.functions if (ram := _ram(machine, f)) is not None),
        stops=tuple(_travels(machine, bones, sizes)),
        pins=dict(_pins(machine)) | {"tip": tip},
        tip=tip,
        clear=tuple((spot, 0.05 * reach) for spot in dict.fromkeys([tip, *(s for b in shown for s in b.spots)])),
        corners={
            "side": ((outward - side, ground - 0.08 * reach), (outward + side, ground + 0.35 * reach)),
            "top": ((x - side, y - side), (x + side, y + side)),
        },
        ground=ground,
        scale=10.0 ** floor(log10(reach / 3.0)),
    )


def _bones(machine: LayoutMachine, link: LinkParameters) -> _Bones:
    """What a link carries; a link that carries nothing ends as far behind its centre of gravity as it began before it."""
    children = [vector(other.at) for other in machine.links if other.parent == link.name]
    tips = [vector(machine.tip[1])] if machine.tip[0] == link.name else []
    pins = [
        np.array(spot.at) for name, spot in _pins(machine) if spot.link == link.name and name != f"{link.name} joint"
    ]
    centre = vector(link.cg)
    farthest = max((float(np.linalg.norm(point)) for point in [*children, *tips, *pins]), default=0.0)
    ends = [2.0 * centre] if not tips and farthest < float(np.linalg.norm(centre)) else []
    return _Bones([np.zeros(3), *children, *tips, *ends], pins)


def _pins(machine: LayoutMachine) -> Iterator[tuple[str, Spot]]:
    """Joints by the names of their links, and pins by those of their functions."""
    for link in machine.links:
        if link.joint == "revolute" and link.axis[-1] != "z":
            yield f"{link.name} joint", Spot(link.name, (0.0, 0.0, 0.0))
    for f in machine.functions:
        link = machine.link(f.moves)
        if isinstance(f.pins, Pins):
            yield f"{f.name} base", _spot(link.parent, vector(f.pins.base))
            yield f"{f.name} rod pin", _spot(link.name, vector(f.pins.rod))
        if isinstance(f.pins, FourBar):
            yield f"{f.name} base", _spot(link.parent, vector(f.pins.base))
            yield f"{f.name} hinge", _spot(link.parent, vector(f.pins.hinge))
            yield f"{f.name} knee", _knee(f.name, f.pins)
            yield f"{f.name} pin", _spot(link.name, vector(f.pins.pin))


def _rocker(function: str) -> str:
    """Name of a function's rocker as a link, with a space, which no other link's has."""
    return f"{function} rocker"


def _knee(function: str, pins: FourBar) -> Spot:
    return _spot(_rocker(function), vector(pins.knee) - vector(pins.hinge))


def _reach(machine: LayoutMachine, bones: dict[str, _Bones]) -> float:
    """Longest way along the links from the ground, all joints that slide at their ends, m."""
    ways, longest = {GROUND: 0.0}, 0.0
    for f in machine.functions:
        link = machine.link(f.moves)
        slide = max(abs(f.stops.low), abs(f.stops.high)) if link.joint == "prismatic" else 0.0
        from_ground = link.parent == GROUND  # where the first joints stand is no reach
        ways[link.name] = ways[link.parent] + slide + (0.0 if from_ground else float(np.linalg.norm(vector(link.at))))
        longest = max(longest, ways[link.name] + float(np.linalg.norm(bones[link.name].far)))
    return max(longest, 0.1)


def _sizes(links: list[LinkParameters], reach: float, slews: bool) -> dict[str, float]:
    """Radius of each link, m."""
    sizes = {GROUND: _THICK * reach / _SLIMMER}
    for place, link in enumerate(links):
        sizes[link.name] = sizes[link.parent] * (1.0 if slews and place == 0 else _SLIMMER)
    return sizes


def _bodies(machine: LayoutMachine, link: LinkParameters, bones: _Bones, size: float) -> tuple[Outline, ...]:
    """The outline of a link; what slides is seen from where it leaves its guide."""
    f = next(f for f in machine.functions if f.moves == link.name)
    if isinstance(f.pins, FourBar) and machine.tip[0] == link.name:
        return _bucket(link, bones, vector(f.pins.pin), size)
    spots = [(_spot(link.name, point), size) for point in bones.joints]
    spots += [(_spot(link.name, point), _PIN * size) for point in bones.pins]
    if link.joint == "prismatic":
        spots.append((_spot(link.parent, vector(link.at)), size))
    broad = ((-_BROAD * size, _BROAD * size),)
    return (Outline(tuple(s for s, _ in spots), tuple(r for _, r in spots), ("side", "top"), OF_RUN, across=broad),)


def _bucket(link: LinkParameters, bones: _Bones, pin: np.ndarray, size: float) -> tuple[Outline, ...]:
    """A shell on the side of the centre of gravity, or of the pin if that is close to the line to the teeth; and how it looks from above."""
    axis, teeth = signed_axis(link), bones.joints[-1]
    ahead = across(link, teeth)
    left = np.cross(axis, ahead)
    length, beside = float(ahead @ teeth), float(left @ vector(link.cg))
    side = 1.0 if (beside if abs(beside) > 0.15 * length else left @ pin) >= 0.0 else -1.0
    half = 3.5 * size
    joint, broad = np.zeros(3), half * axis
    shell = [joint, *(length * (along * ahead + side * off * left) for along, off in _SHELL)]
    ears = (_spot(link.name, joint), _spot(link.name, pin), _spot(link.name, 0.5 * shell[1]))
    return (
        Outline(ears, (size, _PIN * size, 0.1 * size), ("side",), OF_RUN, across=((-_BROAD * size, _BROAD * size),)),
        Outline(tuple(_spot(link.name, corner) for corner in shell), (), ("side",), OF_RUN, across=((-half, half),)),
        Outline(
            tuple(_spot(link.name, corner) for corner in (joint - broad, teeth - broad, teeth + broad, joint + broad)),
            (),
            ("top",),
            OF_RUN,
        ),
    )


def _bars(linkage: _Linkage, size: float) -> list[Outline]:
    """Rocker and coupler."""
    knee = _knee(linkage.name, linkage.pins)
    ends = (Spot(knee.link, (0.0, 0.0, 0.0)), _spot(linkage.link.name, vector(linkage.pins.pin)))
    beside = ((-2.2 * size, -1.5 * size), (1.5 * size, 2.2 * size))
    return [Outline((knee, end), (size, size), ("side",), OF_RUN, across=beside) for end in ends]


def _ram(machine: LayoutMachine, f: MachineFunction) -> DrawnCylinder | None:
    if f.pins is None:
        return None
    link, base = machine.link(f.moves), _spot(machine.link(f.moves).parent, vector(f.pins.base))
    rod = _knee(f.name, f.pins) if isinstance(f.pins, FourBar) else _spot(link.name, vector(f.pins.rod))
    lengths = [_cylinder_length(f, link, joint) for joint in np.linspace(f.stops.low, f.stops.high, 41)]
    return DrawnCylinder(base, rod, 0.9 * min(lengths))


def _cylinder_length(f: MachineFunction, link: LinkParameters, joint: float) -> float:
    """Distance of a cylinder's pins in the plane of its joint, m."""
    if isinstance(f.pins, FourBar):
        linkage = rocker(f.pins, link)
        found = knee_at(linkage, joint)
        knee = found[0] if found is not None else linkage.hinge
        return hypot(knee[0] - linkage.base[0], knee[1] - linkage.base[1])
    assert f.pins is not None
    t = triangle(f.pins, link)
    return sqrt(t.r_base**2 + t.r_rod**2 - 2.0 * t.r_base * t.r_rod * cos(t.offset + t.direction * joint))


def _standing(
    machine: LayoutMachine, bones: dict[str, _Bones], reach: float, slews: bool
) -> tuple[tuple[Outline, ...], float]:
    """What the arm stands on, and the height of the ground: that of the chassis' contacts, where the file has any."""
    stands = None if machine.chassis is None else min(corner[2] for corner in machine.chassis.corners)
    first, *others = (machine.link(f.moves) for f in machine.functions)
    feet = [vector(link.at) for link in machine.links if link.parent == first.name and link.joint == "revolute"]
    if (
        slews and feet and first.mass > sum(link.mass for link in others)
    ):  # it holds a counterweight, unlike a crane's column
        axis, foot, scale = vector(first.at), feet[0], scale_of(reach)
        lowest = min((float(pin[2] - foot[2]) for pin in bones[first.name].pins), default=0.0)
        height = float(axis[2] + foot[2])
        depth = DEPTH * scale if stands is None or stands >= height else height - stands
        return excavator_bodies(first.name, axis, foot, scale, lowest, depth), height - depth
    fixed = [vector(link.at) for link in machine.links if link.parent == GROUND]
    fixed += [np.array(spot.at) for _, spot in _pins(machine) if spot.link == GROUND]
    low, high = np.min(fixed, axis=0), np.max(fixed, axis=0)
    ground = min(0.0, float(low[2]) - 0.1 * reach) if stands is None else stands
    room = reach * np.array([0.1, 0.1, 0.0])
    behind, axis = (room, vector(first.at)) if slews else (3.5 * room, np.zeros(3))
    return block((float(low[0] - behind[0]), float(low[1] - room[1]), ground), high + room, axis), ground


def _travels(machine: LayoutMachine, bones: dict[str, _Bones], sizes: dict[str, float]) -> Iterator[Travel]:
    for place, f in enumerate(machine.functions):
        link = machine.link(f.moves)
        ends = (f.stops.low, f.stops.high)
        if link.joint == "prismatic":
            yield joint_stops(place, link, ends, 1.8 * sizes[link.parent])
        elif ends[1] - ends[0] < 2.0 * pi:
            yield joint_stops(place, link, ends, 5.6 * sizes[link.name], bones[link.name].far)


def _spot(link: str, point: np.ndarray) -> Spot:
    x, y, z = (float(value) for value in point)
    return Spot(link, (x, y, z))
