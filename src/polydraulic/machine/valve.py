"""A main valve: spool displacement -> orifice conductances K a, and the flow through an orifice (Eqs 1, 2, 5).

The tables are linear between the spool's knots. Each segment is written from its left knot, so that a closed orifice
is exactly zero, without a threshold.
"""

from math import inf, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.parameters.layout.parts import ValveCurves
from polydraulic.parameters.schema import Knots, Spool, Valve


class Segments(NamedTuple):
    """Left values and slopes of the five segments of one orifice table."""

    v0: float
    v1: float
    v2: float
    v3: float
    v4: float
    s0: float
    s1: float
    s2: float
    s3: float
    s4: float


class ValveTables(NamedTuple):
    """A valve prepared for evaluation; k1..k4 are the inner knots, k5 the full travel."""

    k1: float
    k2: float
    k3: float
    k4: float
    k5: float
    inlet: Segments
    bypass: Segments
    outlet_positive: Segments
    outlet_negative: Segments


class Orifices(NamedTuple):
    """Conductances K a of the three orifices, m3/s/Pa^0.5."""

    inlet: float
    bypass: float
    outlet: float


def prepare_valve(valve: Valve, spool: Spool) -> ValveTables:
    """Turn the tables into segments."""

    def segments(values: Knots) -> Segments:
        slopes = [(values[i + 1] - values[i]) / (spool.knots[i + 1] - spool.knots[i]) for i in range(5)]
        return Segments(*values[:5], *slopes)

    tables = (segments(table) for table in valve)
    return ValveTables(*spool.knots[1:], *tables)


def spool_edges(valve: ValveCurves) -> tuple[float, float]:
    """Travel in m at which a valve opens (0 if it never is shut), and at which its bypass is shut (inf if it never is)."""
    tables = (valve.inlet, valve.outlet_positive, valve.outlet_negative)
    shut = [knot for k, knot in enumerate(valve.knots) if all(max(table[: k + 1]) == 0.0 for table in tables)]
    closed = [knot for k, knot in enumerate(valve.knots) if max(valve.bypass[k:]) == 0.0]
    return shut[-1] if shut else 0.0, closed[0] if closed else inf


@kernel
def _interpolate(x: float, t: ValveTables, s: Segments) -> float:
    y = s.v0 + s.s0 * x
    y = s.v1 + s.s1 * (x - t.k1) if x >= t.k1 else y
    y = s.v2 + s.s2 * (x - t.k2) if x >= t.k2 else y
    y = s.v3 + s.s3 * (x - t.k3) if x >= t.k3 else y
    y = s.v4 + s.s4 * (x - t.k4) if x >= t.k4 else y
    return max(y, 0.0)


@kernel
def orifices(spool: float, valve: ValveTables) -> Orifices:
    """Conductances at a spool displacement in m; only the outlet differs between the two signs."""
    x = min(abs(spool), valve.k5)
    positive = _interpolate(x, valve, valve.outlet_positive)
    negative = _interpolate(x, valve, valve.outlet_negative)
    return Orifices(
        _interpolate(x, valve, valve.inlet),
        _interpolate(x, valve, valve.bypass),
        positive if spool >= 0.0 else negative,
    )


@kernel
def _slope(x: float, t: ValveTables, s: Segments) -> float:
    y = s.s0
    y = s.s1 if x >= t.k1 else y
    y = s.s2 if x >= t.k2 else y
    y = s.s3 if x >= t.k3 else y
    y = s.s4 if x >= t.k4 else y
    return y if x < t.k5 else 0.0


@kernel
def orifice_slopes(spool: float, valve: ValveTables) -> Orifices:
    """Slopes of the conductances over the spool displacement, m2/s/Pa^0.5; constant between two knots."""
    x, positive = abs(spool), spool >= 0.0
    sign = 1.0 if positive else -1.0
    outlet = _slope(x, valve, valve.outlet_positive) if positive else _slope(x, valve, valve.outlet_negative)
    return Orifices(sign * _slope(x, valve, valve.inlet), sign * _slope(x, valve, valve.bypass), sign * outlet)


@kernel
def orifice_flow(conductance: float, drop: float) -> float:
    """Turbulent orifice flow in m3/s; a check valve lets nothing back (drop in Pa)."""
    return conductance * sqrt(max(drop, 0.0))
