"""What is drawn of a machine: a tree of links, and what hangs on it - outlines, cylinders, pins, end stops.

Every part is points on links, so that side view, view from above, still pictures, GIFs and pages place all of them in one way. The side view lies
in the plane of the arm, which turns with a first joint about an upright axis; without one it is the plane of x and z.
"""

from collections.abc import Sequence
from math import atan2, pi
from typing import Literal, NamedTuple

import numpy as np

from polydraulic.machine.frames import Frames, tree_frames, vector
from polydraulic.parameters.layout.geometry import BucketLinkage, knee_at
from polydraulic.parameters.layout.parts import LinkParameters

AT_STOP = 2e-3  # rad or m; the loop halts a joint up to a step short of its stop
PLANE = "plane of the arm"  # what always shows the same side: x outward from the upright axis, z as of the ground
OF_RUN, OPEN = "run", "none"  # fills of a body: the colour of its run, and none at all
_ROUND = np.column_stack([np.cos(np.arange(24) * pi / 12.0), np.sin(np.arange(24) * pi / 12.0)])
View = Literal["side", "top"]


class Spot(NamedTuple):
    """A point on a link, in its frame, m."""

    link: str
    at: tuple[float, float, float]


class Outline(NamedTuple):
    """An outline: the polygon of its spots, or, if there are radii, the hull of balls around them.

    Attributes
    ----------
    spots : tuple of Spot
    radii : tuple of float, m
    views : tuple of View
        Where it is drawn.
    fill, edge : str
        Colours. Bodies of the first run alone have a colour of their own, others are `OF_RUN` or `OPEN`, which is dashed.
    across : tuple of (low, high), m
        In space: from where to where it reaches across its plane, once for each part. Outlines of a view from above alone have none.
    """

    spots: tuple[Spot, ...]
    radii: tuple[float, ...]
    views: tuple[View, ...]
    fill: str
    edge: str = OF_RUN
    across: tuple[tuple[float, float], ...] = ()


class DrawnCylinder(NamedTuple):
    """A cylinder between two pins, its barrel at the first."""

    base: Spot
    rod: Spot
    barrel: float  # m


class Travel(NamedTuple):
    """Where a joint may go: a line on the parent link from end to end, and a tick at each."""

    joint: int  # place among the links
    low: float  # rad or m
    high: float
    path: tuple[Spot, ...]
    ticks: tuple[tuple[Spot, Spot], tuple[Spot, Spot]]
    view: View


class Follower(NamedTuple):
    """A link that has no position of its own: the rocker of a four-bar linkage, which follows the joint that it moves."""

    joint: int
    rocker: BucketLinkage


class Drawing(NamedTuple):
    """All that is drawn of a machine, m and rad.

    Attributes
    ----------
    names : tuple of str
        The functions, whose positions runs hold.
    initial : tuple of float
        Positions of their joints at the start, rad or m.
    travel : tuple of (low, high)
        How far their joints may go.
    links : tuple of LinkParameters
        Those that the functions move, in the same order, then the followers.
    followers : tuple of Follower
    slews : bool
        Whether the first link turns about an upright axis, and the side view with it.
    bodies : tuple of Outline
        Lowest first.
    rams, stops
    pins : mapping from name to Spot
    tip : Spot
    clear : tuple of (Spot, float)
        What views must show wherever it goes, with so much room round it.
    corners : mapping from View to (low, high)
        What they show at least.
    ground : float
        Height of the ground.
    scale : float
        Length of the scale bar.
    """

    names: tuple[str, ...]
    initial: tuple[float, ...]
    travel: tuple[tuple[float, float], ...]
    links: tuple[LinkParameters, ...]
    followers: tuple[Follower, ...]
    slews: bool
    bodies: tuple[Outline, ...]
    rams: tuple[DrawnCylinder, ...]
    stops: tuple[Travel, ...]
    pins: dict[str, Spot]
    tip: Spot
    clear: tuple[tuple[Spot, float], ...]
    corners: dict[View, tuple[tuple[float, float], tuple[float, float]]]
    ground: float
    scale: float


