"""Pumps and their circuits: how a pump's flow is shared between actuators, bypasses and relief valve (Eqs 1-3, 8-13).

One circuit has a closed form. Two valves in series are solved by the same form, five times: at the flow that passes the
first valve, the second one looks like a single orifice. A torque limit is a root in one unknown, the pump flow, found in
a bounded number of Newton steps within a bracket; once a step, after the first, changes nothing, neither do the others. Clamps decide
all special cases.
"""

from math import log as natural_log
from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, log
from polydraulic.machine.valve import Orifices, orifice_flow
from polydraulic.parameters.layout.parts import PumpParameters

LIMIT_PASSES = 10
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
def _inlet_share(Q: float, k_in: float, b: float, drop: float) -> float:
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
def _as_one(Q: float, q: float, k_in: float, b: float, p_in: float, p_return: float) -> Orifice:
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


class Bracket(NamedTuple):
    """Where y = ln(Q / flow) of a torque-limited pump lies, and how far off both ends of that range are."""

    y: float
    low: float
    high: float
    off_low: float
    off_high: float
    low_unknown: bool


@kernel
def unlimited(pump: Pump) -> Bracket:
    """Where the search for the torque limit starts."""
    return Bracket(0.0, pump.log_least, 0.0, -1.0, 1.0, True)


@kernel
def _narrowed(x: Bracket, circuit: Orifice, pump: Pump) -> Bracket:
    """Newton step towards the torque limit, or the chord where it would go too far; the first one to the lower end.

    ln P rises with ln Q by 0 to 2, so that ln P + y / exponent is well conditioned. Its slope drops where an orifice
    opens, and Newton steps alone could swing around such a kink for ever.
    """
    n, Q = pump.limit_exponent, pump.flow * exp(x.y)
    rise = min(Q * Q / (circuit.square + 1e-300), 1e15)
    p = max(circuit.p_rest + rise, 1.0)
    off = n * log(p / pump.limit_start) + x.y
    above = off > 0.0
    low, off_low = (x.low if above else x.y), (x.off_low if above else min(off, -1e-300))
    high, off_high = (x.y if above else x.high), (off if above else x.off_high)
    newton = x.y - off / (1.0 + 2.0 * n * min(rise / p, 1.0))
    chord = (low * off_high - high * off_low) / (off_high - off_low)
    near = newton >= low and newton <= high and abs(newton - x.y) <= 0.5 * (high - low)
    y = newton if near else chord
    y = pump.log_least if x.low_unknown else y
    return Bracket(min(max(y, low), high), low, high, off_low, off_high, False)


@kernel
def limit_single(x: Bracket, k: Orifices, p_in: float, pump: Pump) -> Bracket:
    """One step towards the torque limit with one actuator on the pump."""
    b, Q = k.bypass * k.bypass, pump.flow * exp(x.y)
    q = _inlet_share(Q, k.inlet, b, p_in - pump.p_return)
    return _narrowed(x, _as_one(Q, q, k.inlet, b, p_in, pump.p_return), pump)


@kernel
def limits(p_pump: float, pump: Pump) -> bool:
    """Whether the torque limit lowers the flow of a pump that would otherwise have this pressure."""
    return pump.log_least < 0.0 and p_pump > pump.limit_start


@kernel
def single_at(Q: float, k: Orifices, p_in: float, pump: Pump) -> Single:
    """One actuator on a pump that delivers Q."""
    q = _inlet_share(Q, k.inlet, k.bypass * k.bypass, p_in - pump.p_return)
    q = min(q, orifice_flow(k.inlet, pump.relief - p_in))
    surplus = Q - q
    q_bypass = min(surplus, orifice_flow(k.bypass, pump.relief - pump.p_return))
    q_relief = surplus - q_bypass
    p = _pressure(q, k.inlet, p_in, q_bypass, k.bypass, pump.p_return)
    p = pump.relief if q_relief > 1e-9 * Q else p  # less is rounding
    return Single(q, Circuit(Q, q_bypass, q_relief, p, 0.0))


