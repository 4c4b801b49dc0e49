"""Where the tip of a machine can be, in the plane in which its arm stands at the start; and lines and points that it reaches there."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.parts import GROUND
from polydraulic.parameters.layout.schema import LayoutMachine

_MOST = 40_000  # positions that are tried
_ROWS = 60  # of the grid, over the reach


class Reach(NamedTuple):
    """Tips at many positions of the joints.

    Attributes
    ----------
    joints : (n, n_function) array, rad or m
    tips : (n, 3) array, m
    out : (n,) array, m
        How far they are from the upright axis, or along x.
    size : float, m
        From the nearest or lowest to the farthest or highest.
    swing : int or None
        Number of the joint about an upright axis.
    """

    joints: np.ndarray
    tips: np.ndarray
    out: np.ndarray
    size: float
    swing: int | None


def tips_at(machine: LayoutMachine, joints: np.ndarray) -> np.ndarray:
    """Place of the tip, (n, 3) in m, at positions (n, n_function) in rad or m."""
    return placed(link_frames(machine, joints), *machine.tip)


def reach_of(machine: LayoutMachine) -> Reach:
    """Try positions all over the joints' travel, a tenth of it left out at either end; a joint about an upright axis stays."""
    swing = next((k for k, f in enumerate(machine.functions) if _upright(machine, f.moves)), None)
    moving = [k for k in range(len(machine.names)) if k != swing]
    each = max(int(_MOST ** (1.0 / max(len(moving), 1))), 3)
    axes = [np.linspace(*_travel(machine, k), each) for k in moving]
    joints = np.tile([f.initial.angle for f in machine.functions], (each ** len(moving), 1))
    joints[:, moving] = np.stack([x.ravel() for x in np.meshgrid(*axes, indexing="ij")], axis=-1)
    tips = tips_at(machine, joints)
    start = tips_at(machine, joints[:1] * 0.0 + [f.initial.angle for f in machine.functions])[0]
    heading = start[:2] / np.linalg.norm(start[:2]) if np.linalg.norm(start[:2]) > 0.0 else np.array([1.0, 0.0])
    out = tips[:, :2] @ heading
    return Reach(joints, tips, out, float(max(np.ptp(out), np.ptp(tips[:, 2]))), swing)


def level_line(reach: Reach, height: float) -> np.ndarray:
    """Ends of the longest level line that the tip reaches near a height in m, from far to near, without its outer fifths: (2, 3) in m."""
    cell = reach.size / _ROWS
    rows = np.round(reach.tips[:, 2] / cell).astype(int)
    spans = {}
    for row in np.unique(rows):
        columns = np.unique(np.round(reach.out[rows == row] / cell).astype(int))
        runs = np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1)
        longest = max(runs, key=len)
        spans[int(row)] = (int(longest[0]), int(longest[-1]))
    enough = 0.6 * max(last - first for first, last in spans.values())
    able = [row for row, (first, last) in spans.items() if last - first >= enough]
    row = min(able, key=lambda r: abs(r * cell - height))
    first, last = (end * cell for end in spans[row])
    ends = (last - 0.2 * (last - first), first + 0.2 * (last - first))
    direction = _direction(reach)
    return np.array([[*(end * direction), row * cell] for end in ends])


def joints_near(reach: Reach, out: float, height: float) -> np.ndarray:
    """Positions (n_function,) at which the tip is nearest to a place in the plane."""
    return reach.joints[np.argmin(np.hypot(reach.out - out, reach.tips[:, 2] - height))].copy()


def _direction(reach: Reach) -> np.ndarray:
    far = int(np.argmax(np.abs(reach.out)))
    return reach.tips[far, :2] / reach.out[far]


def _upright(machine: LayoutMachine, name: str) -> bool:
    link = machine.link(name)
    return link.joint == "revolute" and link.axis[-1] == "z" and link.parent == GROUND


def _travel(machine: LayoutMachine, k: int) -> tuple[float, float]:
    low, high = machine.functions[k].stops[:2]
    room = 0.1 * (high - low)
    return low + room, high - room
