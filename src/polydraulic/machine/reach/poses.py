"""Poses all over the travel of a machine's joints, and where its tip is in them."""

from typing import NamedTuple

import numpy as np

from polydraulic.machine.reach.tip import slewing_function, tip_at_joints
from polydraulic.machine.reach.travels import JointTravels, out_of, outward

_POSES = 4096
_INNER = 0.1  # of the travel, at each end, where no pose lies
_NEAR = 0.3  # of the largest reach, where the machine itself stands


class ReachedPoses(NamedTuple):
    """Poses away from stops in which the tip is not where the machine stands.

    Attributes
    ----------
    positions : (n, n_function) array, rad or m
    tips : (n, 3) array, m
    out : (n,) array, m
        See `travels.out_of`.
    """

    positions: np.ndarray
    tips: np.ndarray
    out: np.ndarray

    @property
    def size(self) -> float:
        """From the nearest to the farthest tip, or from the lowest to the highest, m."""
        return float(max(np.ptp(self.out), np.ptp(self.tips[:, 2])))


def reached_poses(travels: JointTravels, *, slewing: bool = True) -> ReachedPoses:
    """Poses at random, the same ones in every call; with `slewing` false the arm stays in the plane in which it is at the start."""
    machine = travels.machine
    share = np.random.default_rng(0).uniform(_INNER, 1.0 - _INNER, (2 * _POSES, len(travels.low)))
    positions = travels.low + (travels.high - travels.low) * share
    slews = slewing_function(machine)
    if slews is not None and not slewing:
        positions[:, 0] = slews.initial.angle
    reach = np.linalg.norm(outward(machine, tip_at_joints(machine, positions)), axis=1)
    positions = positions[reach >= _NEAR * reach.max()][:_POSES]
    return ReachedPoses(positions, tip_at_joints(machine, positions), out_of(machine, positions))


def nearest_pose(poses: ReachedPoses, out: float, height: float) -> np.ndarray:
    """Joint positions (n_function,) at which the tip is nearest to a place in the plane of the arm: m outward, and of the ground's z."""
    return poses.positions[np.argmin(np.hypot(poses.out - out, poses.tips[:, 2] - height))].copy()
