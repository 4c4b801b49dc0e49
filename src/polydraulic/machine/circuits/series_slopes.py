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


class Linear(NamedTuple):
    """Conductances of a valve's two orifices at its flows, m3/s/Pa, and what its spool adds to these flows, m2/s."""

    inlet: float
    bypass: float
    inlet_source: float
    bypass_source: float


@kernel
def linear(k: Orifices, by_spool: Orifices, q_in: float, passed: float) -> Linear:
    """A valve at its flows; `by_spool` are the slopes of its conductances."""
    return Linear(
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
def divider(bypass: float, beyond: float) -> float:
    """Change of pressure behind a bypass as a share of that before it, with a conductance beyond."""
    return bypass / (bypass + beyond + 1e-300)


@kernel
def own_slope(inlet: float, rest: float) -> float:
    """Slope of an inlet's flow over a source in it, with all else at its node as one conductance."""
    return rest / (inlet + rest + 1e-300)


@kernel
def before_source(source: float, bypass: float, before: float, beyond: float) -> float:
    """Fall of the pressure before a bypass over a source across it, with conductances before and beyond."""
    return source * beyond / (before * beyond + bypass * beyond + bypass * before + 1e-300)
