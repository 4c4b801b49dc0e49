"""A pass through valves in series: backwards a tangent outlet for each valve and all behind it, forwards each valve's share.

At the flow that arrives, an inlet and what lies behind its bypass look like one orifice of the same pressure and slope. A pass
puts these together from the last valve to the first, then shares the pump's flow out from the first to the last. Where orifices
just open, passes may swing to and fro: a flow that turns back moves by half.

Orifices are resistances here, P = p_rest + r Q^2: those in a row add up. What is shut resists by more than any pressure overcomes.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, log
from polydraulic.machine.circuits.series.check import LEAST
from polydraulic.machine.pump import Pump

PASSES = 12  # what they leave is repaired
AT_FIRST = 1e100  # m3/s; the last change of a flow that has not moved yet
SHUT = 1e59  # Pa s2/m6; below the resistance of the narrowest orifice, 1e60
_SMALL, _REST = 1e-8, 1e-13  # shares of pump flow: the last change may be small, the next one rounding
_SWING = 0.3  # of its last change: a flow that turns back by more moves by half


class Outlet(NamedTuple):
    """What a flow meets: P = p_rest + r Q^2."""

    r: float  # Pa s2/m6
    p_rest: float  # Pa


class Moved(NamedTuple):
    """A value and how far its last pass moved it."""

    value: float
    change: float


@kernel
def resistance(conductance: float) -> float:
    """Pa s2/m6 of an orifice; a shut one has more than `SHUT`."""
    k = max(conductance, LEAST)
    return 1.0 / (k * k)


@kernel
def settled(largest: float, before: float, flow: float) -> bool:
    """Whether the largest change of a pass is small, and leaves nothing to do if changes go on falling by the factor since `before`."""
    return largest <= _SMALL * flow and largest * largest <= _REST * flow * before


@kernel
def tangent(flow: float, inlet: float, p_in: float, beyond: Outlet) -> Outlet:
    """An inlet of resistance `inlet` and what lies beyond the bypass as one outlet at a flow; where nothing flows, the one that opens first.

    Its share of the flow is n / d, the rest m / d, in closed form: no pressure, and no sum of like numbers. One of both
    that is negative passes nothing.
    """
    r, p_rest = beyond.r, beyond.p_rest
    if inlet < SHUT and beyond.r >= SHUT:
        r, p_rest = inlet, p_in
    elif inlet < SHUT:
        gap = p_in - beyond.p_rest
        n = beyond.r * flow * flow - gap
        root = sqrt(max(inlet * n + beyond.r * gap, 0.0))
        d, m = beyond.r * flow + root, flow * root + gap
        by_inlet, by_bypass = inlet * max(n, 0.0), beyond.r * max(m, 0.0)
        both = flow * (by_inlet + by_bypass)
        inverse = 1.0 / (d * both + 1e-300)
        q, rest, r_both = max(n, 0.0) * both * inverse, max(m, 0.0) * both * inverse, by_inlet * by_bypass * inverse
        p = p_in + inlet * q * q if inlet <= beyond.r else beyond.p_rest + beyond.r * rest * rest
        p_rest = p - r_both * flow * flow
        r = inlet if m <= 0.0 else (beyond.r if n <= 0.0 else r_both)
        p_rest = p_in if m <= 0.0 else (beyond.p_rest if n <= 0.0 else p_rest)
    return Outlet(r, p_rest)


@kernel
def behind(flow: float, inlet: float, p_in: float, beyond: Outlet, bypass: float) -> Outlet:
    """A bypass of resistance `bypass`, then the next valve's inlet and what lies `beyond` its own bypass, as one outlet at a flow."""
    tail = tangent(flow, inlet, p_in, beyond)
    return Outlet(bypass + tail.r, tail.p_rest)


@kernel
def passed_on(flow: float, inlet: float, p_in: float, beyond: Outlet) -> float:
    """What of the flow that arrives passes the bypass."""
    passed = 0.0 if beyond.r >= SHUT else flow
    if inlet < SHUT and beyond.r < SHUT:
        gap = p_in - beyond.p_rest
        root = sqrt(max(inlet * (beyond.r * flow * flow - gap) + beyond.r * gap, 0.0))
        passed = min(max((flow * root + gap) / (beyond.r * flow + root + 1e-300), 0.0), flow)
    return passed


@kernel
def driven_at_relief(beyond: Outlet, pump: Pump) -> float:
    """What the relief pressure drives through an outlet, m3/s."""
    return sqrt(max(pump.relief - beyond.p_rest, 0.0) / beyond.r)


@kernel
def passed_first(flow: float, inlet: float, p_in: float, beyond: Outlet, pump: Pump) -> float:
    """What passes the first bypass: no more than the relief pressure drives."""
    return min(passed_on(flow, inlet, p_in, beyond), driven_at_relief(beyond, pump))


@kernel
def stepped(old: float, last: float, new: float, limit: float, still: bool) -> Moved:
    """`new`, or half of the way to it if that turns back, but never more than `limit`, what arrives; `old` once all is still."""
    change = new - old
    swings = change * last < 0.0 and abs(change) > _SWING * abs(last)
    value = old if still else min(old + 0.5 * change if swings else new, limit)
    return Moved(value, value - old)


@kernel
def least_flow(pump: Pump) -> float:
    """What a pump delivers at least, in m3/s."""
    return pump.flow * exp(pump.log_least)


@kernel
def _towards(off: float, Q: float, last: float, least: float, p: float, rise: float, pump: Pump) -> Moved:
    """One Newton step of ln Q at the pressure p; `off` is how far n ln p + ln Q is from the torque limit."""
    step = -off * p / (p + 2.0 * pump.limit_exponent * min(rise, p))
    step = 0.5 * step if step * last < 0.0 and abs(step) > _SWING * abs(last) else step
    step = min(max(step, -1.0), 1.0)
    value = min(max(Q * (2.0 + step) / (2.0 - step), least), pump.flow)
    return Moved(value, value / Q - 1.0)


@kernel
def limited_power(Q: float, last: float, least: float, whole: Outlet, pump: Pump, still: bool) -> Moved:
    """A step from Q towards the torque limit of a pump of constant power whose circuit looks like `whole` at Q; the change is a share.

    No logarithm is needed: the one in its place has the same root, and the same slope there.
    """
    rise = whole.r * Q * Q
    p, moved = max(whole.p_rest + rise, 1.0), Moved(Q, 0.0)
    if not still and (p > pump.limit_start or pump.flow > Q):
        z = p * Q / (pump.limit_start * pump.flow)
        moved = _towards(2.0 * (z - 1.0) / (z + 1.0), Q, last, least, p, rise, pump)
    return moved


@kernel
def limited_law(Q: float, last: float, least: float, whole: Outlet, pump: Pump, still: bool) -> Moved:
    """The same for any exponent."""
    rise = whole.r * Q * Q
    p, moved = max(whole.p_rest + rise, 1.0), Moved(Q, 0.0)
    if not still and (p > pump.limit_start or pump.flow > Q):
        off = pump.limit_exponent * log(p / pump.limit_start) + log(Q / pump.flow)
        moved = _towards(off, Q, last, least, p, rise, pump)
    return moved


@kernel
def limited(Q: float, last: float, least: float, whole: Outlet, pump: Pump, still: bool) -> Moved:
    """The one or the other."""
    if pump.limit_exponent == 1.0:
        moved = limited_power(Q, last, least, whole, pump, still)
    else:
        moved = limited_law(Q, last, least, whole, pump, still)
    return moved
