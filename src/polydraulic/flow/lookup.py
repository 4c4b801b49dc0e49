"""Flow maps: multilinear interpolation between flows that the exact model gives on grids.

The input flow of one valve on a pump stands on a grid of spool travel and line pressure, those of two in series on one of both travels and
both pressures. Grid lines of travel meet the spool's knots, at which the flow has kinks. Lines of pressure, and the interpolation between
them, are even in sqrt(P_r - P), since that root leads the flow of an open inlet to nothing at the relief pressure P_r. Kinks that move
with the pressures, where an inlet just opens or the relief valve does, are smeared over a cell: there the error falls
with the distance of the lines, elsewhere with its square.
"""

from collections.abc import Sequence
from math import sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.circuits.series.short import Series1, Series2
from polydraulic.machine.pump import Circuit, Pump, limited_pump
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

MOST_POINTS = 64  # 0.3 GB
_SINGLE_POINTS = 4  # lines an axis of the two of one valve, as a multiple of those of the four of two valves


class FlowTable1(NamedTuple):
    """Grid lines and flows of one valve on a pump; the last axis of a table holds its values at a point.

    The pump's flow is the last of them where a torque limit lowers it, and otherwise known. Pressures reach from 0 to relief.
    """

    travel: np.ndarray  # (m,) m
    flows: np.ndarray  # (m, m, 1 or 2) m3/s of travel, p_in: q_in, the pump's flow


class FlowTable2(NamedTuple):
    """The same of two valves in series."""

    first: np.ndarray  # (n,) m
    second: np.ndarray  # (n,) m
    flows: np.ndarray  # (n, n, n, n, 2 or 3) m3/s of both travels, both p_in: q_in of both, the pump's flow


def lookup_flow(machine: LayoutMachine | str | Path, *, points: int = 24) -> LayoutFlow:
    """Flow model that interpolates in tables of the exact flow, for circuits of one or two valves; outlets need no tables.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
        A torque limit of its pumps is in the tables.
    points : int
        Grid lines on each axis of the tables of two valves, which grow with their fourth power; those of one have four times as many.

    Raises
    ------
    InputError
        If there are too few points for a spool's knots, or more than `MOST_POINTS`; if a circuit has more valves, whose table would be too large.
    """
    machine = as_machine(machine)
    check_circuits(machine, "lookup")
    least = max(len(f.valve.knots) for f in machine.functions)
    if not isinstance(points, int) or not least <= points <= MOST_POINTS:
        raise InputError(
            f"points = {points!r}: must be a whole number from {least}, the most knots of a spool, to {MOST_POINTS}; "
            "the table of two valves holds points^4 values of each flow"
        )
    parts: dict[str, FlowTable1 | FlowTable2] = {}
    for c in machine.circuits:
        valves = [machine.function(f).valve for f in c.functions]
        pump = limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump)
        n = points if len(valves) == 2 else _SINGLE_POINTS * points
        lines = [travel_lines(valve.knots, n) for valve in valves]
        grid = np.meshgrid(*lines, *[pressure_lines(pump.relief, n)] * len(valves), indexing="ij")
        columns = np.stack([axis.ravel() for axis in grid], axis=1)
        sampled = sample_valves(valves, pump, columns[:, : len(valves)], columns[:, len(valves) :])
        values = [*sampled.q_in.T, *([sampled.q_pump] if pump.log_least < 0.0 else [])]
        flows = np.stack(values, axis=1).reshape(*grid[0].shape, len(values))
        parts[f"lookup_{c.name}"] = (
            FlowTable1(lines[0], flows) if len(valves) == 1 else FlowTable2(lines[0], lines[1], flows)
        )
    return LayoutFlow("lookup", "lookup", circuits_of(machine), machine.names, parts, 1, False)


def travel_lines(spool: Sequence[float], n: int) -> np.ndarray:
    """Grid lines of spool travel in m, (n,): the knots of a spool, and the widest gaps between them cut into equal parts."""
    knots = np.array(spool)
    parts = np.ones(len(knots) - 1, dtype=int)
    for _ in range(n - len(knots)):
        parts[np.argmax(np.diff(knots) / parts)] += 1
    cut = [np.linspace(knots[i], knots[i + 1], part, endpoint=False) for i, part in enumerate(parts)]
    return np.concatenate([*cut, knots[-1:]])


