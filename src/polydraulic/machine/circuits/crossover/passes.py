"""Passes through two circuits that a crossover joins: all flows settle together, in the machine's own precision.

A pass knows what passes the giving pump's first bypass and the crossover, and what arrives before the fed valve. At these flows, whatever lies
behind the first bypass, the giving pump's outlets together and the fed valve are one outlet each, of the same pressure and slope (`series.passes`). So each pump is a source
that shares its flow between its own outlets and the way to the fed valve, in closed form. Where both are straight lines over the
pressure there, a quadratic equation says what arrives.

The higher that pressure, the less arrives: what a pass finds to be too little or too much bounds the answer, and a step out of the bounds halves them instead.
Bounds may be wrong as long as the giving pump's outlets still change; where nothing is left between them, they are begun anew.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.crossover.nodes import JoinedPorts, JoinedPumps
from polydraulic.machine.circuits.series.passes import (
    AT_FIRST,
    SHUT,
    Moved,
    Outlet,
    behind,
    least_flow,
    limited,
    limited_power,
    passed_first,
    passed_on,
    resistance,
    settled,
    stepped,
    tangent,
)
from polydraulic.machine.pump import Pump

JOINED_PASSES = 24  # at most; most states of real valves need a few
PACKED_PASSES, FEW_LANES = 8, 4  # of lanes: what is left then, or so few, goes on one by one
_CLOSE = 1e-8  # share of pump flow: a step this small is no step out of the bounds
_NARROW = 1e-5  # share of pump flow: between bounds that are closer nothing is looked for
_FREE = 1e-60  # Pa s/m3; below the resistance of anything


class JoinedPath(NamedTuple):
    """What resists the flow, Pa s2/m6: crossover, inlets and bypasses; the opening pressure of the crossover's check valve, Pa."""

    r_x: float
    a_1: float
    b_1: float
    a_2: float
    b_2: float
    a_3: float
    b_3: float
    a_4: float
    b_4: float
    opening: float


class Joining(NamedTuple):
    """Between two passes, m3/s: flows of the pumps, their least and last changes, as shares; what passes crossover and first bypass, and its last change.

    What arrives before the fed valve, and bounds of it; the largest change; whether all has settled.
    """

    q_gives: float
    least_gives: float
    dq_gives: float
    q_takes: float
    least_takes: float
    dq_takes: float
    crosses: float
    w: float
    dw: float
    arrives: float
    low: float
    high: float
    largest: float
    still: bool


class Supply(NamedTuple):
    """What a pump sends on to the fed valve, m3/s, and by how much less at a higher pressure there, m3/s/Pa."""

    q: float
    falls: float


@kernel
def joined_path(v: JoinedPumps) -> JoinedPath:
    """What resists the flow; the same in all passes."""
    return JoinedPath(
        resistance(v.cross.conductance),
        resistance(v.k_1.inlet),
        resistance(v.k_1.bypass),
        resistance(v.k_2.inlet),
        resistance(v.k_2.bypass),
        resistance(v.k_3.inlet),
        resistance(v.k_3.bypass),
        resistance(v.k_4.inlet),
        resistance(v.k_4.bypass),
        v.cross.opening_pressure,
    )


@kernel
def joined_begin(gives: Pump, takes: Pump) -> Joining:
    """Where passes start: most of the flow passes first bypasses, some the crossover; bounds beyond all that can be."""
    one, two = gives.flow, takes.flow
    arrives, most = 0.3 * one + 0.9 * two, 2.0 * (one + two)
    return Joining(
        one,
        least_flow(gives),
        AT_FIRST,
        two,
        least_flow(takes),
        AT_FIRST,
        0.3 * one,
        0.6 * one,
        AT_FIRST,
        arrives,
        -one,
        most,
        AT_FIRST,
        False,
    )


@kernel
def _supply(Q: float, own: Outlet, way: float, p: float, pump: Pump) -> Supply:
    """Of a pump that delivers Q to outlets of its `own`, through a resistance, at the pressure `p` behind it."""
    free = passed_on(Q, own.r, own.p_rest, Outlet(way, p))
    at_relief = sqrt(max(pump.relief - p, 0.0) / way)
    relieved = free > at_relief
    q = min(free, at_relief)
    falls = 0.5 / ((0.0 if relieved else own.r * (Q - q)) + way * q + _FREE)
    return Supply(q, 0.0 if q <= 0.0 or (q >= Q and not relieved) else falls)


