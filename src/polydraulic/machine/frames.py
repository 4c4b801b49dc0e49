"""Where the links of any machine are: frames and points at given joint positions, for tips and drawings."""

from collections.abc import Mapping, Sequence

import numpy as np

from polydraulic.parameters.layout.parts import COORDINATES, GROUND, LinkParameters, Point
from polydraulic.parameters.layout.schema import LayoutMachine

AXES = {"x": 0, "y": 1, "z": 2}
Frames = Mapping[str, tuple[np.ndarray, np.ndarray]]  # link -> (..., 3, 3) turn, (..., 3) origin in m


def vector(point: Point) -> np.ndarray:
    """A point as (3,) array in m."""
    return np.array([point.get(c, 0.0) for c in COORDINATES])


def link_frames(machine: LayoutMachine, positions: np.ndarray) -> Frames:
    """Turn and origin of every link, and of the ground.

    Parameters
    ----------
    machine : LayoutMachine
    positions : (..., n_function) array, rad or m
        Of the joints, in the order of the functions.
    """
    return tree_frames([machine.link(f.moves) for f in machine.functions], positions)


def tree_frames(links: Sequence[LinkParameters], positions: np.ndarray) -> Frames:
    """The same of links, parents first, each with its position (..., n_link)."""
    lead = positions.shape[:-1]
    frames = {GROUND: (np.broadcast_to(np.eye(3), (*lead, 3, 3)), np.zeros((*lead, 3)))}
    for place, link in enumerate(links):
        turn, origin = frames[link.parent]
        sign = -1.0 if link.axis[0] == "-" else 1.0
        axis, q = AXES[link.axis[-1]], sign * positions[..., place]
        at = vector(link.at) + (np.eye(3)[axis] * q[..., None] if link.joint == "prismatic" else 0.0)
        own = _about(axis, q) if link.joint == "revolute" else np.eye(3)
        frames[link.name] = (turn @ own, origin + np.einsum("...ij,...j->...i", turn, np.broadcast_to(at, (*lead, 3))))
    return frames


def placed(frames: Frames, link: str, point: Point) -> np.ndarray:
    """A point of a link in the ground's frame, (..., 3) in m."""
    turn, origin = frames[link]
    return np.asarray(origin + turn @ vector(point))


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    """Turn about one of the axes, (..., 3, 3)."""
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turn = np.zeros((*angle.shape, 3, 3))
    turn[..., axis, axis] = 1.0
    turn[..., first, first] = turn[..., second, second] = np.cos(angle)
    turn[..., second, first] = np.sin(angle)
    turn[..., first, second] = -np.sin(angle)
    return turn
