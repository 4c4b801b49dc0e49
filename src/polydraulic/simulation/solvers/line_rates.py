"""One actuator's two lines in continuous time: rates of their pressures, and what keeps these within make-up floor and relief."""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.hose import LineStep

# how far beyond its condition something must be before it counts: Pa, Pa/s
_PRESSURE, _FILLING = 1.0, 1e3


class LineRates(NamedTuple):
    """Rates of two line pressures in Pa/s, and the flow in m3/s through the outlet."""

    p_a: float
    p_b: float
    q_out: float


@kernel
def line_rates(
    spool: float, p_a: float, p_b: float, q_in: float, k_out: float, a: float, b: float, line: LineStep
) -> LineRates:
    """Rates at any pressures; `a` and `b` are the flows that the actuator draws from A and gives to B."""
    forward = spool >= 0.0
    q_out = k_out * sqrt(max((p_b if forward else p_a) - line.p_return, 0.0))
    leak = line.leakage * (p_a - p_b)
    return LineRates(
        line.gain_a * ((q_in if forward else -q_out) - a - leak - line.external * p_a),
        line.gain_b * ((-q_out if forward else q_in) + b + leak - line.external * p_b),
        q_out,
    )


@kernel
def within_bounds(p: float, line: LineStep) -> float:
    """A line pressure between make-up floor and relief."""
    return min(max(p, line.floor), line.relief)


@kernel
def line_moves(p: float, rate: float, line: LineStep) -> float:
    """1 where a line pressure moves at this rate, 0 where a bound holds it."""
    return 0.0 if (p <= line.floor and rate < 0.0) or (p >= line.relief and rate > 0.0) else 1.0


@kernel
def held_back(p: float, rate: float, line: LineStep) -> float:
    """Rate of a line pressure that keeps to its bounds."""
    return rate if line_moves(p, rate, line) != 0.0 else 0.0


@kernel
def line_changes(p: float, rate: float, free: float, line: LineStep) -> bool:
    """Whether a free line is beyond its bounds, or a bound would have to hold a line back that leaves it."""
    beyond = p < line.floor - _PRESSURE or p > line.relief + _PRESSURE
    leaves = rate > _FILLING if p <= line.floor else rate < -_FILLING
    return beyond if free != 0.0 else leaves
