"""What a coordinated controller knows besides the machine: its speeds, gains and delays, and kernels that ask for no layout."""

from math import sqrt
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel


class Servo(NamedTuple):
    """Numbers of a controller; arrays have an entry for each function of the machine.

    Attributes
    ----------
    dt : float, s
        Between two calls.
    gain, integral_gain : float, 1/s and 1/s2
        Of the joint servos.
    most_integral : float, 1
        Largest part of a joint's speed at full flow that the integral may add.
    acceleration, turning : float
        Of the tip in m/s2, of swing and attachment in rad/s2.
    slow : float, m/s
        Below it, in some direction at full flow, the arm is near a singularity.
    blend : float
        Share of a new load torque that is taken over in a call.
    lead : array
        How many times too far a spool is driven for a moment, so that it is where it should be sooner than its pilot alone would be.
    low, high : array
        Limits of the joints, inside their stops.
    braking : array, rad/s2 or m/s2
        How fast a joint may slow down ahead of a limit.
    band : array, rad or m
        Errors of joints that nobody moves which are left alone.
    patience : array, rad or m
        Error at which the motion waits for a joint.
    small : array, m3/s
        Flow below which spools are opened in proportion, across the deadband.
    speed : array, rad/s or m/s
        Of a joint with all of the pump's flow.
    opens : array, m
        Travel at which the inlet opens.
    travel : array, m
        To either side.
    pilot_gain : array, m/V
    decay : array
        Of the spool towards what its pilot wants, in a call.
    circuit, order : array of int
        Which circuit feeds a function; functions with those before that others depend on.
    ring : int
        Calls by which a measured position is later than the reference that it answers to.
    shares : int
        1 where all motion is slowed when flow runs short, 0 where each function is left to itself.
    floor, p_return : float, Pa
    tip_margin : float, m
        Dynamic distance to tipping that is kept; 0 where nobody asks for one.
    halt, late : float, s
        Shortest stop of any motion; what passes until it begins.
    """

    dt: float
    gain: float
    integral_gain: float
    most_integral: float
    acceleration: float
    turning: float
    slow: float
    blend: float
    lead: np.ndarray
    low: np.ndarray
    high: np.ndarray
    braking: np.ndarray
    band: np.ndarray
    patience: np.ndarray
    small: np.ndarray
    speed: np.ndarray
    opens: np.ndarray
    travel: np.ndarray
    pilot_gain: np.ndarray
    decay: np.ndarray
    circuit: np.ndarray
    order: np.ndarray
    ring: int
    shares: int
    floor: float
    p_return: float
    tip_margin: float
    halt: float
    late: float


@kernel
def slewed(now: float, wanted: float, most: float) -> float:
    """A value that follows another one by at most so much."""
    return now + min(max(wanted - now, -most), most)


@kernel
def slew_share(x: float, z: float, most: float) -> float:
    """Share of a change in a plane that is made at once, so that its length stays below `most`; its direction is kept."""
    square = x * x + z * z
    return min(1.0, most / (sqrt(square) + 1e-300))


@kernel
def stop_share(angle: float, rate: float, low: float, high: float, braking: float, dt: float) -> float:
    """Share of a joint's rate with which it can still be slowed down ahead of its limits, and never passes them."""
    left = high - angle if rate > 0.0 else angle - low
    left = max(left, 0.0)
    allowed = min(sqrt(2.0 * braking * left), left / dt)
    return min(1.0, allowed / (abs(rate) + 1e-300))


@kernel
def outside_band(error: float, band: float) -> float:
    """An error, less a band around zero."""
    return error - min(max(error, -band), band)
