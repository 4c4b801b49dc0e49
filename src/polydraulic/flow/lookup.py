"""Flow maps: multilinear interpolation between flows that the exact model gives on grids.

The boom's input flow stands on a grid of spool travel and line pressure, those of swing and stick, which share a pump,
on one of both travels and both pressures; the outlets' conductances on the spool. Grid lines of travel meet the
spool's knots, at which the flow has kinks. Lines of pressure, and the interpolation between them, are even in
sqrt(P_r - P), since that root leads the flow of an open inlet to nothing at the relief pressure P_r. Kinks that move
with the pressures, where an inlet just opens or the relief valve does, are smeared over a cell: there the error falls
with the distance of the lines, elsewhere with its square.
"""

from math import sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import ExactFlow, exact_flow, exact_step
from polydraulic.flow.interface import OK, OUT_OF_DOMAIN, Flows
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import Machine

MOST_POINTS = 64  # 0.3 GB
_BOOM_POINTS = 4  # lines an axis of the boom's two, as a multiple of those of the others' four


class LookupFlow(NamedTuple):
    """Grid lines and flows; the last axis of a table holds its values at a point.

    The pump's flow is the last of them where a torque limit lowers it, and otherwise known.
    """

    boom_travel: np.ndarray  # (m,) m
    boom: np.ndarray  # (m, m, 1 or 2) m3/s of travel, p_in: q_in, the pump's flow
    travel: np.ndarray  # (n,) m
    series: np.ndarray  # (n, n, n, n, 2 or 3) m3/s of x_sw, x_st, p_sw, p_st: q_in of swing and stick, the pump's flow
    spool: np.ndarray  # (k,) m
    outlets: np.ndarray  # (k, 3) m3/s/Pa^0.5, links in the order of LINKS
    relief: float  # Pa; pressures reach from 0 to here
    boom_flow: float
    series_flow: float
    limited: bool


def lookup_flow(machine: Machine | str | Path, *, points: int = 24) -> LookupFlow:
    """Flow model that interpolates in tables of the exact flow.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
        A torque limit of its pumps is in the tables.
    points : int
        Grid lines on each axis of the table of swing and stick, which grows with their fourth power; the boom's has
        four times as many.

    Raises
    ------
    InputError
        If there are too few points for the spool's knots, or more than `MOST_POINTS`.
    """
    machine = as_excavator(machine)
    least = len(machine.spool.knots)
    if not isinstance(points, int) or not least <= points <= MOST_POINTS:
        raise InputError(
            f"points = {points!r}: must be a whole number from {least}, the spool's knots, to {MOST_POINTS}; "
            "the table of swing and stick holds points^4 values of each flow"
        )
    exact, relief, limited = exact_flow(machine), machine.pumps.relief, machine.pumps.torque_limit_enabled
    pressure, travel = pressure_lines(relief, points), travel_lines(machine, points)
    n = _BOOM_POINTS * points
    boom_pressure, boom_travel = pressure_lines(relief, n), travel_lines(machine, n)

    def sampled(*points: Any) -> np.ndarray:
        """Flows where spools and line pressures meet, arrays or floats in the order of `LINKS`; the last axis as `_exact_flows`."""
        columns = np.broadcast_arrays(*points)
        rows = np.stack([column.ravel() for column in columns], axis=1)
        found = np.empty((len(rows), 8))
        _exact_flows(exact, np.zeros(1), rows, found)
        return found.reshape(*columns[0].shape, 8)

    boom_flows, series_flows = ([1, 3], [0, 2, 4]) if limited else ([1], [0, 2])
    x, p = np.meshgrid(boom_travel, boom_pressure, indexing="ij")
    boom = sampled(0.0, x, 0.0, 0.0, p, 0.0)[..., boom_flows]
    x, p_sw, p_st = np.meshgrid(travel, pressure, pressure, indexing="ij")
    series = np.stack([sampled(x_sw, 0.0, x, p_sw, 0.0, p_st)[..., series_flows] for x_sw in travel])
    knots = np.array(machine.spool.knots)
    spool = np.concatenate([-knots[:0:-1], knots])
    outlets = sampled(spool, spool, spool, 0.0, 0.0, 0.0)[:, 5:]
    flows = machine.pumps.boom_flow, machine.pumps.series_flow
    return LookupFlow(boom_travel, boom, travel, series, spool, outlets, relief, *flows, limited)


def travel_lines(machine: Machine, n: int) -> np.ndarray:
    """Grid lines of spool travel in m, (n,): the knots, and the widest gaps between them cut into equal parts."""
    knots = np.array(machine.spool.knots)
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
    return sum(table_bytes(part) for part in model) if isinstance(model, tuple) else 0


@driver
def _exact_flows(exact: ExactFlow, memory: np.ndarray, points: np.ndarray, found: np.ndarray) -> None:
    """Of spools and line pressures `points` (n, 6): input flows, flows of boom and series pump, outlets' conductances (n, 8)."""
    for i in range(points.shape[0]):
        spool, p_in = points[i, :3], points[i, 3:]
        flows = exact_step(
            exact,
            memory,
            Links(spool[0], spool[1], spool[2]),
            Links(p_in[0], p_in[1], p_in[2]),
            Links(0.0, 0.0, 0.0),
            0.0,
        )
        q, k = flows.q_in, flows.k_out
        found[i, 0], found[i, 1], found[i, 2] = q.swing, q.boom, q.stick
        found[i, 3], found[i, 4] = flows.boom.q_pump, flows.series.q_pump
        found[i, 5], found[i, 6], found[i, 7] = k.swing, k.boom, k.stick


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
def _on_line(table: np.ndarray, value: int, a: _Place) -> float:
    return (1.0 - a.share) * table[a.line, value] + a.share * table[a.line + 1, value]


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
def lookup_step(model: LookupFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Interpolate; beyond the pressures of the tables those at their ends are given, and reported."""
    relief, m, n = model.relief, model.boom.shape[1], model.series.shape[2]
    x, p = _find(abs(spool.boom), model.boom_travel), _find_pressure(p_in.boom, relief, m)
    Q_boom = _on_plane(model.boom, 1, x, p) if model.limited else model.boom_flow
    q_boom = min(max(_on_plane(model.boom, 0, x, p), 0.0), Q_boom)

    x_swing, p_swing = _find(abs(spool.swing), model.travel), _find_pressure(p_in.swing, relief, n)
    x_stick, p_stick = _find(abs(spool.stick), model.travel), _find_pressure(p_in.stick, relief, n)
    Q = _in_four(model.series, 2, x_swing, x_stick, p_swing, p_stick) if model.limited else model.series_flow
    q_swing = min(max(_in_four(model.series, 0, x_swing, x_stick, p_swing, p_stick), 0.0), Q)
    q_stick = min(max(_in_four(model.series, 1, x_swing, x_stick, p_swing, p_stick), 0.0), Q - q_swing)

    outlets = Links(
        _on_line(model.outlets, 0, _find(spool.swing, model.spool)),
        _on_line(model.outlets, 1, _find(spool.boom, model.spool)),
        _on_line(model.outlets, 2, _find(spool.stick, model.spool)),
    )
    inside = _inside(p_in.swing, relief) and _inside(p_in.boom, relief) and _inside(p_in.stick, relief)
    return Flows(
        Links(q_swing, q_boom, q_stick),
        outlets,
        Circuit(Q_boom, Q_boom - q_boom, 0.0, 0.0, 0.0),
        Circuit(Q, Q - q_swing - q_stick, 0.0, 0.0, 0.0),
        0.0,
        OK if inside else OUT_OF_DOMAIN,
    )
