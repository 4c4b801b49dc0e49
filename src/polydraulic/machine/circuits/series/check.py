"""The certificate of a circuit: how much its flows can be off, from what its orifices would let through.

Flows that are shared out add up at every node by construction. From the last node to the pump, each pressure follows from the
orifice that knows it best; the others then say by how much their flow differs from what this pressure drives. Every element of
a circuit passes more at a higher pressure drop. The answer of such a network to a source across one element is nowhere larger than the
source, so that no flow is further off than the sum of all differences: a bound, not an estimate.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.pump import Circuit, Pump, delivered
from polydraulic.machine.valve import Orifices, orifice_flow

PROVED, REPAIRED, UNPROVED = 0, 1, 2  # status of a circuit: flows of its passes, of its march, or not to be trusted
CERTAIN = 1e-10  # share of pump flow by which flows may be off
FAR = 1e30  # Pa; a pressure that nothing reaches
LEAST = 1e-30  # m3/s/Pa^0.5; what is narrower might as well be shut


class Junction(NamedTuple):
    """Pressure before a valve less that at its port, and the sum of differences up to there."""

    over: float
    unmet: float


@kernel
def _root(flow: float, conductance: float) -> float:
    return flow / max(conductance, LEAST)


@kernel
def node(q_in: float, passed: float, k: Orifices, p_in: float, p_next: float, behind: Junction) -> Junction:
    """Before a valve, from what lies behind its bypass.

    Of the two orifices, that of the larger slope, conductance squared over flow, gives the pressure; the other one is judged.
    """
    to_inlet, to_bypass = _root(q_in, k.inlet), _root(passed, k.bypass)
    base = behind.over + (p_next - p_in)
    from_inlet = q_in > 0.0 and (passed <= 0.0 or k.inlet * k.inlet * passed >= k.bypass * k.bypass * q_in)
    by_bypass = base + to_bypass * to_bypass
    over = to_inlet * to_inlet if from_inlet else by_bypass
    driven = (k.bypass if from_inlet else k.inlet) * sqrt(max(over - base if from_inlet else over, 0.0))
    differs = abs(driven - (passed if from_inlet else q_in))
    through_shut = (0.0 if k.inlet > 0.0 else q_in) + (0.0 if k.bypass > 0.0 else passed)
    # nothing arrives: the pressure is that at which the first of both opens
    still = q_in <= 0.0 and passed <= 0.0
    rest = min(0.0 if k.inlet > 0.0 else FAR, base if k.bypass > 0.0 else FAR)
    return Junction(rest if still else over, behind.unmet + (0.0 if still else differs + through_shut))


class First(NamedTuple):
    """Pressure of the pump, and the sum of all differences."""

    p: float
    unmet: float


@kernel
def first_node(
    q_in: float, passed: float, q_relief: float, k: Orifices, p_in: float, p_next: float, behind: Junction, pump: Pump
) -> First:
    """At the pump, where the relief valve bounds the pressure, and holds it while it is open."""
    free = node(q_in, passed, k, p_in, p_next, behind)
    highest = pump.relief - p_in
    base = behind.over + (p_next - p_in)
    opened = q_relief > 1e-9 * pump.flow  # less is rounding
    at_relief = opened or free.over > highest
    held = abs(q_in - orifice_flow(k.inlet, highest)) + abs(passed - orifice_flow(k.bypass, highest - base))
    unmet = behind.unmet + held if at_relief else free.unmet
    p = pump.relief if at_relief else p_in + free.over
    return First(p, unmet + (0.0 if opened else abs(q_relief)))


@kernel
def delivers(c: Circuit, pump: Pump) -> bool:
    """Whether the pump delivers its flow at its pressure."""
    return abs(c.q_pump - delivered(c.p_pump, pump)) <= CERTAIN * pump.flow


@kernel
def status_of(unmet: float, pump: Pump) -> int:
    """`PROVED` if all differences together are small enough."""
    return PROVED if unmet <= CERTAIN * pump.flow else UNPROVED
