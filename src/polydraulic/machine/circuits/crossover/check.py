"""Flows of two circuits that a crossover joins after their passes, with a certificate: a bound of how far they are off.

As in `series.check`, the pressure before a valve follows from the orifice that knows it best, and the others say by how much their flow differs from what it drives.
Roundings of pressures count, too: an orifice that has just opened turns them into flow. What can be off by more than `SURE` is not proved.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.crossover.nodes import JoinedFlows, JoinedPumps
from polydraulic.machine.circuits.crossover.passes import JoinedPath, Joining
from polydraulic.machine.circuits.series.check import FAR, LEAST, PROVED, UNPROVED, Junction
from polydraulic.machine.circuits.series.passes import Outlet, passed_on
from polydraulic.machine.pump import Circuit, Pump, delivered
from polydraulic.machine.valve import Orifices, orifice_flow

SURE = 1e-12  # share of the smaller pump's flow by which flows may be off
_REST = 4e-15  # of the smaller pump's flow: less is rounding, and no flow
_OPENED = 1e-9  # of pump flow; a relief valve that lets less through is shut
_ROUNDING = 4.5e-16  # of the relief pressure: what differences of pressures are off


class _Ways(NamedTuple):
    """Flows from a node, m3/s: into the actuator, past the valve, through a crossover."""

    inlet: float
    bypass: float
    cross: float


class _Bases(NamedTuple):
    """Pressures behind bypass and crossover less that at the valve's port, Pa; by how much differences of pressures may be off."""

    bypass: float
    cross: float
    rounding: float


@kernel
def _unmet(flow: float, conductance: float, over: float, rounding: float) -> float:
    """How much a flow can differ from what a pressure drop drives."""
    rounded = 2.0 * rounding * conductance / sqrt(max(over, rounding)) if over > -rounding else 0.0
    return abs(flow - orifice_flow(conductance, over)) + rounded


@kernel
def _differ(q: _Ways, k: Orifices, k_x: float, over: float, b: _Bases) -> _Ways:
    """How much all flows from a node can differ from what its pressure drives."""
    return _Ways(
        _unmet(q.inlet, k.inlet, over, b.rounding),
        _unmet(q.bypass, k.bypass, over - b.bypass, b.rounding),
        _unmet(q.cross, k_x, over - b.cross, b.rounding),
    )


@kernel
def _knows_more(k: float, q: float, k_other: float, q_other: float) -> bool:
    """Whether an orifice's slope, conductance squared over flow, is larger than another's."""
    return q > 0.0 and (q_other <= 0.0 or k * k * q_other >= k_other * k_other * q)


@kernel
def _root(flow: float, conductance: float) -> float:
    return flow / max(conductance, LEAST)


@kernel
def _node(q: _Ways, k: Orifices, k_x: float, b: _Bases) -> Junction:
    """Pressure before a valve less that at its port, and the sum of differences there."""
    by_cross = _knows_more(k_x, q.cross, k.inlet, q.inlet) and _knows_more(k_x, q.cross, k.bypass, q.bypass)
    by_inlet = not by_cross and _knows_more(k.inlet, q.inlet, k.bypass, q.bypass)
    to_inlet, to_bypass, to_cross = _root(q.inlet, k.inlet), _root(q.bypass, k.bypass), _root(q.cross, k_x)
    still = q.inlet <= 0.0 and q.bypass <= 0.0 and q.cross <= 0.0
    # nothing arrives: the pressure is that at which the first of both opens
    rest = min(0.0 if k.inlet > 0.0 else FAR, b.bypass if k.bypass > 0.0 else FAR)
    over = to_inlet * to_inlet if by_inlet else b.bypass + to_bypass * to_bypass
    over = b.cross + to_cross * to_cross if by_cross else (rest if still else over)
    d = _differ(q, k, k_x, over, b)
    sum_ = (0.0 if by_inlet else d.inlet) + (0.0 if by_cross else d.cross)
    sum_ = sum_ + (d.bypass if by_inlet or by_cross else 0.0)
    shut = (0.0 if k.inlet > 0.0 else q.inlet) + (0.0 if k.bypass > 0.0 else q.bypass) + (0.0 if k_x > 0.0 else q.cross)
    return Junction(over, 0.0 if still else sum_ + shut)


