"""Events in the recorded rows of a machine of any layout: the same conditions as `simulation.events`, function by function."""

from collections.abc import Callable, Iterator, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import cross_name, fed_functions

Column = Callable[[str], np.ndarray]


def layout_events(
    machines: LayoutMachine | Sequence[tuple[LayoutMachine, slice]],
    locked: tuple[str, ...],
    time: np.ndarray,
    column: Column,
) -> dict[str, object]:
    """Entries for a trajectory's `info`: ``events`` and ``events_dropped``; what begins and ends between two rows is not seen.

    Parameters
    ----------
    machines : LayoutMachine, or sequence of (LayoutMachine, slice)
        With the rows in which it was what it was, the last row of each the first of the next.
    locked : tuple of str
        Functions that have no events.
    time : (n_time,) array, s
    column : function from a name in `columns.Columns.place` to (n_time,) array
    """
    parts = [(machines, slice(None))] if isinstance(machines, LayoutMachine) else machines
    found: list[list[Any]] = []
    for machine, rows in _alike(parts):

        def seen(name: str, rows: slice = rows) -> np.ndarray:
            return column(name)[rows]

        found += _found(machine, locked, time[rows], seen)
    found.sort(key=lambda event: event[0])
    return {"events": found[:MAX_EVENTS], "events_dropped": max(len(found) - MAX_EVENTS, 0)}


def _alike(parts: Sequence[tuple[LayoutMachine, slice]]) -> Iterator[tuple[LayoutMachine, slice]]:
    """Parts one after the other, those of an equal machine as one."""
    for machine, of in groupby(parts, key=lambda part: part[0]):
        rows = [rows for _, rows in of]
        yield machine, slice(rows[0].start, rows[-1].stop)


def _found(machine: LayoutMachine, locked: tuple[str, ...], time: np.ndarray, column: Column) -> list[list[Any]]:
    """Events in the rows of one machine."""
    found: list[list[Any]] = []
    moving = [f for f in machine.functions if f.name not in locked]
    for alike in zip(*(_conditions(f, machine, column) for f in moving), strict=True):  # ties stand in this order
        for f, ((begins, ends), holds, share) in zip(moving, alike, strict=True):
            found += _changes(f.name, begins, ends, holds, share, time)
    for c in machine.circuits:
        if not fed_functions(machine, c.name) <= set(locked):
            open_ = column(f"{c.name}.q_relief") > 1e-12  # below is rounding
            found += _changes(c.name, "pump relief opens", "pump relief closes", open_, None, time)
    for x in machine.crossovers:
        if not fed_functions(machine, x.giving) <= set(locked):
            open_ = column(cross_name(x.giving)) > 1e-12
            found += _changes(x.name, "crossover opens", "crossover closes", open_, None, time)
    return found


def _conditions(
    f: MachineFunction, machine: LayoutMachine, column: Column
) -> Iterator[tuple[tuple[str, str], np.ndarray, np.ndarray | None]]:
    """Words, where the condition holds, and the part of the way to the next row at which it changes."""
    travel, angle = np.abs(column(f"{f.name}.spool")), column(f"{f.name}.angle")
    valve, bypass = spool_edges(f.valve)
    yield ("valve opens", "valve closes"), travel > valve, _share(travel, valve)
    yield ("bypass closes", "bypass opens"), travel >= bypass, _share(travel, bypass)
    yield ("low stop met", "low stop left"), angle <= f.stops.low, None
    yield ("high stop met", "high stop left"), angle >= f.stops.high, None
    sides = [("A", column(f"{f.name}.p_a")), ("B", column(f"{f.name}.p_b"))]
    for side, p in sides:
        yield (f"line {side} relief opens", f"line {side} relief closes"), p >= f.line.relief, None
    for side, p in sides:
        yield (f"line {side} runs empty", f"line {side} fills"), p <= machine.tank.floor, None


def _share(travel: np.ndarray, edge: float) -> np.ndarray:
    step, edge = np.diff(travel), min(edge, 1e9)
    return np.clip(np.divide(edge - travel[:-1], step, out=np.ones_like(step), where=step != 0.0), 0.0, 1.0)


def _changes(
    where: str, begins: str, ends: str, holds: np.ndarray, share: np.ndarray | None, time: np.ndarray
) -> list[list[Any]]:
    rows = np.flatnonzero(holds[1:] != holds[:-1])
    parts = np.ones(len(rows)) if share is None else share[rows]
    at = time[rows] + (time[rows + 1] - time[rows]) * parts
    return [[float(t), where, begins if holds[k + 1] else ends] for t, k in zip(at, rows, strict=True)]
