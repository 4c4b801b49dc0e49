"""A crossover valve: a check valve and an orifice from one pump's node to the node before the second valve of another pump's two.

Along a path of the giving pump's pressure, and then, once its relief valve is open, of what that takes, everything follows: what the
giving circuit leaves for the crossover, the pressure behind it, what the taking circuit's first valve passes at this pressure and what the
second takes. Less and less arrives along the path and more is taken, so that the surplus has one root, which is bracketed. If the check valve
stays shut, both circuits are as without a crossover. The surplus that is left is a source at a node: no flow is further off than that. Where two
neighbouring numbers leave more, flows are shared between their answers.
"""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.series_check import CERTAIN, FAR, PROVED, UNPROVED, delivers
from polydraulic.machine.pump import Circuit, Pump, Single, delivered, series_circuit, single_circuit
from polydraulic.machine.valve import Orifices, orifice_flow

_STEPS = 240  # every fourth one halves
_REST = 1e-14  # share of both pumps' flows; a smaller surplus is rounding


class Crossed(NamedTuple):
    """Flows with a crossover valve."""

    q_giving: float  # into the actuator of the giving circuit
    q_cross: float  # from the giving circuit to the taking one
    q_first: float  # into the actuators of the taking circuit
    q_second: float
    p_between: float  # before the second valve
    giving: Circuit
    taking: Circuit
    status: int


class _Tried(NamedTuple):
    """Both circuits at a place of the path, and what is left over before the second valve."""

    q_giving: float
    q_cross: float
    giving: Circuit
    first: Single
    q_second: float
    q_tank: float
    p: float
    surplus: float


@kernel
def _tried(
    place: float,
    cross: float,
    giving: Orifices,
    first: Orifices,
    second: Orifices,
    p_giving: float,
    p_first: float,
    p_second: float,
    gives: Pump,
    takes: Pump,
) -> _Tried:
    """At `place`: up to the relief pressure the giving pump's pressure, beyond it what share of the rest that valve takes."""
    p_pump, to_relief = min(place, gives.relief), max(place / gives.relief - 1.0, 0.0)
    q_pump = delivered(p_pump, gives)
    q_giving = orifice_flow(giving.inlet, p_pump - p_giving)
    q_bypass = orifice_flow(giving.bypass, p_pump - gives.p_return)
    q_relief = to_relief * max(q_pump - q_giving - q_bypass, 0.0)
    q_cross = max(q_pump - q_giving - q_bypass - q_relief, 0.0)
    drop = q_cross / cross
    p = p_pump - drop * drop
    behind = Pump(takes.flow, takes.relief, p, takes.limit_start, takes.limit_exponent, takes.log_least)
    f = single_circuit(first, p_first, behind)
    q_second, q_tank = orifice_flow(second.inlet, p - p_second), orifice_flow(second.bypass, p - takes.p_return)
    surplus = q_cross + f.circuit.q_bypass - q_second - q_tank
    return _Tried(q_giving, q_cross, Circuit(q_pump, q_bypass, q_relief, p_pump, 0.0), f, q_second, q_tank, p, surplus)


@kernel
def _between(a: float, b: float, share: float) -> float:
    return a + share * (b - a)


@kernel
def _circuit_between(a: Circuit, b: Circuit, share: float) -> Circuit:
    return Circuit(
        _between(a.q_pump, b.q_pump, share),
        _between(a.q_bypass, b.q_bypass, share),
        _between(a.q_relief, b.q_relief, share),
        _between(a.p_pump, b.p_pump, share),
        0.0,
    )


@kernel
def _status(off: float, giving: Circuit, taking: Circuit, gives: Pump, takes: Pump) -> int:
    """Flows are proved if little is left over, and both pumps deliver theirs."""
    certain = off <= CERTAIN * (gives.flow + takes.flow)
    return PROVED if certain and delivers(giving, gives) and delivers(taking, takes) else UNPROVED


