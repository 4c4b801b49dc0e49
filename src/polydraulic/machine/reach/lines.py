"""Level lines along which a machine can draw its tip, found by following them."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.reach.tip import joint_speeds, slew_sign, tip_at_joints, tip_jacobian
from polydraulic.machine.reach.travels import JointTravels, inward

SHORTEST = 0.5  # m
_LONGEST = 4.0  # m
_TRIED = 256  # poses
_ROOM = 0.05  # of the travel, at each end, where no joint comes
_STEP, _OFF = 0.02, 5e-3  # m along a line, and off it
_SLOWEST, _FASTEST = 0.1, 0.3  # m/s
_SHARE = 0.5  # of a joint's full speed, which a line may ask for


class Followed(NamedTuple):
    """Lines as far as they could be followed.

    Attributes
    ----------
    poses : (n, n_function) array, rad or m
        Where joints were then, or before.
    length : (n,) array, m
    speed : (n,) array, m/s
        At which joints can follow.
    """

    poses: np.ndarray
    length: np.ndarray
    speed: np.ndarray


def level_lines(travels: JointTravels, poses: np.ndarray, depth: float | None = None) -> Followed:
    """Lines of `SHORTEST` and more that begin in some of the poses and lead inward, the longest first; their poses are those at the beginning.

    Parameters
    ----------
    travels : JointTravels
    poses : (n, n_function) array, rad or m
    depth : float, m, optional
        Height of all lines, as the ground's z; that of the tip in each pose if not given.

    Returns
    -------
    Followed
        Of no lines, where none is long enough.
    """
    machine, poses = travels.machine, poses[:_TRIED]
    if depth is not None:
        rise = depth - tip_at_joints(machine, poses)[:, 2]
        lifted = _followed(travels, poses, np.sign(rise)[:, None] * (0.0, 0.0, 1.0), np.abs(rise), 0.0)
        poses = lifted.poses[lifted.length > np.abs(rise) - 1e-9]
    lines = _followed(travels, poses, inward(machine, poses), np.full(len(poses), _LONGEST), _SLOWEST)
    long = np.flatnonzero(lines.length >= SHORTEST)
    order = long[np.argsort(-lines.length[long], kind="stable")]
    return Followed(poses[order], lines.length[order], lines.speed[order])


def _followed(
    travels: JointTravels, poses: np.ndarray, direction: np.ndarray, most: np.ndarray, slowest: float
) -> Followed:
    """Draw tips along directions (n, 3) up to so far, as long as joints stay away from their stops and can follow."""
    machine, room = travels.machine, _ROOM * (travels.high - travels.low)
    free = travels.high - travels.low
    free[0] = 0.0 if slew_sign(machine) else free[0]
    first, poses, length = tip_at_joints(machine, poses), poses.copy(), np.zeros(len(poses))
    speed, going = np.full(len(poses), _FASTEST), np.flatnonzero(most > 0.0)
    for _ in range(int(most.max(initial=0.0) / _STEP) + 1):
        if not len(going):
            break
        step = np.minimum(_STEP, most[going] - length[going])
        wanted, tried = first[going] + (length[going] + step)[:, None] * direction[going], poses[going]
        for _ in range(2):
            tried = tried + joint_speeds(tip_jacobian(machine, tried), wanted - tip_at_joints(machine, tried), free)
        inside = ((tried > travels.low + room) & (tried < travels.high - room) | (free == 0.0)).all(axis=1)
        moved = np.abs(tried - poses[going]) / step[:, None]  # rad or m for each m
        fast = np.minimum(speed[going], (_SHARE * travels.full / np.maximum(moved, 1e-9)).min(axis=1))
        off = np.linalg.norm(wanted - tip_at_joints(machine, tried), axis=1)
        good = inside & (off < _OFF) & (fast >= slowest)
        at = going[good]
        poses[at], speed[at] = tried[good], fast[good]
        length[at] += step[good]
        going = at[length[at] < most[at] - 1e-9]
    return Followed(poses, length, speed)
