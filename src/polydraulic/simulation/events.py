"""Events of a run: valves that open, end stops that are met, relief valves that work, lines that run empty.

Each is a condition that begins or ends. The conditions at a recorded row are the bits of one whole number; where it changes from row
to row there is an event. Spool edges and contacts are placed between two rows by linear interpolation, all else at the
row that shows it first. A list holds `MAX_EVENTS` at most; what is beyond is counted.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.interface import Flows
from polydraulic.flow.record import PLACE, from_vector
from polydraulic.machine.hose import LineStep
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, State
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import CIRCUITS, LINKS, Machine, Stops

MAX_EVENTS = 10_000
N_CONDITION = 26
LINK_CONDITIONS = (
    ("valve opens", "valve closes"),
    ("bypass closes", "bypass opens"),
    ("low stop met", "low stop left"),
    ("high stop met", "high stop left"),
    ("line A relief opens", "line A relief closes"),
    ("line B relief opens", "line B relief closes"),
    ("line A runs empty", "line A fills"),
    ("line B runs empty", "line B fills"),
)
PUMP_CONDITION = ("pump relief opens", "pump relief closes")
CROSSOVER_CONDITION = ("crossover opens", "crossover closes")
# (link or circuit, what begins, what ends) of each bit
CONDITIONS = (
    *((link, *words) for words in LINK_CONDITIONS for link in LINKS),
    *((circuit, *PUMP_CONDITION) for circuit in CIRCUITS),
)
SPOOLS = (1 << 6) - 1  # all bits of the spools
PUMPS = 3 << 24
_RELIEF_BOOM, _RELIEF_SERIES = PLACE["boom.q_relief"], PLACE["series.q_relief"]


class Edges(NamedTuple):
    """Travel in m at which the valve opens, and at which its bypass is shut."""

    valve: float
    bypass: float


class EventLog(NamedTuple):
    """Events as they are found; arrays that the caller owns."""

    time: np.ndarray  # (MAX_EVENTS,) s
    code: np.ndarray  # (MAX_EVENTS,) bit + 1 where a condition begins, -(bit + 1) where it ends
    number: np.ndarray  # (1,), beyond MAX_EVENTS if there were more


def new_log() -> EventLog:
    """Return an empty log."""
    return EventLog(np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, dtype=np.int64), np.zeros(1, dtype=np.int64))


@kernel
def _link_bits(spool: float, angle: float, p_a: float, p_b: float, edges: Edges, stops: Stops, line: LineStep) -> int:
    travel = abs(spool)
    bits = 1 if travel > edges.valve else 0
    bits |= (1 << 3) if travel >= edges.bypass else 0
    bits |= (1 << 6) if angle <= stops.low else 0
    bits |= (1 << 9) if angle >= stops.high else 0
    bits |= (1 << 12) if p_a >= line.relief else 0
    bits |= (1 << 15) if p_b >= line.relief else 0
    bits |= (1 << 18) if p_a <= line.floor else 0
    bits |= (1 << 21) if p_b <= line.floor else 0
    return bits


@kernel
def conditions(x: State, relief_boom: float, relief_series: float, edges: Edges, plant: Plant) -> int:
    """Bits of the conditions that hold at a state, with the flows in m3/s over the pumps' relief valves."""
    swing = _link_bits(
        x.spool.swing, x.angle.swing, x.p_a.swing, x.p_b.swing, edges, plant.swing.stops, plant.swing.line
    )
    boom = _link_bits(x.spool.boom, x.angle.boom, x.p_a.boom, x.p_b.boom, edges, plant.boom.stops, plant.boom.line)
    stick = _link_bits(
        x.spool.stick, x.angle.stick, x.p_a.stick, x.p_b.stick, edges, plant.stick.stops, plant.stick.line
    )
    bits = swing | (boom << 1) | (stick << 2)
    bits |= (1 << 24) if relief_boom > 1e-12 else 0  # below is rounding
    bits |= (1 << 25) if relief_series > 1e-12 else 0
    return bits


@kernel
def _pick(v: Links, place: int) -> float:
    return v.swing if place == 0 else (v.boom if place == 1 else v.stick)


