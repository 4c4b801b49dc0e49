"""How far a joint may go, as it is drawn: an arc or a line on the parent link, with a tick at each end."""

from collections.abc import Callable
from math import cos, sin

import numpy as np

from polydraulic.machine.frames import vector
from polydraulic.parameters.layout.parts import LinkParameters
from polydraulic.plotting.drawing import Spot, Travel

_AXES = {"x": 0, "y": 1, "z": 2}
_POINTS = 40


def signed_axis(link: LinkParameters) -> np.ndarray:
    """Direction of a link's joint, (3,)."""
    return np.eye(3)[_AXES[link.axis[-1]]] * (-1.0 if link.axis[0] == "-" else 1.0)


def across(link: LinkParameters, point: np.ndarray) -> np.ndarray:
    """Direction of a point across a link's joint, (3,); some direction across it if the point lies on the axis."""
    axis = signed_axis(link)
    flat = point - axis * (axis @ point)
    size = float(np.linalg.norm(flat))
    return flat / size if size > 1e-9 else np.eye(3)[2 if link.axis[-1] == "x" else 0]


def joint_stops(
    joint: int, link: LinkParameters, ends: tuple[float, float], size: float, far: np.ndarray | None = None
) -> Travel:
    """Travel of a joint as it is drawn.

    Parameters
    ----------
    joint : int
        Place of the link among those that move.
    link : LinkParameters
    ends : (low, high), rad or m
    size : float, m
        Radius of the arc; distance of the line from the axis of a joint that slides.
    far : (3,) array, m, optional
        Where the link points to, in its frame; along x if not given.
    """
    far = np.array([1.0, 0.0, 0.0]) if far is None else far
    if link.joint == "prismatic":
        return _line(joint, link, ends, size)
    axis, ahead = signed_axis(link), across(link, far)
    left, at = np.cross(axis, ahead), vector(link.at)

    def point(angle: float, part: float) -> Spot:
        return _spot(link, at + part * size * (cos(angle) * ahead + sin(angle) * left))

    return _stops(joint, link, ends, point, (0.88, 1.12))


def _line(joint: int, link: LinkParameters, ends: tuple[float, float], size: float) -> Travel:
    axis, at = signed_axis(link), vector(link.at)
    beside = np.eye(3)[0 if link.axis[-1] == "z" else 2]

    def point(position: float, part: float) -> Spot:
        return _spot(link, at + position * axis + part * size * beside)

    return _stops(joint, link, ends, point, (0.8, 1.2))


def _stops(
    joint: int,
    link: LinkParameters,
    ends: tuple[float, float],
    point: Callable[[float, float], Spot],
    tick: tuple[float, float],
) -> Travel:
    low, high = ends
    upright = link.joint == "revolute" and link.axis[-1] == "z"
    return Travel(
        joint=joint,
        low=low,
        high=high,
        path=tuple(point(value, 1.0) for value in np.linspace(low, high, _POINTS)),
        ticks=((point(low, tick[0]), point(low, tick[1])), (point(high, tick[0]), point(high, tick[1]))),
        view="top" if upright else "side",
    )


def _spot(link: LinkParameters, point: np.ndarray) -> Spot:
    x, y, z = (float(value) for value in point)
    return Spot(link.parent, (x, y, z))
