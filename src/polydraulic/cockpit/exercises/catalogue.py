"""Exercises for a machine of any layout: what the tip is to do, in paths and places that it can reach."""

from math import pi
from typing import NamedTuple

import numpy as np

from polydraulic.machine.reach.lines import SHORTEST, level_lines
from polydraulic.machine.reach.poses import ReachedPoses, nearest_pose, reached_poses
from polydraulic.machine.reach.tip import slewing_function, tip_at_joints
from polydraulic.machine.reach.travels import JointTravels, inward, out_of, travels_of
from polydraulic.parameters.layout.schema import LayoutMachine

TRACKING_TIME = 60.0  # s
_SPEED = 0.08  # rad/s, at most of a joint that follows the moving target
_SHARE, _WIDEST = 0.3, 0.5  # of a joint's travel, and in rad or m, that the target moves through
_SWUNG = {"pick and place": pi / 4.0, "truck loading": pi / 2.0}  # rad
_TRIPS = {"pick and place": 1, "truck loading": 3}
_TOLERANCE = 0.04  # of the reach
_LONG = 0.6  # of the longest level line, where one at another height will do


class Exercise(NamedTuple):
    """What the tip is to do.

    Attributes
    ----------
    name, title : str
    kind : str
        ``follow`` a moving target, go along a ``line``, or ``visit`` places one after the other.
    path : (n, 3) array, m
        The target step by step; the ends of the line; the places.
    payload : tuple of float, kg
        What hangs at the tip once a place has been visited.
    tolerance : float, m
        How close is there.
    """

    name: str
    title: str
    kind: str
    path: np.ndarray
    payload: tuple[float, ...]
    tolerance: float


def exercises_of(machine: LayoutMachine, dt: float, ground: float) -> dict[str, Exercise]:
    """Exercises by name; a machine that can draw its tip along no level line has no trench.

    Parameters
    ----------
    machine : LayoutMachine
    dt : float, s
        Of the steps of a moving target.
    ground : float, m
        Its height.
    """
    travels = travels_of(machine)
    reached = reached_poses(travels, slewing=False)
    tolerance = round(_TOLERANCE * reached.size, 2)
    middle = 0.5 * float(reached.out.min() + reached.out.max())
    target = moving_target(machine, dt)
    line = _line_near(travels, reached, ground - 0.05 * reached.size)
    mass = round(0.5 * machine.link(machine.tip[0]).mass, -1)
    found = [Exercise("tracking", "keep the tip at a target that moves", "follow", target, (), tolerance)]
    if line is not None:
        found.append(Exercise("trench", "draw the tip along a level line", "line", line, (), tolerance))
    for name, title, load in (
        ("pick and place", "take from one place to another", 0.0),
        ("truck loading", f"load {mass:g} kg three times", mass),
    ):
        low = nearest_pose(reached, middle, ground + 0.1 * reached.size)
        if slewing_function(machine) is not None:
            high = nearest_pose(reached, middle, ground + 0.4 * reached.size)
            high[0] += _SWUNG[name]
        else:
            high = nearest_pose(reached, middle + 0.2 * reached.size, ground + 0.4 * reached.size)
        places = tip_at_joints(machine, np.array([low, high] * _TRIPS[name]))
        found.append(Exercise(name, title, "visit", places, (load, 0.0) * _TRIPS[name], tolerance))
    return {exercise.name: exercise for exercise in found}


def moving_target(machine: LayoutMachine, dt: float) -> np.ndarray:
    """Places of a target step by step, (n, 3) in m: joints swing from their start to where there is room, each with a period of its own."""
    t = dt * np.arange(round(TRACKING_TIME / dt) + 1)
    joints = np.empty((len(t), len(machine.names)))
    for k, f in enumerate(machine.functions):
        low, high, begin = f.stops.low, f.stops.high, f.initial.angle
        width = min(_SHARE * (high - low), _WIDEST)
        up = high - begin >= begin - low
        width = min(width, 0.8 * (high - begin if up else begin - low)) * (1.0 if up else -1.0)
        period = pi * abs(width) / _SPEED * (1.0 + 0.25 * k)  # peak speed of half a cosine: pi width / period
        joints[:, k] = begin + 0.5 * width * (1.0 - np.cos(2.0 * pi * t / max(period, 1.0)))
    return tip_at_joints(machine, joints)


def _line_near(travels: JointTravels, reached: ReachedPoses, height: float) -> np.ndarray | None:
    """Ends of a long level line near a height in m, from far to near but not to where the machine stands, (2, 3) in m."""
    machine, found = travels.machine, level_lines(travels, reached.positions)
    length = np.minimum(found.length, np.abs(out_of(machine, found.poses)) - np.abs(reached.out).min())
    long = np.flatnonzero(length >= max(_LONG * length.max(initial=0.0), SHORTEST))
    if not len(long):
        return None
    first = tip_at_joints(machine, found.poses[long])
    ends = np.stack([first, first + length[long, None] * inward(machine, found.poses[long])], axis=1)
    return np.asarray(ends[np.argmin(np.abs(first[:, 2] - height))])
