"""End stops of a joint.

They are inelastic: a joint that would pass its stop is brought to rest by an impulse, which the other joints feel through the mass
matrix; one that is pushed into its stop is held by the same rule, and leaves when it is pulled away.
"""

from polydraulic._kernel import kernel
from polydraulic.parameters.schema import Stops


@kernel
def passes_stop(angle: float, rate: float, stops: Stops, dt: float) -> bool:
    """Whether a joint would pass a stop within the step."""
    end = angle + dt * rate
    return (rate > 0.0 and end >= stops.high) or (rate < 0.0 and end <= stops.low)


@kernel
def turned_joint(angle: float, rate: float, there: bool, stops: Stops, dt: float) -> float:
    """Position of a joint after a step at this rate; one that stands `there` is at its nearer stop."""
    stop = stops.high if stops.high - angle < angle - stops.low else stops.low
    return stop if there else min(max(angle + dt * rate, stops.low), stops.high)
