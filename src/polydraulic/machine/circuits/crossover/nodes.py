"""Nodes of circuits that a crossover valve joins, at given pressures: what flows there, in closed form or by few safe steps.

A pressure is a sum of two numbers, the second far below the roundings of the first. A wide orifice at hardly any pressure drop then still has its
flow to the last digit. Flows are single numbers: roundings of these are sources at nodes, and no flow of a network of orifices is further off than
the sources are large.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, log
from polydraulic.machine.circuits.series.check import LEAST
from polydraulic.machine.circuits.series.march import over
from polydraulic.machine.pump import Circuit, Pump, Single, delivered, limits, single_at
from polydraulic.machine.valve import Orifices

_NEWTON, _CHORDS, _STEPS = 40, 24, 80
_SETTLED = 1e-15  # of ln of a pump's flow


class FinePressure(NamedTuple):
    """A pressure, Pa, as the sum of two numbers."""

    coarse: float
    fine: float


class CrossoverOrifice(NamedTuple):
    """An orifice behind a check valve, which takes its opening pressure of the drop and lets nothing back."""

    conductance: float  # m3/s/Pa^0.5
    opening_pressure: float  # Pa


class JoinedPorts(NamedTuple):
    """Pressures at the ports of all valves, Pa, the giving pump's first."""

    p_1: float
    p_2: float
    p_3: float
    p_4: float


class JoinedPumps(NamedTuple):
    """Conductances, port pressures and pumps of a whole circuit, the giving pump's valves first."""

    cross: CrossoverOrifice
    k_1: Orifices
    k_2: Orifices
    k_3: Orifices
    k_4: Orifices
    ports: JoinedPorts
    gives: Pump
    takes: Pump


class JoinedFlows(NamedTuple):
    """Flows of all valves, pressures between those of a pump, and its flows and pressure."""

    q_1: float
    q_2: float
    q_3: float
    q_4: float
    q_cross: float
    p_giving: float
    p_taking: float
    giving: Circuit
    taking: Circuit
    status: int


class Behind(NamedTuple):
    """What passes a bypass at a given pressure before it, and how the valve behind shares it."""

    passed: float
    q_in: float
    q_tank: float
    p: float  # Pa, behind the bypass


class Giving(NamedTuple):
    """The giving pump's circuit at a pressure; `rest` is what is left for crossover and relief valve."""

    q_pump: float
    q_in: float
    behind: Behind
    rest: float


@kernel
def raised(p: FinePressure, by: float) -> FinePressure:
    """A pressure and a number, added."""
    s = p.coarse + by
    t = s - p.coarse
    e = ((p.coarse - (s - t)) + (by - t)) + p.fine
    coarse = s + e
    return FinePressure(coarse, e - (coarse - s))


@kernel
def drop(p: FinePressure, port: float) -> float:
    """Pressure less that at a port, rounded once."""
    return over(p.fine, p.coarse, port)


@kernel
def orifice_passes(conductance: float, p: FinePressure, port: float) -> float:
    """Flow of an orifice; a check valve lets nothing back."""
    return conductance * sqrt(max(drop(p, port), 0.0))


@kernel
def behind_bypass(p: FinePressure, bypass: float, k: Orifices, p_in: float, p_return: float) -> Behind:
    """A bypass, and behind it a valve with its own inlet and bypass, at the pressure before.

    Up to where the higher of both ports opens the other one takes all: a closed form. Beyond, with z the pressure over the higher port,
    b sqrt(y - z) = k_low sqrt(z + d) + k_high sqrt(z): in s = sqrt(z) the difference is convex, and Newton from above cannot pass the root.
    """
    inlet_low = k.bypass <= 0.0 or (k.inlet > 0.0 and p_in <= p_return)
    k_low, p_low = (k.inlet if inlet_low else k.bypass), (p_in if inlet_low else p_return)
    k_high, p_high = (k.bypass if inlet_low else k.inlet), (p_return if inlet_low else p_in)
    b, a = bypass * bypass, k_low * k_low
    d = max(p_high - p_low, 0.0)
    y = max(drop(p, p_low), 0.0)
    alone = sqrt(a * b / (a + b + 1e-300) * y)
    needed = k_low * sqrt(d) / max(bypass, LEAST)
    above = drop(p, p_high)
    both = k_high > 0.0 and bypass > 0.0 and above > needed * needed
    q_low, q_high, z, s = alone, 0.0, y * b / (a + b + 1e-300), 0.0
    if both:
        both_k = k_low + k_high
        s = bypass * sqrt(above / (b + both_k * both_k))
        for _ in range(_NEWTON):
            low, left = sqrt(s * s + d), sqrt(max(above - s * s, 0.0))
            off = k_low * low + k_high * s - bypass * left
            slope = k_low * s / (low + 1e-300) + k_high + bypass * s / (left + 1e-300)
            new = max(s - off / (slope + 1e-300), 0.0)
            if new >= s:
                break
            s = new
        q_low, q_high, z = k_low * sqrt(s * s + d), k_high * s, s * s
    at = (p_high if both else p_low) + z
    return Behind(q_low + q_high, q_low if inlet_low else q_high, q_high if inlet_low else q_low, at)


@kernel
def giving_at(
    p: FinePressure, first: Orifices, second: Orifices, p_first: float, p_second: float, pump: Pump
) -> Giving:
    """The giving circuit at its pump's pressure."""
    q_pump = delivered(p.coarse, pump)
    q_in = orifice_passes(first.inlet, p, p_first)
    behind = behind_bypass(p, first.bypass, second, p_second, pump.p_return)
    return Giving(q_pump, q_in, behind, q_pump - q_in - behind.passed)


@kernel
def first_valve(k: Orifices, p_in: float, behind: FinePressure, pump: Pump) -> Single:
    """The taking pump and its first valve, with the pressure behind that valve's bypass.

    Pressures are differences to the one behind; below the torque limit a closed form, at it ln of the flow is the root of a rising function.
    """
    port, relief = -drop(behind, p_in), -drop(behind, pump.relief)
    here = Pump(pump.flow, relief, 0.0, pump.limit_start, pump.limit_exponent, pump.log_least)
    n, y, y_last = pump.limit_exponent, 0.0, 0.0
    low, high, off_low, off_high = pump.log_least, 0.0, -1e-300, 1.0
    s, was_above = Single(0.0, Circuit(0.0, 0.0, 0.0, 0.0, 0.0)), True
    for step in range(_STEPS):
        s = single_at(pump.flow * exp(y), k, port, here)
        p = behind.coarse + s.circuit.p_pump
        off = n * log(max(p / pump.limit_start, 1.0)) + y
        if abs(off) <= _SETTLED or (step == 0 and not limits(p, pump)):
            break
        above = off > 0.0
        # an end that stays twice counts half, so that the chord does not get stuck
        stays = 0.5 if step > 1 and above == was_above else 1.0
        off_low, off_high = (stays * off_low if above else off), (off if above else stays * off_high)
        was_above = above
        low, high, y_last = (low if above else y), (y if above else high), y
        middle, chord = 0.5 * (low + high), (low * off_high - high * off_low) / (off_high - off_low)
        y = middle if (step & 7) == 7 or step >= _CHORDS or chord < low or chord > high else chord
        y = pump.log_least if step == 0 else y
        if y == y_last:
            break
    c = s.circuit
    return Single(s.q_in, Circuit(c.q_pump, c.q_bypass, c.q_relief, behind.coarse + c.p_pump, 0.0))