@kernel
def _share(bit: int, begins: bool, dt: float, before: State, after: State, edges: Edges, plant: Plant) -> float:
    """Part of the way from one row to the next at which a condition changes."""
    place = bit % 3
    if bit < 6:
        edge = edges.valve if bit < 3 else edges.bypass
        x0, x1 = abs(_pick(before.spool, place)), abs(_pick(after.spool, place))
        return min(max((edge - x0) / (x1 - x0), 0.0), 1.0) if x0 != x1 else 1.0
    if bit < 12:
        stops = plant.swing.stops if place == 0 else (plant.boom.stops if place == 1 else plant.stick.stops)
        gap = (stops.low if bit < 9 else stops.high) - _pick(before.angle, place)
        way = dt * _pick(before.rate, place)
        meets = min(max(gap / way, 0.0), 1.0) if way * gap > 0.0 else 1.0
        return meets if begins else 0.0
    return 1.0


@driver
def note(
    log: EventLog,
    changed: int,
    bits: int,
    t0: float,
    t1: float,
    before: State,
    after: State,
    edges: Edges,
    plant: Plant,
) -> None:
    """Write down every condition that changed between two states, at the times t0 and t1."""
    for bit in range(N_CONDITION):
        if (changed >> bit) & 1:
            begins = ((bits >> bit) & 1) == 1
            k = log.number[0]
            if k < MAX_EVENTS:
                log.time[k] = t0 + (t1 - t0) * _share(bit, begins, t1 - t0, before, after, edges, plant)
                log.code[k] = bit + 1 if begins else -(bit + 1)
            log.number[0] = k + 1


@driver
def observe(
    log: EventLog, had: int, t0: float, t1: float, before: State, after: State, flows: Flows, edges: Edges, plant: Plant
) -> int:
    """Events of a step of a solver that ends its steps at events; returns the conditions at its end, `had` are those before.

    Only spool edges may lie within a step: on either side of its ends, by rounding.
    """
    bits = conditions(after, flows.boom.q_relief, flows.series.q_relief, edges, plant)
    changed = bits ^ had
    if changed != 0:
        note(log, changed & SPOOLS, bits, t0, t1, before, after, edges, plant)
        left = changed & ~(SPOOLS | PUMPS | bits)  # bounds and stops: the step began as they were left
        note(log, left, bits, t0, t0, before, after, edges, plant)
        note(log, changed & ~(SPOOLS | left), bits, t1, t1, before, after, edges, plant)
    return bits


@driver
def scan(time: np.ndarray, rows: np.ndarray, edges: Edges, plant: Plant, log: EventLog) -> None:
    """Find the events in recorded rows."""
    x = from_vector(rows[0])
    bits = conditions(x, rows[0, _RELIEF_BOOM], rows[0, _RELIEF_SERIES], edges, plant)
    for k in range(1, rows.shape[0]):
        before, had = x, bits
        x = from_vector(rows[k])
        bits = conditions(x, rows[k, _RELIEF_BOOM], rows[k, _RELIEF_SERIES], edges, plant)
        if bits != had:
            note(log, bits ^ had, bits, time[k - 1], time[k], before, x, edges, plant)


def edges_of(machine: Machine) -> Edges:
    """Return the spool edges that count as events."""
    return Edges(machine.spool.deadband, machine.spool.bypass_closed)


def find_events(machine: Machine, scenario: Scenario, time: np.ndarray, rows: np.ndarray) -> dict[str, object]:
    """Events in recorded rows, as `listed` gives them; what begins and ends between two rows is not seen."""
    log = new_log()
    if len(rows) > 1:
        scan(time, rows, edges_of(machine), prepare(machine, 1.0, scenario.locked), log)
    return listed(log, scenario.locked)


def listed(log: EventLog, locked: tuple[str, ...]) -> dict[str, object]:
    """Entries for a trajectory's `info`: ``events``, rows of [time in s, link or circuit, what], and ``events_dropped``.

    Locked links have none.
    """
    n = int(log.number[0])
    kept = min(n, MAX_EVENTS)
    rows: list[list[Any]] = []
    for k in np.argsort(log.time[:kept], kind="stable"):
        code = int(log.code[k])
        link, begins, ends = CONDITIONS[abs(code) - 1]
        if not set(CIRCUITS.get(link, (link,))) <= set(locked):
            rows.append([float(log.time[k]), link, begins if code > 0 else ends])
    return {"events": rows, "events_dropped": n - kept}
