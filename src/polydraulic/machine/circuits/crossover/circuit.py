"""A crossover valve: a check valve and an orifice from one pump's node to the node before the second valve of another pump's two.

At a pressure between both valves of the taking circuit everything follows: the giving pump's pressure, at which its flow is what its circuit and the
crossover take, and the flow of the taking pump's first valve. The higher this pressure, the less arrives and the more the second valve takes, so that the
surplus has one root. Where it lies above what the giving pump can push against, the check valve is shut.

Passes find it first (`passes`). What their certificate refuses is bracketed, in twice the machine's precision. What surplus is left is a source at a node: no flow is further
off than that.
"""

from math import sqrt
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.machine.circuits.crossover.check import joined_deliver, joined_end
from polydraulic.machine.circuits.crossover.nodes import (
    Behind,
    CrossoverOrifice,
    FinePressure,
    Giving,
    JoinedFlows,
    JoinedPorts,
    JoinedPumps,
    drop,
    first_valve,
    giving_at,
    orifice_passes,
    raised,
)
from polydraulic.machine.circuits.crossover.passes import (
    JOINED_PASSES,
    JoinedPath,
    Joining,
    joined_begin,
    joined_pass,
    joined_path,
)
from polydraulic.machine.circuits.series.check import CERTAIN, FAR, PROVED, REPAIRED, UNPROVED, delivers
from polydraulic.machine.circuits.series.short import Series1, Series2
from polydraulic.machine.pump import Circuit, Pump, Single
from polydraulic.machine.valve import Orifices

_STEPS = 180  # the first ones along chords, every eighth halves; from `_HALVE` on all do, down to twice the machine's precision
_HALVE = 48
_REST = 4e-15  # share of both pumps' flows; a smaller surplus is rounding
TO_TANK = 1e3  # m3/s/Pa^0.5; instead of a valve that is not there


class Crossed3(NamedTuple):
    """Flows of one actuator on the giving pump and two on the taking one."""

    giving: Series1
    taking: Series2
    q_cross: float


class Crossed4(NamedTuple):
    """Flows of two actuators on each pump."""

    giving: Series2
    taking: Series2
    q_cross: float


class Pushed(NamedTuple):
    """The giving pump's pressure, what flows there, and what passes the crossover."""

    p: FinePressure
    found: Giving
    q_cross: float


class PressureBracket(NamedTuple):
    """A bracket: what is left over at its lower end is not negative, at the upper one not positive; which end moved last, -1 or 1."""

    low: FinePressure
    high: FinePressure
    off_low: float
    off_high: float
    last: int


class Tried(NamedTuple):
    """Both circuits at a pressure before the second valve, and what is left over there."""

    giving: Pushed
    first: Single
    q_second: float
    q_tank: float
    p: FinePressure
    surplus: float


@kernel
def _next(x: PressureBracket, step: int) -> FinePressure:
    """A place between the ends: where the chord vanishes, or half way."""
    width = (x.high.coarse - x.low.coarse) + (x.high.fine - x.low.fine)
    share = x.off_low / (x.off_low - x.off_high + 1e-300)
    halves = (step & 7) == 7 or step >= _HALVE or share <= 0.0 or share >= 1.0
    return raised(x.low, width * (0.5 if halves else share))


@kernel
def _at_end(p: FinePressure, x: PressureBracket) -> bool:
    """Whether there is no number between both ends any more."""
    return (p.coarse == x.low.coarse and p.fine == x.low.fine) or (p.coarse == x.high.coarse and p.fine == x.high.fine)


@kernel
def _narrowed(x: PressureBracket, p: FinePressure, off: float) -> PressureBracket:
    """The bracket with a new end; an end that stays twice counts half, so that the chord does not get stuck."""
    below = off >= 0.0
    last = -1 if below else 1
    stays = 0.5 if last == x.last else 1.0
    off_low, off_high = (off if below else stays * x.off_low), (stays * x.off_high if below else off)
    return PressureBracket(p if below else x.low, x.high if below else p, off_low, off_high, last)


@kernel
def _pushed(shuts: FinePressure, lowest: FinePressure, highest: FinePressure, v: JoinedPumps) -> Pushed:
    """The giving circuit, whose pump's pressure is between two others, if the check valve shuts at a third one."""
    p, x = highest, PressureBracket(lowest, highest, v.gives.flow, -v.gives.flow, 0)
    found = Giving(0.0, 0.0, Behind(0.0, 0.0, 0.0, 0.0), 0.0)
    q_cross = 0.0
    for step in range(_STEPS):
        found = giving_at(p, v.k_1, v.k_2, v.ports.p_1, v.ports.p_2, v.gives)
        over = (p.coarse - shuts.coarse) + (p.fine - shuts.fine)
        q_cross = v.cross.conductance * sqrt(max(over, 0.0))
        rest = found.rest - q_cross
        if (step == 0 and rest >= 0.0) or abs(rest) <= _REST * v.gives.flow:
            break
        x = _narrowed(x, p, rest) if step > 0 else PressureBracket(x.low, highest, x.off_low, rest, 0)
        p = _next(x, step)
        if _at_end(p, x):
            break
    return Pushed(p, found, q_cross)


