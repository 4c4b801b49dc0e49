"""A main valve: spool displacement -> orifice conductances K a, and the flow through an orifice (Eqs 1, 2, 5).

The tables are linear between the spool's knots. Each segment is written from its left knot, so that a closed orifice
is exactly zero, without a threshold.
"""

from math import inf, sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.parameters.layout.parts import ValveCurves


class Orifices(NamedTuple):
    """Conductances K a of the three orifices, m3/s/Pa^0.5."""

    inlet: float
    bypass: float
    outlet: float


def spool_edges(valve: ValveCurves) -> tuple[float, float]:
    """Travel in m at which a valve opens (0 if it never is shut), and at which its bypass is shut (inf if it never is)."""
    tables = (valve.inlet, valve.outlet_positive, valve.outlet_negative)
    shut = [knot for k, knot in enumerate(valve.knots) if all(max(table[: k + 1]) == 0.0 for table in tables)]
    closed = [knot for k, knot in enumerate(valve.knots) if max(valve.bypass[k:]) == 0.0]
    return shut[-1] if shut else 0.0, closed[0] if closed else inf


@kernel
def orifice_flow(conductance: float, drop: float) -> float:
    """Turbulent orifice flow in m3/s; a check valve lets nothing back (drop in Pa)."""
    return conductance * sqrt(max(drop, 0.0))
