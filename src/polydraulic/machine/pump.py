"""Pumps and their circuits: how a pump's flow is shared between actuators, bypasses and relief valve (Eqs 1-3, 8-13).

One circuit has a closed form. Two valves in series are solved by the same form, five times: at the flow that passes the
first valve, the second one looks like a single orifice. Clamps decide all special cases. Whole circuits, with torque limit, are in `circuits`.
"""

from math import log as natural_log
from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, log
from polydraulic.machine.valve import Orifices, orifice_flow
from polydraulic.parameters.layout.parts import PumpParameters

NEVER = 1e12  # Pa; a relief valve that stays shut


class Pump(NamedTuple):
    """A pump with a relief valve, behind which the return line holds a pressure; SI.

    Above `limit_start` the torque limit lowers the flow: Q = flow (limit_start / P)^limit_exponent. The pressure
    stays below `relief`, so that ln(Q / flow) stays above `log_least`; that is 0 for a pump without torque limit.
    """

    flow: float
    relief: float
    p_return: float
    limit_start: float = 1.0
    limit_exponent: float = 1.0
    log_least: float = 0.0


class Circuit(NamedTuple):
    """Flows and pressure at one pump: pump = actuators + bypass + relief + stored."""

    q_pump: float
    q_bypass: float  # what returns to the tank through the last valve's bypass
    q_relief: float
    p_pump: float  # 0 where a flow model does not give it
    q_stored: float  # what charges the oil between pump and valves, where a flow model has such volumes


class Single(NamedTuple):
    """One actuator on a pump."""

    q_in: float
    circuit: Circuit


class Series(NamedTuple):
    """Two actuators on a pump, the second fed by what passes the first valve's bypass."""

    q_first: float
    q_second: float
    p_between: float  # pressure between the two valves
    circuit: Circuit


class Orifice(NamedTuple):
    """One orifice: P = p_rest + Q^2 / square."""

    square: float
    p_rest: float


def limited_pump(flow: float, relief: float, p_return: float, limit: PumpParameters) -> Pump:
    """Pump that delivers `flow` in m3/s up to `relief` in Pa, less above its torque limit."""
    least = -limit.torque_limit_exponent * natural_log(max(relief / limit.torque_limit_start, 1.0))
    return Pump(
        flow=flow,
        relief=relief,
        p_return=p_return,
        limit_start=limit.torque_limit_start,
        limit_exponent=limit.torque_limit_exponent,
        log_least=least if limit.torque_limit_enabled else 0.0,
    )


@kernel
def delivered(p: float, pump: Pump) -> float:
    """Flow of the pump in m3/s at a pressure in Pa."""
    y = -pump.limit_exponent * log(max(p / pump.limit_start, 1.0))
    return pump.flow * exp(max(y, pump.log_least)) if pump.log_least < 0.0 else pump.flow


@kernel
def inlet_share(Q: float, k_in: float, b: float, drop: float) -> float:
    """Part of Q that enters the actuator: Eqs (1)-(3) in closed form.

    Eliminating the pressure leaves a quadratic in the flow; written with the root in the denominator it has no
    cancellation, and its special cases (inlet shut, bypass shut, either check valve closed) are exactly those in which
    it leaves [0, Q], so that a clamp decides them. `b` is the bypass conductance squared, `drop` is P_i - P_e.
    """
    root = sqrt(max(b * (Q * Q + (k_in * k_in - b) * drop), 0.0))
    q = k_in * (Q * Q - b * drop) / (k_in * Q + root + 1e-300)
    return min(max(q, 0.0), Q)


@kernel
def _pressure(q_in: float, k_in: float, p_in: float, q_bypass: float, k_bypass: float, p_bypass: float) -> float:
    """Pressure before two orifices, from the wider one that carries flow, which avoids cancellation."""
    from_inlet = q_in > 0.0 and (k_in >= k_bypass or q_bypass <= 0.0)
    root = (q_in if from_inlet else q_bypass) / ((k_in if from_inlet else k_bypass) + 1e-300)
    return (p_in if from_inlet else p_bypass) + root * root


@kernel
def as_one(Q: float, q: float, k_in: float, b: float, p_in: float, p_return: float) -> Orifice:
    """Inlet and bypass, which share Q as q and the rest, as one orifice with the same pressure and slope at Q."""
    a, rest = k_in * k_in, Q - q
    square = Q * (a * rest + b * q) / (q * rest + 1e-300)
    from_inlet = a >= b
    flow = q if from_inlet else rest
    p = (p_in if from_inlet else p_return) + flow * flow / ((a if from_inlet else b) + 1e-300)
    p_rest = p - Q * Q / (square + 1e-300)
    square = b if q <= 0.0 else (a if rest <= 0.0 else square)
    p_rest = p_return if q <= 0.0 else (p_in if rest <= 0.0 else p_rest)
    return Orifice(square, p_rest)


