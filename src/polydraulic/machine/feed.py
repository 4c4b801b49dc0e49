"""A main valve fed through an impedance: what it draws from a volume that it empties, or from the end of a line.

The feed gives way, P = pressure - impedance * flow. The valve shares what it draws between the actuator's inlet and its
bypass, which leads into something that may give way too. Each share is a closed form; the flow that feed and valve agree
on is found by osculation: the valve is replaced by a single orifice with the same pressure and slope at the present flow,
which has a closed form again. It is exact while only one of the two orifices carries oil, and otherwise meets the flow
from above, so that it cannot swing around the kink where the second one opens.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.valve import orifice_flow

DRAW_PASSES = 5
SHUT = 1e-150  # conductance squared of a shut orifice, m6/s2/Pa: nothing passes, and its inverse is finite
TRICKLE = 1e-12  # m3/s; shows which orifice opens first


class Feed(NamedTuple):
    """What stands before a valve: P = pressure - impedance * flow."""

    pressure: float  # Pa
    impedance: float  # Pa s/m3


class Bypass(NamedTuple):
    """A bypass and what is behind it: P = p_rest + resistance w + w^2 / square for a flow w; nothing flows back."""

    p_rest: float  # Pa
    resistance: float  # Pa s/m3
    square: float  # conductance squared, m6/s2/Pa


class Draw(NamedTuple):
    """Flow that a valve draws, and how its pressure rises with it nearby: P' = resistance + 2 curve flow."""

    flow: float
    resistance: float
    curve: float


class Drawn(NamedTuple):
    """A valve's flows and the pressure before it."""

    q_in: float
    q_bypass: float
    q_relief: float
    p: float


@kernel
def bypass_flow(p: float, bypass: Bypass) -> float:
    """Flow through a bypass with the pressure `p` before it."""
    drop = max(p - bypass.p_rest, 0.0)
    r = bypass.resistance
    return 2.0 * drop / (r + sqrt(r * r + 4.0 * drop / (bypass.square + SHUT)) + 1e-300)


@kernel
def inlet_part(flow: float, k_in: float, p_in: float, bypass: Bypass) -> float:
    """Part of `flow` that enters the actuator; a clamp decides the special cases, as for the circuit without resistance."""
    a, b = k_in * k_in, bypass.square
    m = 0.5 * bypass.resistance * b
    drop = p_in - bypass.p_rest
    x = flow * (flow + 2.0 * m)
    root = sqrt(max(a * m * m + b * (x + (a - b) * drop), 0.0))
    q = k_in * (x - b * drop) / (k_in * (flow + m) + root + 1e-300)
    return min(max(q, 0.0), flow)


@kernel
def _agreed(feed: Feed, p_rest: float, resistance: float, curve: float) -> float:
    """Flow at which the feed's pressure is p_rest + resistance flow + curve flow^2."""
    drop = max(feed.pressure - p_rest, 0.0)
    z = feed.impedance + resistance
    return 2.0 * drop / (z + sqrt(z * z + 4.0 * drop * curve) + 1e-300)


@kernel
def at_most(feed: Feed, k_in: float, p_in: float, bypass: Bypass) -> float:
    """Return more than a valve can draw, what inlet and bypass would draw alone: where to begin."""
    alone = _agreed(feed, p_in, 0.0, 1.0 / (k_in * k_in + SHUT))
    return alone + _agreed(feed, bypass.p_rest, bypass.resistance, 1.0 / (bypass.square + SHUT))


@kernel
def draw_pass(flow: float, feed: Feed, k_in: float, p_in: float, bypass: Bypass) -> Draw:
    """One osculation."""
    flow = max(flow, TRICKLE)
    a, b, r = k_in * k_in, bypass.square, bypass.resistance
    q = inlet_part(flow, k_in, p_in, bypass)
    w = flow - q
    none_in, none_by = q <= 0.0, w <= 0.0
    curve_in, curve_by = 1.0 / (a + SHUT), 1.0 / (b + SHUT)
    steep_in, steep_by = 2.0 * curve_in * q, r + 2.0 * curve_by * w
    # P = p_rest + resistance flow + curve flow^2: in flow + m both orifices are pure ones
    m = 0.5 * r * b
    curve = 0.5 * steep_in * steep_by / ((steep_in + steep_by) * (flow + m) + 1e-300)
    resistance = 2.0 * m * curve
    p = p_in + 0.5 * steep_in * q if a >= b else bypass.p_rest + (r + curve_by * w) * w
    p_rest = p - flow * (resistance + curve * flow)
    curve = curve_by if none_in else (curve_in if none_by else curve)
    resistance = r if none_in else (0.0 if none_by else resistance)
    p_rest = bypass.p_rest if none_in else (p_in if none_by else p_rest)
    return Draw(_agreed(feed, p_rest, resistance, curve), resistance, curve)


@kernel
def relieved_flow(k_in: float, p_in: float, bypass: Bypass, relief: float) -> float:
    """Flow that a valve draws at the relief pressure: the most it can have."""
    return orifice_flow(k_in, relief - p_in) + bypass_flow(relief, bypass)


@kernel
def draw(feed: Feed, k_in: float, p_in: float, bypass: Bypass, relief: float) -> Drawn:
    """What a valve draws from a feed whose pressure a relief valve limits to `relief`.

    Parameters
    ----------
    feed : Feed
    k_in : float, m3/s/Pa^0.5
        Conductance of the inlet.
    p_in : float, Pa
        At the pressurised port.
    bypass : Bypass
    relief : float, Pa
    """
    flow = at_most(feed, k_in, p_in, bypass)
    for _ in range(DRAW_PASSES):
        flow = draw_pass(flow, feed, k_in, p_in, bypass).flow
    flow = min(flow, relieved_flow(k_in, p_in, bypass, relief))
    q = inlet_part(flow, k_in, p_in, bypass)
    p = feed.pressure - feed.impedance * flow
    return Drawn(q, flow - q, max(p - relief, 0.0) / feed.impedance, min(p, relief))