@kernel
def single_circuit(k: Orifices, p_in: float, pump: Pump) -> Single:
    """One actuator on a pump, Eqs (1)-(3).

    Parameters
    ----------
    k : Orifices, m3/s/Pa^0.5
    p_in : float, Pa
        At the pressurised port.
    pump : Pump
    """
    s = single_at(pump.flow, k, p_in, pump)
    if limits(s.circuit.p_pump, pump):
        x = unlimited(pump)
        for i in range(LIMIT_PASSES):
            y = x.y
            x = limit_single(x, k, p_in, pump)
            if i > 0 and x.y == y:
                break
        s = single_at(pump.flow * exp(x.y), k, p_in, pump)
    return s


class _Passed(NamedTuple):
    """What flows on through the first valve's bypass, and what it meets there."""

    flow: float
    behind: Orifice  # bypass of the first valve and all of the second, as one orifice


class _Bounds(NamedTuple):
    """Between which the flow through the first valve's bypass lies when the relief valve is open."""

    low: float
    high: float


@kernel
def _series_pass(
    w: float, Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, bounds: _Bounds, pump: Pump
) -> _Passed:
    """Second valve and first bypass as one orifice at the flow w, then the closed form for the first valve."""
    b = first.bypass * first.bypass
    q = _inlet_share(w, second.inlet, second.bypass * second.bypass, p_second - pump.p_return)
    valve = _as_one(w, q, second.inlet, second.bypass * second.bypass, p_second, pump.p_return)
    behind = Orifice(b * valve.square / (b + valve.square + 1e-300), valve.p_rest)
    q = _inlet_share(Q, first.inlet, behind.square, p_first - behind.p_rest)
    q = min(q, orifice_flow(first.inlet, pump.relief - p_first))
    at_relief = max(sqrt(max(behind.square * (pump.relief - behind.p_rest), 0.0)), bounds.low)
    return _Passed(min(Q - q, min(at_relief, bounds.high)), behind)


@kernel
def _passed(Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump) -> _Passed:
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
def limit_series(x: Bracket, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump) -> Bracket:
    """One step towards the torque limit with two actuators on the pump."""
    # without relief the pressure tells how far off the flow is; log_least then accounts for the relief valve
    ideal = Pump(pump.flow, NEVER, pump.p_return, pump.limit_start, pump.limit_exponent, pump.log_least)
    Q = pump.flow * exp(x.y)
    passed = _passed(Q, first, second, p_first, p_second, ideal)
    behind = passed.behind
    return _narrowed(x, _as_one(Q, Q - passed.flow, first.inlet, behind.square, p_first, behind.p_rest), pump)


@kernel
def series_at(Q: float, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump) -> Series:
    """Two actuators on a pump that delivers Q."""
    w = _passed(Q, first, second, p_first, p_second, pump).flow
    q_second = _inlet_share(w, second.inlet, second.bypass * second.bypass, p_second - pump.p_return)
    q_bypass = w - q_second
    p_between = _pressure(q_second, second.inlet, p_second, q_bypass, second.bypass, pump.p_return)
    q_first = min(Q - w, orifice_flow(first.inlet, pump.relief - p_first))
    q_relief = Q - w - q_first
    p = _pressure(q_first, first.inlet, p_first, w, first.bypass, p_between)
    p = pump.relief if q_relief > 1e-9 * Q else p  # less is rounding
    return Series(q_first, q_second, p_between, Circuit(Q, q_bypass, q_relief, p, 0.0))


@kernel
def series_circuit(first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump) -> Series:
    """Two actuators on a pump, the first with priority, Eqs (8)-(13).

    Parameters
    ----------
    first, second : Orifices, m3/s/Pa^0.5
        Of the two valves.
    p_first, p_second : float, Pa
        At the pressurised ports.
    pump : Pump
    """
    s = series_at(pump.flow, first, second, p_first, p_second, pump)
    if limits(s.circuit.p_pump, pump):
        x = unlimited(pump)
        for i in range(LIMIT_PASSES):
            y = x.y
            x = limit_series(x, first, second, p_first, p_second, pump)
            if i > 0 and x.y == y:
                break
        s = series_at(pump.flow * exp(x.y), first, second, p_first, p_second, pump)
    return s
