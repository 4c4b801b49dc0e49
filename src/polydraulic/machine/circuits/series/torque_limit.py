"""One valve, or two in series, on a pump with torque limit: passes that move the pump's flow and what passes the first valve together.

Such a pass is that of circuits of three valves and more (`series.passes`): at a flow the circuit looks like one orifice of the same pressure
and slope, and one step of Newton leads towards the flow that the pump delivers at that pressure; so both settle at once, mostly in 1 to 6
passes, in 20 at worst of a million states where conductances over six decades meet. A circuit that has not settled in all `LIMIT_PASSES`, as a few do
whose second port is 1e-12 of the relief pressure below it, says so.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.series.passes import (
    AT_FIRST,
    Moved,
    Outlet,
    behind,
    driven_at_relief,
    least_flow,
    limited,
    limited_power,
    passed_on,
    resistance,
    settled,
    stepped,
    tangent,
)
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices

LIMIT_PASSES = 40


class Limited(NamedTuple):
    """Between two passes: the pump's flow, its least, what passes the first of two valves; resistances; last changes, the pump's as a share; whether all has settled."""

    q: float  # m3/s
    least: float  # m3/s
    dq: float
    w: float  # m3/s
    dw: float  # m3/s
    a_1: float  # Pa s2/m6, of inlets and bypasses
    b_1: float
    a_2: float
    b_2: float
    both: float  # m3/s, through both bypasses at relief if the second inlet passes nothing
    largest: float  # m3/s
    still: bool


@kernel
def limit_begin_1(k_1: Orifices, pump: Pump) -> Limited:
    """Where passes with one valve start: with the flow below the limit."""
    a_1, b_1 = resistance(k_1.inlet), resistance(k_1.bypass)
    return Limited(pump.flow, least_flow(pump), AT_FIRST, 0.0, 0.0, a_1, b_1, 0.0, 0.0, 0.0, AT_FIRST, False)


@kernel
def limit_begin_2(k_1: Orifices, k_2: Orifices, pump: Pump) -> Limited:
    """The same with two valves; most of the flow passes the first."""
    a_1, b_1, a_2, b_2 = resistance(k_1.inlet), resistance(k_1.bypass), resistance(k_2.inlet), resistance(k_2.bypass)
    # conductances, as a closed bypass takes nothing, though its resistance is finite
    b, c = k_1.bypass * k_1.bypass, k_2.bypass * k_2.bypass
    both = sqrt(b * c / (b + c + 1e-300) * max(pump.relief - pump.p_return, 0.0))
    return Limited(
        pump.flow, least_flow(pump), AT_FIRST, 0.9 * pump.flow, AT_FIRST, a_1, b_1, a_2, b_2, both, AT_FIRST, False
    )


@kernel
def _stepped_flow(x: Limited, whole: Outlet, pump: Pump, power: bool) -> Moved:
    """One step of the pump's flow where the circuit looks like `whole`; `power` if the pump has constant power."""
    if power:
        moved = limited_power(x.q, x.dq, x.least, whole, pump, x.still)
    else:
        moved = limited(x.q, x.dq, x.least, whole, pump, x.still)
    return moved


@kernel
def limit_pass_1(x: Limited, p_1: float, pump: Pump, power: bool) -> Limited:
    """One pass with one valve, whose flow is a closed form of the pump's."""
    q = _stepped_flow(x, tangent(x.q, x.a_1, p_1, Outlet(x.b_1, pump.p_return)), pump, power)
    largest = abs(q.change) * q.value
    still = settled(largest, x.largest, q.value)
    return Limited(q.value, x.least, q.change, 0.0, 0.0, x.a_1, x.b_1, x.a_2, x.b_2, x.both, largest, still)


@kernel
def limit_pass_2(x: Limited, p_1: float, p_2: float, pump: Pump, power: bool) -> Limited:
    """One pass with two valves, and a step of the pump's flow between its halves.

    At relief, the second inlet only adds to what both bypasses take: a bound that roundings of pressures do not reach.
    """
    beyond = behind(x.w, x.a_2, p_2, Outlet(x.b_2, pump.p_return), x.b_1)
    q = _stepped_flow(x, tangent(x.q, x.a_1, p_1, beyond), pump, power)
    passed = min(passed_on(q.value, x.a_1, p_1, beyond), max(driven_at_relief(beyond, pump), x.both))
    w = stepped(x.w, x.dw, passed, q.value, x.still)
    largest = max(abs(q.change) * q.value, abs(w.change))
    still = settled(largest, x.largest, q.value)
    return Limited(q.value, x.least, q.change, w.value, w.change, x.a_1, x.b_1, x.a_2, x.b_2, x.both, largest, still)


@kernel
def limited_1(k_1: Orifices, p_1: float, pump: Pump) -> Limited:
    """The pump's flow with one valve."""
    x, power = limit_begin_1(k_1, pump), pump.limit_exponent == 1.0
    for _ in range(LIMIT_PASSES):
        x = limit_pass_1(x, p_1, pump, power)
        if x.still:
            break
    return x


@kernel
def limited_2(k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Limited:
    """The pump's flow with two valves, and what passes the first."""
    x, power = limit_begin_2(k_1, k_2, pump), pump.limit_exponent == 1.0
    for _ in range(LIMIT_PASSES):
        x = limit_pass_2(x, p_1, p_2, pump, power)
        if x.still:
            break
    return x
