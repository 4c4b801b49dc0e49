"""The repair of a circuit in series: a march from the deepest outlet that flow reaches, in steps that bracket.

The tank behind the last bypass and the inlets of the valves are outlets along a path. What the deepest one takes fixes the
pressure before it, hence the next bypass' drop, the next inlet's flow, and so on up to the pump, whose flow and relief valve then say
whether that is too much. Halving ends at two neighbouring numbers, one too little, one too much. Where bypasses are narrow their answers
may still be far apart upstream; then the next outlet is halved between these, with the flow behind it fixed. So each flow is known
to its last digits, whatever the conductances.

Pressures are differences to the port of the outlet that opened last, sums of squares, and compared with other ports without loss.
What is left is a relative rounding of conductances, which moves no flow by more than that share of the pump's.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.series.check import CERTAIN, FAR, LEAST, REPAIRED, UNPROVED
from polydraulic.machine.pump import Pump, delivered
from polydraulic.machine.valve import Orifices

HALVINGS = 90  # from the relief pressure's root down to flows that no sum of the machine notices
_ROUNDINGS = 1e-15  # share by which a sum of squares may be off


class Climb(NamedTuple):
    """A node on the way up: its pressure over a base, and the flow that leaves it."""

    y: float
    flow: float


class March(NamedTuple):
    """A node, whether flow reaches it, and between which pressures over a base it is, with which flows from it on."""

    reached: bool
    base: float  # Pa, port of the outlet that opened last
    low: float  # Pa
    high: float  # Pa
    flow_low: float  # m3/s
    flow_high: float  # m3/s


@kernel
def over(y: float, base: float, p: float) -> float:
    """Difference y + base - p, rounded once."""
    d = base - p
    t = d - base
    lost = (base - (d - t)) - (p + t)
    s = d + y
    t = s - d
    return s + (lost + ((d - (s - t)) + (y - t)))


@kernel
def root_over(y: float, base: float, p: float) -> float:
    """Root of the pressure difference at an outlet, 0 where its check valve holds."""
    return sqrt(max(over(y, base, p), 0.0))


@kernel
def joined(x: Climb, inlet: float, p: float, base: float) -> Climb:
    """A node with its inlet."""
    return Climb(x.y, x.flow + inlet * root_over(x.y, base, p))


@kernel
def _lifted(y: float, flow: float, bypass: float) -> float:
    """Pressure before a bypass; a shut one passes nothing at any pressure."""
    root = flow / max(bypass, LEAST)
    return min(y + root * root, FAR) if bypass > 0.0 else FAR


@kernel
def climbed(x: Climb, k: Orifices, p: float, base: float) -> Climb:
    """The node before a valve, from that behind its bypass."""
    return joined(Climb(_lifted(x.y, x.flow, k.bypass), x.flow), k.inlet, p, base)


@kernel
def asks_too_much(x: Climb, base: float, pump: Pump) -> bool:
    """Whether more leaves the pump's node than the pump delivers, or that at more than the relief pressure."""
    return over(x.y, base, pump.relief) > 0.0 or x.flow > delivered(base + x.y, pump)


@kernel
def unreached() -> March:
    """Before the march."""
    return March(False, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def reached_at(p: float, pump: Pump) -> March:
    """At the deepest port that flow reaches; beyond the relief pressure it is too much for sure."""
    return March(True, p, 0.0, max(2.0 * (pump.relief - p), 1.0), 0.0, 0.0)


@kernel
def before_outlet(m: March, p: float, low: float, high: float, k: float) -> March:
    """The same node with one outlet more, whose root is between `low` and `high`.

    One that opens is the new base; the port of one that stays shut bounds the pressure.
    """
    shut_high = max(min(m.high, p - m.base), m.low) if k > 0.0 else m.high
    shut = March(True, m.base, m.low, shut_high, m.flow_low, m.flow_high)
    opened = March(True, p, low * low, high * high, m.flow_low + k * low, m.flow_high + k * high)
    return opened if k > 0.0 and high > 0.0 else shut


@kernel
def before_bypass(m: March, bypass: float) -> March:
    """The node before a bypass; its pressure is known to some roundings."""
    low, high = _lifted(m.low, m.flow_low, bypass), _lifted(m.high, m.flow_high, bypass)
    return March(m.reached, m.base, low, high, m.flow_low, m.flow_high)


@kernel
def lowest_root(m: March, p: float) -> float:
    """Lower end of the bracket at an outlet; pressures are known to some roundings."""
    return root_over(m.low * (1.0 - _ROUNDINGS), m.base, p)


@kernel
def highest_root(m: March, p: float) -> float:
    """Upper end of the bracket at an outlet."""
    return root_over(m.high * (1.0 + _ROUNDINGS), m.base, p)


@kernel
def delivers_at(m: March, pump: Pump) -> float:
    """Flow of the pump at the end of the march."""
    return delivered(min(m.base + m.low, pump.relief) if m.reached else pump.relief, pump)


@kernel
def march_status(m: March, q_pump: float, pump: Pump) -> int:
    """`REPAIRED` if the bracket has closed, and the pump's flow is taken or its relief valve open."""
    closed = m.flow_high - m.flow_low <= CERTAIN * pump.flow
    taken = q_pump - m.flow_low <= CERTAIN * pump.flow or not m.reached
    at_relief = over(m.high, m.base, pump.relief) >= -1e-9 * pump.relief
    return REPAIRED if closed and (taken or at_relief) else UNPROVED
