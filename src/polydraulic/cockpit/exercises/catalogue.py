"""Exercises for a machine of any layout: what the tip is to do, in paths and places that it can reach."""

from math import pi
from typing import NamedTuple

import numpy as np

from polydraulic.cockpit.exercises.reachable import joints_near, level_line, reach_of, tips_at
from polydraulic.parameters.layout.schema import LayoutMachine

TRACKING_TIME = 60.0  # s
_SPEED = 0.08  # rad/s, at most of a joint that follows the moving target
_SHARE, _WIDEST = 0.3, 0.5  # of a joint's travel, and in rad or m, that the target moves through
_SWUNG = {"pick and place": pi / 4.0, "truck loading": pi / 2.0}  # rad
_TRIPS = {"pick and place": 1, "truck loading": 3}
_TOLERANCE = 0.04  # of the reach


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
    """Exercises by name.

    Parameters
    ----------
    machine : LayoutMachine
    dt : float, s
        Of the steps of a moving target.
    ground : float, m
        Its height.
    """
    reach = reach_of(machine)
    tolerance = round(_TOLERANCE * reach.size, 2)
    line = level_line(reach, ground - 0.05 * reach.size)
    middle = 0.5 * float(reach.out[np.argmin(reach.out)] + reach.out[np.argmax(reach.out)])
    mass = round(0.5 * machine.link(machine.tip[0]).mass, -1)
    found = [
        Exercise(
            "tracking", "keep the tip at a target that moves", "follow", moving_target(machine, dt), (), tolerance
        ),
        Exercise("trench", "draw the tip along a level line", "line", line, (), tolerance),
    ]
    for name, title, load in (
        ("pick and place", "take from one place to another", 0.0),
        ("truck loading", f"load {mass:g} kg three times", mass),
    ):
        low = joints_near(reach, middle, ground + 0.1 * reach.size)
        high = joints_near(reach, middle, ground + 0.4 * reach.size)
        if reach.swing is not None:
            high[reach.swing] += _SWUNG[name]
        else:
            high = joints_near(reach, middle + 0.2 * reach.size, ground + 0.4 * reach.size)
        places = tips_at(machine, np.array([low, high] * _TRIPS[name]))
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
    return tips_at(machine, joints)