@kernel
def _tried(p: FinePressure, alone: Pushed, v: JoinedPumps) -> Tried:
    """Both circuits at a pressure before the second valve."""
    shuts = raised(p, v.cross.opening_pressure)
    opens = v.cross.conductance > 0.0 and drop(shuts, alone.p.coarse) < alone.p.fine
    giving = _pushed(shuts, shuts, alone.p, v) if opens else alone
    first = first_valve(v.k_3, v.ports.p_3, p, v.takes)
    q_second, q_tank = orifice_passes(v.k_4.inlet, p, v.ports.p_4), orifice_passes(v.k_4.bypass, p, v.takes.p_return)
    surplus = giving.q_cross + first.circuit.q_bypass - q_second - q_tank
    return Tried(giving, first, q_second, q_tank, p, surplus)


@kernel
def _between(a: float, b: float, share: float) -> float:
    return a + share * (b - a)


@kernel
def _bent(a: float, b: float) -> float:
    """By how much an orifice's flow between two places can differ from the one shared out between its flows there."""
    return (b - a) * (b - a) / (4.0 * max(a, b) + 1e-300)


@kernel
def _shared(a: Tried, b: Tried, v: JoinedPumps) -> JoinedFlows:
    """Flows between those at two neighbouring places, so that nothing is left over."""
    share = min(max(a.surplus / (a.surplus - b.surplus + 1e-300), 0.0), 1.0) if a.surplus > b.surplus else 0.0
    x, y, f, g = a.giving.found, b.giving.found, a.first, b.first
    bent = _bent(x.q_in, y.q_in) + _bent(x.behind.q_in, y.behind.q_in) + _bent(x.behind.q_tank, y.behind.q_tank)
    bent = bent + _bent(x.behind.passed, y.behind.passed) + _bent(a.giving.q_cross, b.giving.q_cross)
    bent = bent + _bent(f.q_in, g.q_in) + _bent(f.circuit.q_bypass, g.circuit.q_bypass)
    bent = bent + _bent(a.q_second, b.q_second) + _bent(a.q_tank, b.q_tank)
    left = 0.0 if a.surplus >= 0.0 and b.surplus <= 0.0 else min(abs(a.surplus), abs(b.surplus))
    at_relief = a.giving.p.coarse >= v.gives.relief
    relief_a, relief_b = max(x.rest - a.giving.q_cross, 0.0), max(y.rest - b.giving.q_cross, 0.0)
    giving = Circuit(
        _between(x.q_pump, y.q_pump, share),
        _between(x.behind.q_tank, y.behind.q_tank, share),
        _between(relief_a, relief_b, share) if at_relief else 0.0,
        _between(a.giving.p.coarse, b.giving.p.coarse, share),
        0.0,
    )
    taking = Circuit(
        _between(f.circuit.q_pump, g.circuit.q_pump, share),
        _between(a.q_tank, b.q_tank, share),
        _between(f.circuit.q_relief, g.circuit.q_relief, share),
        _between(f.circuit.p_pump, g.circuit.p_pump, share),
        0.0,
    )
    q_1, q_2 = _between(x.q_in, y.q_in, share), _between(x.behind.q_in, y.behind.q_in, share)
    q_cross = _between(a.giving.q_cross, b.giving.q_cross, share)
    lost = abs(giving.q_pump - q_1 - q_2 - giving.q_bypass - giving.q_relief - q_cross)
    known = abs(v.ports.p_1) + abs(v.ports.p_2) + abs(v.ports.p_3) + abs(v.ports.p_4) < FAR
    certain = known and left + bent + lost <= CERTAIN * min(v.gives.flow, v.takes.flow)
    return JoinedFlows(
        q_1,
        q_2,
        _between(f.q_in, g.q_in, share),
        _between(a.q_second, b.q_second, share),
        q_cross,
        _between(x.behind.p, y.behind.p, share),
        _between(a.p.coarse, b.p.coarse, share),
        giving,
        taking,
        REPAIRED if certain and delivers(giving, v.gives) and delivers(taking, v.takes) else UNPROVED,
    )


@kernel
def joined_bracketed(v: JoinedPumps) -> JoinedFlows:
    """Flows at the pressure before the second valve at which nothing is left over."""
    flow = min(v.gives.flow, v.takes.flow)
    top, far = FinePressure(v.gives.relief, 0.0), FinePressure(FAR, 0.0)
    none = FinePressure(min(min(v.ports.p_1, v.ports.p_2), min(v.gives.p_return, v.gives.relief)), 0.0)
    alone = _pushed(far, none, top, v)
    lowest = min(v.ports.p_4 if v.k_4.inlet > 0.0 else FAR, v.takes.p_return if v.k_4.bypass > 0.0 else FAR)
    # first where the check valve shuts: the root is below, or above
    p = raised(alone.p, -v.cross.opening_pressure)
    a = _tried(p, alone, v)
    b, above = a, a.surplus >= 0.0
    highest = FinePressure(max(v.takes.relief, alone.p.coarse), 0.0)
    bottom = FinePressure(min(min(lowest, v.takes.relief), p.coarse), 0.0)
    low, high = (p if above else bottom), (highest if above else p)
    x = PressureBracket(low, high, a.surplus if above else flow, -flow if above else a.surplus, 0)
    for step in range(_STEPS):
        if abs(a.surplus) <= _REST * flow or abs(b.surplus) <= _REST * flow:
            break
        p = _next(x, step)
        if _at_end(p, x):
            break
        m = _tried(p, alone, v)
        x = _narrowed(x, p, m.surplus)
        a = m if m.surplus >= 0.0 or a.surplus < 0.0 else a
        b = m if m.surplus < 0.0 or b.surplus >= 0.0 else b
    b = a if abs(a.surplus) <= _REST * flow else b
    a = b if abs(b.surplus) <= _REST * flow else a
    return _shared(a, b, v)


