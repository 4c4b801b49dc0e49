"""Slopes of a path of conductances: what a source at a node, or across a bypass, changes.

Linearised, valves in series are nodes along a path: each has an inlet to a port and a bypass to the next, the last one's leads to the tank.
Seen from a node, all towards the tank is one conductance, all towards the pump another: two sweeps along the path give these.
Pressures then follow by dividers, from node to node, and no numbers of like size are subtracted.
"""

from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuit_slopes import _conductance, _pump, _source
from polydraulic.machine.pump import Circuit, Pump
from polydraulic.machine.valve import Orifices


class LinearValve(NamedTuple):
    """Conductances of a valve's two orifices at its flows, m3/s/Pa, and what its spool adds to these flows, m2/s."""

    inlet: float
    bypass: float
    inlet_source: float
    bypass_source: float


@kernel
def linear(k: Orifices, by_spool: Orifices, q_in: float, passed: float) -> LinearValve:
    """A valve at its flows; `by_spool` are the slopes of its conductances."""
    return LinearValve(
        _conductance(k.inlet, q_in),
        _conductance(k.bypass, passed),
        _source(k.inlet, by_spool.inlet, q_in),
        _source(k.bypass, by_spool.bypass, passed),
    )


@kernel
def pump_conductance(c: Circuit, pump: Pump) -> float:
    """Conductance of the pump: none, that of its torque limit, or one that holds the relief pressure."""
    return _pump(c, pump)


@kernel
def in_row(a: float, b: float) -> float:
    """Two conductances one after the other."""
    return a * b / (a + b + 1e-300)


@kernel
def divider(a: float, b: float) -> float:
    """Share of the first of two conductances."""
    return a / (a + b + 1e-300)


@kernel
def fall(source: float, conductance: float) -> float:
    """Fall of the pressure of a node that a source takes from, with all conductances at it."""
    return source / (conductance + 1e-300)


@kernel
def fall_before(source: float, bypass: float, before: float, beyond: float) -> float:
    """Fall of the pressure before a bypass with a source along it; `before` and `beyond` swapped, the rise behind it."""
    return source * beyond / (before * beyond + bypass * beyond + bypass * before + 1e-300)
