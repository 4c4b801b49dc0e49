"""Events in the recorded rows of a machine of any layout: the same conditions as `simulation.events`, function by function."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import cross_name, fed_functions

Column = Callable[[str], np.ndarray]
Limit = float | np.ndarray
_Crossed = tuple[np.ndarray, Limit]  # travel, and the edge that it crosses


def layout_events(
    machines: LayoutMachine | Sequence[tuple[LayoutMachine, int]],
    locked: tuple[str, ...],
    time: np.ndarray,
    column: Column,
) -> dict[str, object]:
    """Entries for a trajectory's `info`: ``events`` and ``events_dropped``; what begins and ends between two rows is not seen.

    Parameters
    ----------
    machines : LayoutMachine, or sequence of (LayoutMachine, int)
        Or what it was, with the first row after each change of it; the first of these is 0.
    locked : tuple of str
        Functions that have no events.
    time : (n_time,) array, s
    column : function from a name in `columns.Columns.place` to (n_time,) array
    """
    parts = [(machines, 0)] if isinstance(machines, LayoutMachine) else machines
    machine = parts[0][0]
    found: list[list[Any]] = []
    moving = [place for place, f in enumerate(machine.functions) if f.name not in locked]
    limits = [_limits(place, parts, len(time)) for place in moving]
    names = [machine.names[place] for place in moving]
    conditions = [_conditions(name, limit, column) for name, limit in zip(names, limits, strict=True)]
    for alike in zip(*conditions, strict=True):  # ties stand in this order
        for name, ((begins, ends), holds, crossed) in zip(names, alike, strict=True):
            found += _changes(name, begins, ends, holds, crossed, time)
    for c in machine.circuits:
        if not fed_functions(machine, c.name) <= set(locked):
            open_ = column(f"{c.name}.q_relief") > 1e-12  # below is rounding
            found += _changes(c.name, "pump relief opens", "pump relief closes", open_, None, time)
    for x in machine.crossovers:
        if not fed_functions(machine, x.giving) <= set(locked):
            open_ = column(cross_name(x.giving)) > 1e-12
            found += _changes(x.name, "crossover opens", "crossover closes", open_, None, time)
    found.sort(key=lambda event: event[0])
    return {"events": found[:MAX_EVENTS], "events_dropped": max(len(found) - MAX_EVENTS, 0)}


class _Limits(NamedTuple):
    """What conditions compare a function's rows with: numbers, or where the machine changes (n_time,) arrays."""

    valve: Limit
    bypass: Limit
    low: Limit
    high: Limit
    relief: Limit
    floor: Limit


def _limits(place: int, parts: Sequence[tuple[LayoutMachine, int]], n_time: int) -> _Limits:
    """Limits of a function in all rows."""
    of = []
    for machine, _ in parts:
        f = machine.functions[place]
        of.append((*spool_edges(f.valve), f.stops.low, f.stops.high, f.line.relief, machine.tank.floor))
    if len(set(of)) == 1:
        return _Limits(*of[0])
    which = np.searchsorted([row for _, row in parts], np.arange(n_time), side="right") - 1
    return _Limits(*(np.array(each)[which] for each in zip(*of, strict=True)))


def _conditions(
    name: str, limit: _Limits, column: Column
) -> Iterator[tuple[tuple[str, str], np.ndarray, _Crossed | None]]:
    """Words, where the condition holds, and what is crossed on the way to the next row where the condition changes."""
    travel, angle = np.abs(column(f"{name}.spool")), column(f"{name}.angle")
    yield ("valve opens", "valve closes"), travel > limit.valve, (travel, limit.valve)
    yield ("bypass closes", "bypass opens"), travel >= limit.bypass, (travel, limit.bypass)
    yield ("low stop met", "low stop left"), angle <= limit.low, None
    yield ("high stop met", "high stop left"), angle >= limit.high, None
    sides = [("A", column(f"{name}.p_a")), ("B", column(f"{name}.p_b"))]
    for side, p in sides:
        yield (f"line {side} relief opens", f"line {side} relief closes"), p >= limit.relief, None
    for side, p in sides:
        yield (f"line {side} runs empty", f"line {side} fills"), p <= limit.floor, None


def _changes(
    where: str, begins: str, ends: str, holds: np.ndarray, crossed: _Crossed | None, time: np.ndarray
) -> list[list[Any]]:
    rows = np.flatnonzero(holds[1:] != holds[:-1])
    parts = np.ones(len(rows)) if crossed is None else _share(*crossed, rows)
    at = time[rows] + (time[rows + 1] - time[rows]) * parts
    return [[float(t), where, begins if holds[k + 1] else ends] for t, k in zip(at, rows, strict=True)]


def _share(travel: np.ndarray, edge: Limit, rows: np.ndarray) -> np.ndarray:
    """The part of the way from rows to the next ones at which travel is at an edge."""
    step = travel[rows + 1] - travel[rows]
    edges = np.broadcast_to(np.minimum(edge, 1e9), travel.shape)[rows + 1]
    return np.clip(np.divide(edges - travel[rows], step, out=np.ones_like(step), where=step != 0.0), 0.0, 1.0)
