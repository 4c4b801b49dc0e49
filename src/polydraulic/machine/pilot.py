"""Subsystem 1, the pilot valves: voltage -> main-valve spool displacement, first order (thesis ch. 2).

tau dx/dt + x = clip(gain v, +-travel). The limit is on the command, so that a spool at its stop leaves it at once.
"""

from math import exp
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.parameters.schema import Pilot


class PilotStep(NamedTuple):
    """A pilot prepared for one step size."""

    gain: float
    travel: float
    decay: float  # exp(-dt / tau)


def prepare_pilot(pilot: Pilot, travel: float, dt: float) -> PilotStep:
    """Precompute what does not change from step to step; `travel` of the spool to either side in m."""
    return PilotStep(pilot.gain, travel, exp(-dt / pilot.time_constant))


@kernel
def spool_target(voltage: float, pilot: PilotStep) -> float:
    """Displacement in m that the spool moves towards."""
    return min(max(pilot.gain * voltage, -pilot.travel), pilot.travel)


@kernel
def pilot_step(spool: float, voltage: float, pilot: PilotStep) -> float:
    """Spool displacement in m after one step with constant voltage: the exact solution."""
    target = spool_target(voltage, pilot)
    return target + (spool - target) * pilot.decay