@kernel
def _shared(a: _Tried, b: _Tried, gives: Pump, takes: Pump) -> Crossed:
    """Flows between those of two neighbouring pressures, so that nothing is left over."""
    share = min(max(a.surplus / (a.surplus - b.surplus), 0.0), 1.0) if a.surplus > b.surplus else 0.0
    spread = abs(b.q_cross - a.q_cross) + abs(b.q_giving - a.q_giving)
    spread = spread + abs(b.first.q_in - a.first.q_in) + abs(b.q_second - a.q_second)
    taking_a = Circuit(a.first.circuit.q_pump, a.q_tank, a.first.circuit.q_relief, a.first.circuit.p_pump, 0.0)
    taking_b = Circuit(b.first.circuit.q_pump, b.q_tank, b.first.circuit.q_relief, b.first.circuit.p_pump, 0.0)
    off = min(spread, abs(a.surplus), abs(b.surplus))
    giving, taking = _circuit_between(a.giving, b.giving, share), _circuit_between(taking_a, taking_b, share)
    return Crossed(
        _between(a.q_giving, b.q_giving, share),
        _between(a.q_cross, b.q_cross, share),
        _between(a.first.q_in, b.first.q_in, share),
        _between(a.q_second, b.q_second, share),
        _between(a.p, b.p, share),
        giving,
        taking,
        _status(off, giving, taking, gives, takes),
    )


@kernel
def crossover(
    cross: float,
    giving: Orifices,
    first: Orifices,
    second: Orifices,
    p_giving: float,
    p_first: float,
    p_second: float,
    gives: Pump,
    takes: Pump,
) -> Crossed:
    """One actuator on a pump that also feeds the second of two on another pump.

    Parameters
    ----------
    cross : float, m3/s/Pa^0.5
        Conductance of the crossover; its check valve lets nothing back.
    giving, first, second : Orifices, m3/s/Pa^0.5
        Of the giving circuit's valve, and of the two of the taking circuit.
    p_giving, p_first, p_second : float, Pa
        At their pressurised ports.
    gives, takes : Pump
    """
    g, t = single_circuit(giving, p_giving, gives), series_circuit(first, second, p_first, p_second, takes)
    flow = gives.flow + takes.flow
    # what opens first behind the node, and the pressure there without a crossover
    lowest = min(p_second if second.inlet > 0.0 else FAR, takes.p_return if second.bypass > 0.0 else FAR)
    arrives = t.q_second + t.circuit.q_bypass > 0.0
    before = max(t.p_between, lowest) if arrives else lowest
    if cross <= 0.0 or g.circuit.p_pump <= before:
        status = _status(0.0, g.circuit, t.circuit, gives, takes)
        return Crossed(g.q_in, 0.0, t.q_first, t.q_second, t.p_between, g.circuit, t.circuit, status)
    low = before
    high = g.circuit.p_pump if g.circuit.p_pump < gives.relief else 2.0 * gives.relief
    a = _tried(low, cross, giving, first, second, p_giving, p_first, p_second, gives, takes)
    b = _tried(high, cross, giving, first, second, p_giving, p_first, p_second, gives, takes)
    off_low, off_high = a.surplus, b.surplus
    for step in range(_STEPS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high or abs(a.surplus) <= _REST * flow:
            break
        chord = (low * off_high - high * off_low) / (off_high - off_low - 1e-300)
        place = middle if (step & 3) == 3 or chord <= low or chord >= high else chord
        m = _tried(place, cross, giving, first, second, p_giving, p_first, p_second, gives, takes)
        # the end that stays counts half, so that the chord does not get stuck
        if m.surplus > 0.0 or abs(m.surplus) <= _REST * flow:
            low, off_low, off_high, a = place, m.surplus, 0.5 * off_high, m
        else:
            high, off_high, off_low, b = place, m.surplus, 0.5 * off_low, m
    b = a if abs(a.surplus) <= _REST * flow else b
    return _shared(a, b, gives, takes)