@kernel
def limits(p_pump: float, pump: Pump) -> bool:
    """Whether the torque limit lowers the flow of a pump that would otherwise have this pressure."""
    return pump.log_least < 0.0 and p_pump > pump.limit_start


@kernel
def single_at(Q: float, k: Orifices, p_in: float, pump: Pump) -> Single:
    """One actuator on a pump that delivers Q."""
    q = inlet_share(Q, k.inlet, k.bypass * k.bypass, p_in - pump.p_return)
    q = min(q, orifice_flow(k.inlet, pump.relief - p_in))
    surplus = Q - q
    q_bypass = min(surplus, orifice_flow(k.bypass, pump.relief - pump.p_return))
    q_relief = surplus - q_bypass
    p = _pressure(q, k.inlet, p_in, q_bypass, k.bypass, pump.p_return)
    p = pump.relief if q_relief > 1e-9 * Q else p  # less is rounding
    return Single(q, Circuit(Q, q_bypass, q_relief, p, 0.0))


class PassedBetween(NamedTuple):
    """What flows on through the first valve's bypass, and what it meets there."""

    flow: float
    behind: Orifice  # bypass of the first valve and all of the second, as one orifice


class _Bounds(NamedTuple):
    """Between which the flow through the first valve's bypass lies when the relief valve is open."""

    low: float
    high: float


@kernel
def behind_first(w: float, first: Orifices, second: Orifices, p_second: float, pump: Pump) -> Orifice:
    """The first bypass, and the second valve behind it, as one orifice at the flow w."""
    b = first.bypass * first.bypass
    q = inlet_share(w, second.inlet, second.bypass * second.bypass, p_second - pump.p_return)
    valve = as_one(w, q, second.inlet, second.bypass * second.bypass, p_second, pump.p_return)
    return Orifice(b * valve.square / (b + valve.square + 1e-300), valve.p_rest)


@kernel
def _series_pass(
    w: float, Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, bounds: _Bounds, pump: Pump
) -> PassedBetween:
    """Second valve and first bypass as one orifice at the flow w, then the closed form for the first valve."""
    behind = behind_first(w, first, second, p_second, pump)
    q = inlet_share(Q, first.inlet, behind.square, p_first - behind.p_rest)
    q = min(q, orifice_flow(first.inlet, pump.relief - p_first))
    at_relief = max(sqrt(max(behind.square * (pump.relief - behind.p_rest), 0.0)), bounds.low)
    return PassedBetween(min(Q - q, min(at_relief, bounds.high)), behind)


@kernel
def passed_between(
    Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump
) -> PassedBetween:
    """Five passes; the start is that from which the slowest states, those at relief, settle soonest."""
    b, c = first.bypass * first.bypass, second.bypass * second.bypass
    # what both bypasses take when the relief valve is open; the second inlet adds to it
    low = sqrt(b * c / (b + c + 1e-300) * (pump.relief - pump.p_return))
    bounds = _Bounds(low, low + orifice_flow(second.inlet, pump.relief - p_second))
    w = min(Q, bounds.low + 0.25 * (bounds.high - bounds.low))
    # a pass that changed nothing is the last: leaving out the others gives the same bits
    x = _series_pass(w, Q, first, second, p_first, p_second, bounds, pump)
    y = _series_pass(x.flow, Q, first, second, p_first, p_second, bounds, pump) if x.flow != w else x
    z = _series_pass(y.flow, Q, first, second, p_first, p_second, bounds, pump) if y.flow != x.flow else y
    x = _series_pass(z.flow, Q, first, second, p_first, p_second, bounds, pump) if z.flow != y.flow else z
    return _series_pass(x.flow, Q, first, second, p_first, p_second, bounds, pump) if x.flow != z.flow else x


@kernel
def series_at(Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump) -> Series:
    """Two actuators on a pump that delivers Q."""
    return series_from(
        Q, passed_between(Q, first, second, p_first, p_second, pump).flow, first, second, p_first, p_second, pump
    )


@kernel
def series_from(
    Q: float, w: float, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump
) -> Series:
    """The same where it is known that w passes the first valve's bypass."""
    q_second = inlet_share(w, second.inlet, second.bypass * second.bypass, p_second - pump.p_return)
    q_bypass = w - q_second
    p_between = _pressure(q_second, second.inlet, p_second, q_bypass, second.bypass, pump.p_return)
    q_first = min(Q - w, orifice_flow(first.inlet, pump.relief - p_first))
    q_relief = Q - w - q_first
    p = _pressure(q_first, first.inlet, p_first, w, first.bypass, p_between)
    p = pump.relief if q_relief > 1e-9 * Q else p  # less is rounding
    return Series(q_first, q_second, p_between, Circuit(Q, q_bypass, q_relief, p, 0.0))
