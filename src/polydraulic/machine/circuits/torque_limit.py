"""One valve, or two in series, on a pump at its torque limit: passes that move the pump's flow and what passes the first valve together.

At a flow, the circuit looks like one orifice of the same pressure and slope, and one step of Newton leads towards the flow that the pump
delivers at that pressure. With two valves such a step stands between the halves of a pass, as in circuits of three and more
(`series_pass`), so that both settle at once: mostly in 2 to 6 passes, in 17 where conductances over six decades meet. A circuit that has
not settled in all `LIMIT_PASSES` says so.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.series_pass import (
    AT_FIRST,
    Moved,
    Outlet,
    least_flow,
    limited,
    limited_power,
    settled,
    stepped,
)
from polydraulic.machine.pump import Orifice, Pump, as_one, behind_first, inlet_share
from polydraulic.machine.valve import Orifices

LIMIT_PASSES = 40


class Limited(NamedTuple):
    """Between two passes: the pump's flow, its least, what passes the first of two valves; last changes, the pump's as a share; whether all has settled."""

    q: float  # m3/s
    least: float  # m3/s
    dq: float
    w: float  # m3/s
    dw: float  # m3/s
    largest: float  # m3/s
    still: bool


@kernel
def limit_begin(passed: float, pump: Pump) -> Limited:
    """Where passes start: with the flows that there would be without torque limit, of which `passed` passes the first valve."""
    return Limited(pump.flow, least_flow(pump), AT_FIRST, passed, AT_FIRST, AT_FIRST, False)


@kernel
def _stepped_flow(x: Limited, whole: Orifice, pump: Pump, power: bool) -> Moved:
    """One step of the pump's flow where the circuit looks like `whole`; `power` if the pump has constant power."""
    outlet = Outlet(1.0 / (whole.square + 1e-300), whole.p_rest)
    if power:
        moved = limited_power(x.q, x.dq, x.least, outlet, pump, x.still)
    else:
        moved = limited(x.q, x.dq, x.least, outlet, pump, x.still)
    return moved


@kernel
def limit_pass_1(x: Limited, k_1: Orifices, p_1: float, pump: Pump, power: bool) -> Limited:
    """One pass with one valve, whose flow is a closed form of the pump's."""
    b = k_1.bypass * k_1.bypass
    share = inlet_share(x.q, k_1.inlet, b, p_1 - pump.p_return)
    q = _stepped_flow(x, as_one(x.q, share, k_1.inlet, b, p_1, pump.p_return), pump, power)
    largest = abs(q.change) * q.value
    return Limited(q.value, x.least, q.change, 0.0, 0.0, largest, settled(largest, x.largest, q.value))


@kernel
def limit_pass_2(x: Limited, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump, power: bool) -> Limited:
    """One pass with two valves, and a step of the pump's flow between its halves."""
    behind = behind_first(x.w, k_1, k_2, p_2, pump)
    share = inlet_share(x.q, k_1.inlet, behind.square, p_1 - behind.p_rest)
    q = _stepped_flow(x, as_one(x.q, share, k_1.inlet, behind.square, p_1, behind.p_rest), pump, power)
    at_relief = sqrt(max(behind.square * (pump.relief - behind.p_rest), 0.0))
    passed = q.value - inlet_share(q.value, k_1.inlet, behind.square, p_1 - behind.p_rest)
    w = stepped(x.w, x.dw, min(passed, at_relief), q.value, x.still)
    largest = max(abs(q.change) * q.value, abs(w.change))
    return Limited(q.value, x.least, q.change, w.value, w.change, largest, settled(largest, x.largest, q.value))


@kernel
def limited_1(k_1: Orifices, p_1: float, pump: Pump) -> Limited:
    """The pump's flow with one valve."""
    x, power = limit_begin(0.0, pump), pump.limit_exponent == 1.0
    for _ in range(LIMIT_PASSES):
        x = limit_pass_1(x, k_1, p_1, pump, power)
        if x.still:
            break
    return x


@kernel
def limited_2(passed: float, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump) -> Limited:
    """The pump's flow with two valves, and what passes the first, which is `passed` without torque limit."""
    x, power = limit_begin(passed, pump), pump.limit_exponent == 1.0
    for _ in range(LIMIT_PASSES):
        x = limit_pass_2(x, k_1, k_2, p_1, p_2, pump, power)
        if x.still:
            break
    return x