@kernel
def _yields(r: float, q: float) -> float:
    """Slope of a flow over pressure, m3/s/Pa."""
    return 0.5 / (r * q + _FREE)


@kernel
def _to_limit(
    Q: float, last: float, least: float, own: Outlet, way: float, p: float, sent: float, falls: float, pump: Pump, still: bool, power: bool
) -> Moved:  # fmt: skip
    """A step of the pump's flow towards its torque limit; `falls` is the slope of what takes the flow behind its way to the fed valve.

    Parameters are those of `_supply`, of which `sent` is the answer, and what `limited` asks for.
    """
    rest = Q - sent
    from_way = own.r >= SHUT or rest <= 0.0
    p_pump = p + way * sent * sent if from_way else own.p_rest + own.r * rest * rest
    takes = (0.0 if from_way else _yields(own.r, rest)) + (
        0.5 / (way * sent + 0.5 / (falls + _FREE)) if sent > 0.0 else 0.0
    )
    r = min(0.5 * Q / (takes + _FREE), 1e15) / (Q * Q + 1e-300)
    whole = Outlet(r, p_pump - r * Q * Q)
    if power:
        moved = limited_power(Q, last, least, whole, pump, still)
    else:
        moved = limited(Q, last, least, whole, pump, still)
    return moved


@kernel
def joined_pass(
    x: Joining, r: JoinedPath, p: JoinedPorts, gives: Pump, takes: Pump, limit: bool, power: bool
) -> Joining:
    """One pass; `limit` if a pump has a torque limit, `power` if it is known to be one of constant power. What has settled stays."""
    still, old = x.still, x.arrives
    beyond = behind(x.w, r.a_2, p.p_2, Outlet(r.b_2, gives.p_return), r.b_1)
    mine = tangent(x.q_gives - x.crosses, r.a_1, p.p_1, beyond)
    fed = tangent(old, r.a_4, p.p_4, Outlet(r.b_4, takes.p_return))
    rise = fed.r * old * old
    at = fed.p_rest + rise
    other, first = Outlet(r.a_3, p.p_3), at + r.opening
    one, two = _supply(x.q_gives, mine, r.r_x, first, gives), _supply(x.q_takes, other, r.b_3, at, takes)
    q_1, q_2 = Moved(x.q_gives, 0.0), Moved(x.q_takes, 0.0)
    if limit:
        drawn, sent_1, sent_2 = _yields(fed.r, old), one.q, two.q
        q_1 = _to_limit(
            x.q_gives, x.dq_gives, x.least_gives, mine, r.r_x, first, sent_1, drawn + two.falls, gives, still, power
        )
        q_2 = _to_limit(
            x.q_takes, x.dq_takes, x.least_takes, other, r.b_3, at, sent_2, drawn + one.falls, takes, still, power
        )
        one, two = _supply(q_1.value, mine, r.r_x, first, gives), _supply(q_2.value, other, r.b_3, at, takes)
    sent, falls = one.q + two.q, one.falls + two.falls
    low, high = (old if sent >= old else x.low), (old if sent <= old else x.high)
    # what arrives is sent - falls (P - at) at the pressure P = fed.p_rest + fed.r arrives^2; no sum of like numbers
    known = sent + falls * rise
    new = 2.0 * known / (1.0 + sqrt(1.0 + 4.0 * falls * fed.r * known))
    flow = min(x.q_gives, x.q_takes)
    out = (new <= low or new >= high) and abs(new - old) > _CLOSE * flow
    new = old if still else (0.5 * (low + high) if out else new)
    crosses = min(max(one.q - one.falls * fed.r * (new - old) * (new + old), 0.0), min(q_1.value, new))
    crosses = x.crosses if still else crosses
    arrives_1 = q_1.value - crosses
    w = stepped(x.w, x.dw, passed_first(arrives_1, r.a_1, p.p_1, beyond, gives), arrives_1, still)
    moved = max(max(abs(w.change), abs(crosses - x.crosses)), abs(new - old))
    largest = max(max(abs(q_1.change) * q_1.value, abs(q_2.change) * q_2.value), moved)
    anew = out and high - low < _NARROW * flow
    return Joining(
        q_1.value,
        x.least_gives,
        q_1.change,
        q_2.value,
        x.least_takes,
        q_2.change,
        crosses,
        w.value,
        w.change,
        new,
        -gives.flow if anew else low,
        2.0 * (gives.flow + takes.flow) if anew else high,
        largest,
        settled(largest, x.largest, flow),
    )
