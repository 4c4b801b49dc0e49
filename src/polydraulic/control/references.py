"""Where a tip should be when: straight lines (grading), and paths through several points (pick and place)."""

from collections.abc import Sequence
from math import cos, isfinite, sin
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly

COORDINATES = ("reach", "height", "swing", "pitch")  # m, m, rad, rad


class TipPath(NamedTuple):
    """Legs from point to point, each begun and ended gently; along each, all coordinates move in proportion.

    Attributes
    ----------
    points : (n, 4) array
        Reach and height in m, swing and pitch in rad.
    ends : (n,) array, s
        When each point is reached; the first at 0.
    ramp : float, s
        Over which a leg gains its speed, and loses it.
    """

    points: np.ndarray
    ends: np.ndarray
    ramp: float

    @property
    def duration(self) -> float:
        """Seconds from the first point to the last."""
        return float(self.ends[-1])

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Point and velocity at a time in s; before the start and after the end, those at rest.

        Returns
        -------
        point, velocity : (4,) array
        """
        leg = int(np.clip(np.searchsorted(self.ends, time, side="right") - 1, 0, len(self.ends) - 2))
        begin, end = float(self.ends[leg]), float(self.ends[leg + 1])
        share, rate = _ramped(min(max(time - begin, 0.0), end - begin), end - begin, self.ramp)
        way = self.points[leg + 1] - self.points[leg]
        return self.points[leg] + share * way, rate * way


def _ramped(time: float, whole: float, ramp: float) -> tuple[float, float]:
    """Share of a leg that is done, and its rate in 1/s: steady speed between two ramps."""
    speed = 1.0 / (whole - ramp)
    if time < ramp:
        return 0.5 * speed * time * time / ramp, speed * time / ramp
    left = whole - time
    if left < ramp:
        return 1.0 - 0.5 * speed * left * left / ramp, speed * left / ramp
    return speed * (time - 0.5 * ramp), speed


def tip_path(
    points: Sequence[Sequence[float]] | np.ndarray, *, speed: float = 0.3, turning: float = 0.3, ramp: float = 0.6
) -> TipPath:
    """A path through points.

    Parameters
    ----------
    points : (n, 4) array
        Reach and height in m, swing and pitch in rad.
    speed : float, m/s
        Of the tip in the plane of the arm.
    turning : float, rad/s
        Of swing and pitch, where these take longer.
    ramp : float, s
        Over which each leg gains its speed, and loses it.

    Raises
    ------
    InputError
        Fewer than two points, values that are no numbers, two points that are the same, speeds that are not above zero.
    """
    given = np.asarray(points, dtype=np.float64)
    if given.ndim != 2 or given.shape[1] != len(COORDINATES) or len(given) < 2 or not np.isfinite(given).all():
        raise InputError(
            f"points have the shape {given.shape}: must be two or more rows of finite {', '.join(COORDINATES)}"
        )
    for name, value in (("speed", speed), ("turning", turning), ("ramp", ramp)):
        if not (isinstance(value, int | float) and isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {briefly(value)}: must be a number above zero")
    ways = np.abs(np.diff(given, axis=0))
    times = np.maximum(np.hypot(ways[:, 0], ways[:, 1]) / speed, ways[:, 2:].max(axis=1) / turning)
    if (times <= 0.0).any():
        raise InputError(
            f"points {1 + int(np.argmin(times))} and {2 + int(np.argmin(times))} are the same: leave one out"
        )
    return TipPath(given, np.concatenate([[0.0], np.cumsum(np.maximum(times, ramp) + ramp)]), ramp)


def straight_line(
    start: Sequence[float] | np.ndarray,
    *,
    length: float,
    speed: float = 0.3,
    slope: float = 0.0,
    depth: float = 0.0,
    turn: float = 0.0,
    ramp: float = 0.6,
) -> TipPath:
    """A grading pass towards the machine: down to a depth, then along a straight line, with the attachment's angle held, or turned evenly.

    Parameters
    ----------
    start : (4,) array
        Where the tip is: reach and height in m, swing and pitch in rad.
    length : float, m
        Of the line; below zero away from the machine.
    speed : float, m/s
        Along it.
    slope : float, rad
        Of the line, positive where it rises towards the machine.
    depth : float, m
        By which the tip is lowered before.
    turn : float, rad
        By which the attachment's angle to the ground changes along the line.
    ramp : float, s
    """
    first = np.asarray(start, dtype=np.float64)
    down = first - np.array([0.0, depth, 0.0, 0.0])
    last = down + np.array([-length * cos(slope), length * sin(slope), 0.0, turn])
    return tip_path(np.stack([first, down, last] if depth else [down, last]), speed=speed, ramp=ramp)


def pick_and_place(
    start: Sequence[float] | np.ndarray,
    *,
    swing: float = 0.8,
    lift: float = 0.8,
    dig: float = 1.0,
    pull: float = 1.2,
    speed: float = 0.5,
) -> TipPath:
    """A task in the order of the thesis' section 5.3.4: swing and lift, down and towards the machine, up again, all links to the destination.

    Parameters
    ----------
    start : (4,) array
        Where the tip is: reach and height in m, swing and pitch in rad.
    swing : float, rad
        To the place where something is picked; half of it back to where it is placed.
    lift, dig, pull : float, m
        Upward on the way there, down below that, and towards the machine.
    speed : float, m/s
    """
    ways = [
        [0.0, lift, swing, 0.0],
        [-pull, -dig, 0.0, 0.0],
        [0.0, dig, 0.0, 0.0],
        [0.5 * pull, 0.0, -0.5 * swing, 0.0],
    ]
    return tip_path(np.cumsum([np.asarray(start, dtype=np.float64), *ways], axis=0), speed=speed)
