"""A pass through valves in series: backwards a tangent orifice for each valve and all behind it, forwards each valve's share.

At the flow that arrives, an inlet and what lies behind its bypass look like one orifice of the same pressure and slope. A pass
puts these together from the last valve to the first, then shares the pump's flow out from the first to the last. Where orifices
just open, passes may swing to and fro: a flow that turns back moves by half.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, log
from polydraulic.machine.pump import Orifice, Pump, _as_one, _inlet_share
from polydraulic.machine.valve import Orifices, orifice_flow

PASSES = 8  # what they leave is repaired
AT_FIRST = 1e300  # m3/s; the last change of a flow that has not moved yet
_REST = 1e-12  # share of pump flow; a smaller change of a pass leaves nothing to do
_SWING = 0.3  # of its last change: a flow that turns back by more moves by half


class Moved(NamedTuple):
    """A value and how far its last pass moved it."""

    value: float
    change: float


@kernel
def settled(largest: float, flow: float) -> bool:
    """Whether the largest change of a pass was rounding."""
    return largest <= _REST * flow


@kernel
def tangent(flow: float, inlet: float, p_in: float, behind: Orifice) -> Orifice:
    """Inlet and what lies behind the bypass as one orifice at a flow; where nothing flows, the one that opens first."""
    q = _inlet_share(flow, inlet, behind.square, p_in - behind.p_rest)
    both = _as_one(flow, q, inlet, behind.square, p_in, behind.p_rest)
    opens = flow <= 0.0 and inlet > 0.0 and (p_in < behind.p_rest or behind.square <= 0.0)
    return Orifice(inlet * inlet if opens else both.square, p_in if opens else both.p_rest)


@kernel
def last_tangent(flow: float, k: Orifices, p_in: float, p_return: float) -> Orifice:
    """Inlet and bypass of the last valve as one orifice."""
    return tangent(flow, k.inlet, p_in, Orifice(k.bypass * k.bypass, p_return))


@kernel
def through(bypass: float, behind: Orifice) -> Orifice:
    """A bypass and what lies behind it as one orifice."""
    b = bypass * bypass
    return Orifice(b * behind.square / (b + behind.square + 1e-300), behind.p_rest)


@kernel
def passed_on(flow: float, inlet: float, p_in: float, behind: Orifice) -> float:
    """What of the flow that arrives passes the bypass."""
    rest = flow - _inlet_share(flow, inlet, behind.square, p_in - behind.p_rest)
    return rest if behind.square > 0.0 else 0.0


@kernel
def passed_last(flow: float, k: Orifices, p_in: float, p_return: float) -> float:
    """What of the flow that arrives passes the last bypass, to the tank."""
    return passed_on(flow, k.inlet, p_in, Orifice(k.bypass * k.bypass, p_return))


@kernel
def passed_first(flow: float, inlet: float, p_in: float, behind: Orifice, pump: Pump) -> float:
    """What passes the first bypass: no more than the relief pressure drives."""
    q = _inlet_share(flow, inlet, behind.square, p_in - behind.p_rest)
    q = min(q, orifice_flow(inlet, pump.relief - p_in))
    return min(flow - q, sqrt(max(behind.square * (pump.relief - behind.p_rest), 0.0)))


@kernel
def stepped(old: float, last: float, new: float, limit: float, still: bool) -> Moved:
    """`new`, or half of the way to it if that turns back, but never more than `limit`, what arrives; `old` once all is still."""
    change = new - old
    swings = change * last < 0.0 and abs(change) > _SWING * abs(last)
    value = old if still else min(old + 0.5 * change if swings else new, limit)
    return Moved(value, value - old)


@kernel
def limited(old: float, last: float, whole: Orifice, pump: Pump, still: bool) -> Moved:
    """One Newton step of ln(Q / flow) towards the torque limit for a circuit that looks like `whole` at Q."""
    n, Q = pump.limit_exponent, pump.flow * exp(old)
    rise = min(Q * Q / (whole.square + 1e-300), 1e15)
    p = max(whole.p_rest + rise, 1.0)
    off = n * log(p / pump.limit_start) + old
    change = -off / (1.0 + 2.0 * n * min(rise / p, 1.0))
    swings = change * last < 0.0 and abs(change) > _SWING * abs(last)
    moves = min(max(old + (0.5 * change if swings else change), pump.log_least), 0.0)
    value = old if still else moves
    return Moved(value, value - old)