@kernel
def _at_pump(q: _Ways, q_relief: float, k: Orifices, k_x: float, p_in: float, b: _Bases, pump: Pump) -> Junction:
    """The same at the pump, where the relief valve bounds the pressure, and holds it while it is open."""
    free, highest = _node(q, k, k_x, b), pump.relief - p_in
    opened = q_relief > _OPENED * pump.flow
    held = opened or free.over > highest
    d = _differ(q, k, k_x, highest, b)
    unmet = (d.inlet + d.bypass + d.cross if held else free.unmet) + (0.0 if opened else abs(q_relief))
    return Junction(highest if held else free.over, unmet)


@kernel
def _some(q: float, flow: float) -> float:
    """A flow, or none where it is but rounding."""
    return q if q > _REST * flow else 0.0


@kernel
def joined_end(x: Joining, r: JoinedPath, v: JoinedPumps) -> JoinedFlows:
    """Flows after the passes, with pressures and certificate, which does not look at torque limits."""
    p, gives, takes = v.ports, v.gives, v.takes
    flow, rounding = min(gives.flow, takes.flow), _ROUNDING * max(gives.relief, takes.relief)
    w_1, arrives = _some(x.w, flow), _some(x.arrives, flow)
    w_3 = _some(arrives - x.crosses, flow)
    cross = arrives - w_3
    w_2 = passed_on(w_1, r.a_2, p.p_2, Outlet(r.b_2, gives.p_return))
    w_4 = passed_on(arrives, r.a_4, p.p_4, Outlet(r.b_4, takes.p_return))
    left_1, left_3 = x.q_gives - cross - w_1, x.q_takes - w_3
    q_1 = _some(min(left_1, orifice_flow(v.k_1.inlet, gives.relief - p.p_1)), flow)
    q_3 = _some(min(left_3, orifice_flow(v.k_3.inlet, takes.relief - p.p_3)), flow)
    q_2, q_4, relief_1, relief_3 = w_1 - w_2, arrives - w_4, left_1 - q_1, left_3 - q_3
    second = _node(_Ways(q_2, w_2, 0.0), v.k_2, 0.0, _Bases(gives.p_return - p.p_2, 0.0, rounding))
    fed = _node(_Ways(q_4, w_4, 0.0), v.k_4, 0.0, _Bases(takes.p_return - p.p_4, 0.0, rounding))
    to_fed = fed.over + (p.p_4 - p.p_1) + r.opening
    bases = _Bases(second.over + (p.p_2 - p.p_1), to_fed, rounding)
    one = _at_pump(_Ways(q_1, w_1, cross), relief_1, v.k_1, v.cross.conductance, p.p_1, bases, gives)
    bases = _Bases(fed.over + (p.p_4 - p.p_3), 0.0, rounding)
    three = _at_pump(_Ways(q_3, w_3, 0.0), relief_3, v.k_3, 0.0, p.p_3, bases, takes)
    unmet = second.unmet + fed.unmet + one.unmet + three.unmet
    known = abs(p.p_1) + abs(p.p_2) + abs(p.p_3) + abs(p.p_4) < FAR
    p_one, p_three = p.p_1 + one.over, p.p_3 + three.over
    # pressures fall on the way. A node behind which all is shut has the pressure before it; where nothing arrives, the fed one's is the least that keeps it so
    p_second, p_fed = p.p_2 + second.over, p.p_4 + fed.over
    behind_first = p_one if w_1 > 0.0 or v.k_1.bypass > 0.0 else p.p_2
    pushed = max(p_one - r.opening, p_three if w_3 > 0.0 or v.k_3.bypass > 0.0 else p_one - r.opening)
    return JoinedFlows(
        q_1,
        q_2,
        q_3,
        q_4,
        cross,
        min(p_second, behind_first) if w_1 > 0.0 or second.over >= FAR else p_second,
        min(p_fed, pushed),
        Circuit(x.q_gives, w_2, max(relief_1, 0.0), p_one, 0.0),
        Circuit(x.q_takes, w_4, max(relief_3, 0.0), p_three, 0.0),
        PROVED if known and unmet <= 0.5 * SURE * flow else UNPROVED,
    )


@kernel
def joined_deliver(giving: Circuit, taking: Circuit, gives: Pump, takes: Pump) -> bool:
    """Whether both pumps deliver their flows at their pressures, within what `joined_end` leaves of `SURE`."""
    off = abs(giving.q_pump - delivered(giving.p_pump, gives)) + abs(taking.q_pump - delivered(taking.p_pump, takes))
    return off <= 0.5 * SURE * min(gives.flow, takes.flow)