@kernel
def joined_on(x: Joining, r: JoinedPath, v: JoinedPumps, made: int) -> Joining:
    """All passes after the first ones that were made, until all has settled."""
    limit = v.gives.log_least < 0.0 or v.takes.log_least < 0.0
    for _ in range(made, JOINED_PASSES):
        if x.still:
            break
        x = joined_pass(x, r, v.ports, v.gives, v.takes, limit, False)
    return x


@kernel
def joined_solved(v: JoinedPumps) -> JoinedFlows:
    """Flows of both circuits: passes, their certificate, brackets for what that refuses."""
    r, start = joined_path(v), joined_begin(v.gives, v.takes)
    x = joined_on(start, r, v, 0)
    found = joined_end(x, r, v)
    proved = found.status == PROVED and joined_deliver(found.giving, found.taking, v.gives, v.takes)
    return found if proved else joined_bracketed(v)


@kernel
def joined_ports_4(p_1: float, p_2: float, p_3: float, p_4: float, gives: Pump) -> JoinedPorts:
    """Port pressures of four valves."""
    return JoinedPorts(p_1, p_2, p_3, p_4)


@kernel
def joined_ports_3(p_1: float, p_2: float, p_3: float, gives: Pump) -> JoinedPorts:
    """Port pressures of three; instead of the second of four there is the tank."""
    return JoinedPorts(p_1, gives.p_return, p_2, p_3)


@kernel
def joined_4(
    cross: CrossoverOrifice,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    k_4: Orifices,
    p_1: float,
    p_2: float,
    p_3: float,
    p_4: float,
    gives: Pump,
    takes: Pump,
) -> JoinedPumps:
    """Four valves on two pumps."""
    return JoinedPumps(cross, k_1, k_2, k_3, k_4, joined_ports_4(p_1, p_2, p_3, p_4, gives), gives, takes)


@kernel
def joined_3(
    cross: CrossoverOrifice,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    p_1: float,
    p_2: float,
    p_3: float,
    gives: Pump,
    takes: Pump,
) -> JoinedPumps:
    """Three valves on two pumps."""
    tank = Orifices(0.0, TO_TANK, 0.0)
    return JoinedPumps(cross, k_1, tank, k_2, k_3, joined_ports_3(p_1, p_2, p_3, gives), gives, takes)


@kernel
def crossed_4(s: JoinedFlows) -> Crossed4:
    """Flows of four valves, by pump."""
    giving = Series2(s.q_1, s.q_2, s.p_giving, s.giving, s.status)
    return Crossed4(giving, Series2(s.q_3, s.q_4, s.p_taking, s.taking, s.status), s.q_cross)


@kernel
def crossed_3(s: JoinedFlows) -> Crossed3:
    """Flows of three valves, by pump."""
    giving = Series1(s.q_1, s.giving, s.status)
    return Crossed3(giving, Series2(s.q_3, s.q_4, s.p_taking, s.taking, s.status), s.q_cross)


@kernel
def crossover_4(
    cross: CrossoverOrifice,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    k_4: Orifices,
    p_1: float,
    p_2: float,
    p_3: float,
    p_4: float,
    gives: Pump,
    takes: Pump,
) -> Crossed4:
    """Two actuators on each of two pumps; the first pump also feeds the second actuator of the other one.

    Parameters
    ----------
    cross : CrossoverOrifice
        Its check valve lets nothing back.
    k_1, k_2, k_3, k_4 : Orifices, m3/s/Pa^0.5
        Of the giving circuit's valves and of the taking circuit's.
    p_1, p_2, p_3, p_4 : float, Pa
        At their pressurised ports.
    gives, takes : Pump
    """
    v = joined_4(cross, k_1, k_2, k_3, k_4, p_1, p_2, p_3, p_4, gives, takes)
    found = joined_solved(v)
    return crossed_4(found)


@kernel
def crossover_3(
    cross: CrossoverOrifice,
    k_1: Orifices,
    k_2: Orifices,
    k_3: Orifices,
    p_1: float,
    p_2: float,
    p_3: float,
    gives: Pump,
    takes: Pump,
) -> Crossed3:
    """One actuator on a pump that also feeds the second of two on another pump; see `crossover_4`."""
    v = joined_3(cross, k_1, k_2, k_3, p_1, p_2, p_3, gives, takes)
    found = joined_solved(v)
    return crossed_3(found)