class DrawnMotion(NamedTuple):
    """Where all links of a drawing are, frame by frame."""

    positions: np.ndarray  # (n_frame, n_link) rad or m
    frames: Frames
    heading: np.ndarray  # (n_frame,) rad, of the plane of the arm
    axis: np.ndarray  # (3,) m, a point of the upright axis


def motion_of(drawing: Drawing, positions: np.ndarray) -> DrawnMotion:
    """Place the links of a drawing.

    Parameters
    ----------
    drawing : Drawing
    positions : (n_frame, n_function) array, rad or m
    """
    followed = [_rocker_angles(f.rocker, positions[:, f.joint]) for f in drawing.followers]
    whole = np.column_stack([positions, *followed])
    first = drawing.links[0]
    turn = positions[:, 0] * (-1.0 if first.axis[0] == "-" else 1.0)
    heading, axis = (turn, vector(first.at)) if drawing.slews else (np.zeros(len(positions)), np.zeros(3))
    plane = (_upright(heading), np.broadcast_to(axis * (1.0, 1.0, 0.0), (len(positions), 3)))
    return DrawnMotion(whole, {**tree_frames(drawing.links, whole), PLANE: plane}, heading, axis)


def _upright(heading: np.ndarray) -> np.ndarray:
    """Turns about the vertical axis, (n, 3, 3)."""
    c, s = np.cos(heading), np.sin(heading)
    nought, one = np.zeros(len(heading)), np.ones(len(heading))
    return np.stack([c, -s, nought, s, c, nought, nought, nought, one], axis=-1).reshape(-1, 3, 3)


def _rocker_angles(rocker: BucketLinkage, joint: np.ndarray) -> np.ndarray:
    """How far a rocker has turned from where it is with its joint at zero; it stays where the linkage comes to its end."""
    angles, before = np.zeros(len(joint)), _rocker_angle(rocker, 0.0) or 0.0
    zero = before
    for k, angle in enumerate(joint):
        found = _rocker_angle(rocker, angle)
        before = before if found is None else before + (found - before + pi) % (2.0 * pi) - pi
        angles[k] = before - zero
    return angles


def _rocker_angle(rocker: BucketLinkage, joint: float) -> float | None:
    found = knee_at(rocker, joint)
    return None if found is None else atan2(found[0][1] - rocker.hinge[1], found[0][0] - rocker.hinge[0])


def places(motion: DrawnMotion, spots: Sequence[Spot]) -> np.ndarray:
    """Spots in the ground's frame, (n_frame, n_spot, 3) in m."""
    found = np.empty((len(motion.positions), len(spots), 3))
    for place, (link, at) in enumerate(spots):
        turn, origin = motion.frames[link]
        found[:, place] = origin + turn @ np.array(at)
    return found


def seen(motion: DrawnMotion, view: View, points: np.ndarray) -> np.ndarray:
    """Points of the ground's frame as a view shows them: (n_frame, n, 3) to (n_frame, n, 2)."""
    if view == "top":
        return points[..., :2]
    x, y, _ = np.moveaxis(points - motion.axis, -1, 0)
    heading = motion.heading[:, None]
    return np.stack([x * np.cos(heading) + y * np.sin(heading), points[..., 2]], axis=-1)


def silhouette(points: np.ndarray, radii: Sequence[float]) -> np.ndarray:
    """Corners of a body's outline in a view: (n, 2) to (m, 2)."""
    from scipy.spatial import ConvexHull

    if not radii:
        return points
    cloud = (points[:, None, :] + np.asarray(radii)[:, None, None] * _ROUND).reshape(-1, 2)
    return np.asarray(cloud[ConvexHull(cloud).vertices])


def view_limits(drawing: Drawing, motions: Sequence[DrawnMotion], view: View) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of a view that shows all of the machine wherever it goes, m."""
    low, high = (np.array(corner) for corner in drawing.corners[view])
    room = np.array([margin for _, margin in drawing.clear])[:, None]
    for motion in motions:
        points = seen(motion, view, places(motion, [spot for spot, _ in drawing.clear]))
        low = np.minimum(low, (points - room).min(axis=(0, 1)))
        high = np.maximum(high, (points + room).max(axis=(0, 1)))
    return low, high