def pressure_lines(relief: float, n: int) -> np.ndarray:
    """Grid lines of pressure in Pa, (n,): from 0 to `relief`, even in the root of what is left to it."""
    return relief * (1.0 - np.linspace(1.0, 0.0, n) ** 2)


def table_bytes(model: object) -> int:
    """Bytes of all arrays in a flow model.

    Parameters
    ----------
    model : any of the models in `FLOW_KINDS`
    """
    if isinstance(model, np.ndarray):
        return model.nbytes
    if isinstance(model, dict):
        return table_bytes((*model.values(),))
    return sum(table_bytes(part) for part in model) if isinstance(model, tuple) else 0


class _Place(NamedTuple):
    """Where a value lies on an axis: the line below it, and its share of the way to the next."""

    line: int
    share: float


@kernel
def _find(x: float, lines: np.ndarray) -> _Place:
    low, high = 0, lines.shape[0] - 1
    x = min(max(x, lines[0]), lines[high])
    while high - low > 1:  # the gap halves
        middle = (low + high) // 2
        above = x >= lines[middle]
        low, high = middle if above else low, high if above else middle
    return _Place(low, (x - lines[low]) / (lines[high] - lines[low]))


@kernel
def _find_pressure(p: float, relief: float, n: int) -> _Place:
    p = p if p > 0.0 else 0.0
    u = (1.0 - sqrt(max(1.0 - p / relief, 0.0))) * (n - 1)
    line = min(int(u), n - 2)
    return _Place(line, u - line)


@kernel
def _inside(p: float, relief: float) -> bool:
    return p >= 0.0 and p <= relief


@kernel
def _on_plane(table: np.ndarray, value: int, a: _Place, b: _Place) -> float:
    total = 0.0
    for corner in range(4):
        i, j = corner >> 1, corner & 1
        weight = (a.share if i else 1.0 - a.share) * (b.share if j else 1.0 - b.share)
        total += weight * table[a.line + i, b.line + j, value]
    return total


@kernel
def _in_four(table: np.ndarray, value: int, a: _Place, b: _Place, c: _Place, d: _Place) -> float:
    total = 0.0
    for corner in range(16):
        i, j, k, m = corner >> 3, (corner >> 2) & 1, (corner >> 1) & 1, corner & 1
        first = (a.share if i else 1.0 - a.share) * (b.share if j else 1.0 - b.share)
        second = (c.share if k else 1.0 - c.share) * (d.share if m else 1.0 - d.share)
        total += first * second * table[a.line + i, b.line + j, c.line + k, d.line + m, value]
    return total


@kernel
def lookup_1(table: FlowTable1, travel: float, p_1: float, pump: Pump) -> Series1:
    """Flows of one valve; the status is 0 within the pressures of the table."""
    relief = pump.relief
    x, p = _find(travel, table.travel), _find_pressure(p_1, relief, table.flows.shape[1])
    Q = _on_plane(table.flows, 1, x, p) if pump.log_least < 0.0 else pump.flow
    q = min(max(_on_plane(table.flows, 0, x, p), 0.0), Q)
    return Series1(q, Circuit(Q, Q - q, 0.0, 0.0, 0.0), 0 if _inside(p_1, relief) else UNPROVED)


@kernel
def lookup_2(table: FlowTable2, travel_1: float, travel_2: float, p_1: float, p_2: float, pump: Pump) -> Series2:
    """Flows of two valves in series; the status is 0 within the pressures of the table."""
    relief, n = pump.relief, table.flows.shape[2]
    x_1, p_first = _find(travel_1, table.first), _find_pressure(p_1, relief, n)
    x_2, p_second = _find(travel_2, table.second), _find_pressure(p_2, relief, n)
    Q = _in_four(table.flows, 2, x_1, x_2, p_first, p_second) if pump.log_least < 0.0 else pump.flow
    q_1 = min(max(_in_four(table.flows, 0, x_1, x_2, p_first, p_second), 0.0), Q)
    q_2 = min(max(_in_four(table.flows, 1, x_1, x_2, p_first, p_second), 0.0), Q - q_1)
    inside = _inside(p_1, relief) and _inside(p_2, relief)
    return Series2(q_1, q_2, 0.0, Circuit(Q, Q - q_1 - q_2, 0.0, 0.0, 0.0), 0 if inside else UNPROVED)
