"""What one joint's end stops do in continuous time: whether it strikes one, rests at one, is held by one or leaves it."""

from polydraulic._kernel import kernel
from polydraulic.parameters.schema import Stops

BLINK = 1e-6  # s; a joint that would pass its stop within this time is at it
# rad/s. The impulse of one joint's stop throws another off its own, which presses it back: two joints at their stops would hand
# ever smaller impulses to each other. A joint that leaves no faster than this, but is pressed back, stays.
CREEP = 1e-3
# how far beyond its condition something must be before it counts: rad, N m
_ANGLE, _PULL = 1e-9, 1.0


@kernel
def strikes(angle: float, rate: float, stops: Stops) -> bool:
    """Whether a joint moves into the stop that it is at or beyond."""
    return (rate > 0.0 and angle >= stops.high) or (rate < 0.0 and angle <= stops.low)


@kernel
def between_stops(angle: float, stops: Stops) -> float:
    """Position that the stops leave a joint."""
    return min(max(angle, stops.low), stops.high)


@kernel
def rests(angle: float, rate: float, creep: float, stops: Stops) -> bool:
    """Whether a joint stands at a stop: no faster than `creep` in rad/s."""
    return abs(rate) <= creep and (angle <= stops.low or angle >= stops.high)


@kernel
def stands(angle: float, reaction: float, acceleration: float, held: bool, stops: Stops) -> bool:
    """Whether a resting joint does what its stop does: push while it is held, or let it go away."""
    side = 1.0 if angle >= stops.high else -1.0
    return side * (reaction if held else acceleration) <= 0.0


@kernel
def joint_changes(angle: float, reaction: float, held: bool, locked: bool, stops: Stops) -> bool:
    """Whether a free joint is beyond a stop, or a stop would have to pull one that it holds."""
    beyond = angle < stops.low - _ANGLE or angle > stops.high + _ANGLE
    pulled = reaction > _PULL if angle >= stops.high else reaction < -_PULL
    return (pulled if held else beyond) and not locked
