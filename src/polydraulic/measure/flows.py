"""Flows that nobody measured, from the motion of the actuator and the pressure in its line.

What flows into a line moves the actuator and compresses the oil: Q = A ds/dt + C dp/dt, with the area A (or the displacement, for an
angle) and the compliance C of line and chamber. Friction does not enter, since this is a balance of volumes and not of forces.
Leakage is left out, and so is C dp/dt where no compliance is given: then a flow is wrong by just that while the pressure changes.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from polydraulic.measure.columns_made import FlowChannel, RateChannel
from polydraulic.measure.smoothing import LEAST, assumption, differentiate, window_length
from polydraulic.tables import Table

Rows = tuple[np.ndarray, np.ndarray, list[np.ndarray]]  # time, segment, columns


def reconstruct_flow(
    position: np.ndarray,
    raster: float,
    area: float,
    *,
    pressure: np.ndarray | None = None,
    compliance: float = 0.0,
    window: float = 0.1,
) -> np.ndarray:
    """Flow into an actuator's line, in m3/s.

    Parameters
    ----------
    position : (n,) array, m or rad
        Stroke, or angle; evenly spaced, without a gap.
    raster : float, s
    area : float, m2 or m3/rad
        Positive where the flow moves the actuator towards larger positions.
    pressure : (n,) array, Pa, optional
        In the line.
    compliance : float, m3/Pa
        Of line and chamber; 0 leaves the term out.
    window : float, s
        Of the differentiation; see `differentiate`.
    """
    flow = area * differentiate(position, raster, window)
    if pressure is not None and compliance > 0.0:
        flow = flow + compliance * differentiate(pressure, raster, window)
    return flow


def flow_statement(flow: FlowChannel, raster: float) -> str:
    """In words how a flow was reconstructed and what that assumes."""
    motion = f"{flow.name} = {flow.area:.6g} d({flow.position})/dt"
    if flow.pressure is None:
        volume = "without compliance: wrong by C dp/dt while the pressure changes"
    else:
        motion += f" + {flow.compliance:.4g} d({flow.pressure})/dt"
        volume = "with the compliance of the line"
    return f"{motion}, SI; {volume}; friction does not enter; leakage is left out. Derivatives by {assumption(raster, flow.window)}"


def rate_statement(rate: RateChannel, unit: str, raster: float) -> str:
    """In words how a rate was made and what that assumes."""
    return f"{rate.name} = d({rate.of})/dt in {unit}, by {assumption(raster, rate.window)}"


def add_flows(table: Table, flows: Sequence[FlowChannel], raster: float) -> Table:
    """Return an imported table with flows reconstructed, segment by segment.

    Parameters
    ----------
    table : Table
        With the columns ``time`` and ``segment``.
    flows : sequence of FlowChannel
    raster : float, s

    Returns
    -------
    Table
        Without segments that are too short to be differentiated.
    """
    names = [name for name in table.names if name not in ("time", "segment")]
    stream = FlowStream(names, flows, raster)
    blocks = [*stream.add(table["time"], table["segment"], [table[name] for name in names]), *stream.end()]
    columns = ["time", "segment", *names, *(flow.name for flow in flows)]
    rows = [np.concatenate(parts) for parts in zip(*((t, s, *c) for t, s, c in blocks), strict=True)]
    units = {**table.units, **{flow.name: "m3/s" for flow in flows}}
    return Table(dict(zip(columns, rows or [np.zeros(0)] * len(columns), strict=True)), units, dict(table.info))


class FlowStream:
    """Adds flows and rates to rows that come block by block; a window of rows waits for those that follow.

    Parameters
    ----------
    names : sequence of str
        Of the columns that come in.
    flows : sequence of FlowChannel or RateChannel
        Columns to make, in this order.
    raster : float, s
    """

    def __init__(self, names: Sequence[str], flows: Sequence[FlowChannel | RateChannel], raster: float) -> None:
        self.places: Mapping[str, int] = {name: n for n, name in enumerate(names)}
        self.flows, self.raster = flows, raster
        self.half = max((window_length(raster, flow.window) // 2 for flow in flows), default=0)
        self.too_short = 0
        self._time: np.ndarray = np.zeros(0)
        self._columns: list[np.ndarray] = [np.zeros(0)] * len(names)
        self._segment = -1.0
        self._ready = 0  # rows that have been given already and are kept as neighbours

    def add(self, time: np.ndarray, segment: np.ndarray, columns: list[np.ndarray]) -> Iterator[Rows]:
        """Add rows; yields those whose neighbours are all there."""
        if not self.flows:
            yield time, segment, columns
            return
        cuts = np.flatnonzero(np.diff(segment)) + 1
        for part in np.split(np.arange(len(time)), cuts):
            if part.size and segment[part[0]] != self._segment:
                yield from self.end()
                self._segment = float(segment[part[0]])
            self._time = np.concatenate([self._time, time[part]])
            self._columns = [np.concatenate([a, b[part]]) for a, b in zip(self._columns, columns, strict=True)]
            yield from self._give(len(self._time) - self.half)

    def end(self) -> Iterator[Rows]:
        """Yield the rows that wait, with one-sided derivatives at the end."""
        if len(self._time) >= LEAST:
            yield from self._give(len(self._time))
        else:
            self.too_short += len(self._time)
        self._time, self._ready = np.zeros(0), 0
        self._columns = [np.zeros(0)] * len(self._columns)

    def _give(self, stop: int) -> Iterator[Rows]:
        if stop <= self._ready or (len(self._time) < 2 * self.half + 1 and stop < len(self._time)):
            return
        found = [*self._columns, *(self._flow(flow) for flow in self.flows)]
        part = slice(self._ready, stop)
        time = self._time[part]
        yield time, np.full(len(time), self._segment), [column[part] for column in found]
        begin = max(0, stop - self.half)
        self._time, self._ready = self._time[begin:], stop - begin
        self._columns = [column[begin:] for column in self._columns]

    def _flow(self, flow: FlowChannel | RateChannel) -> np.ndarray:
        if isinstance(flow, RateChannel):
            (values,), known = self._filled([flow.of], flow.window)
            return np.where(known, differentiate(values, self.raster, flow.window), np.nan)
        with_pressure = flow.pressure is not None and flow.compliance > 0.0
        read, known = self._filled([flow.position, *([flow.pressure] if with_pressure else [])], flow.window)  # type: ignore[list-item]
        made = reconstruct_flow(
            read[0],
            self.raster,
            flow.area,
            pressure=read[1] if with_pressure else None,
            compliance=flow.compliance,
            window=flow.window,
        )
        return np.where(known, made, np.nan)

    def _filled(self, names: Sequence[str], window: float) -> tuple[list[np.ndarray], np.ndarray]:
        """Columns with zeros where they have no value, and in which rows the window of a derivative lacks none of them."""
        columns = [self._columns[self.places[name]] for name in names]
        lacks = np.any([np.isnan(column) for column in columns], axis=0)
        if not lacks.any():
            return columns, ~lacks
        n = len(lacks)
        length = min(window_length(self.raster, window), n - 1 + n % 2)
        first = np.clip(np.arange(n) - length // 2, 0, n - length)
        lost = np.concatenate([[0], np.cumsum(lacks)])
        return [np.where(np.isnan(c), 0.0, c) for c in columns], lost[first + length] == lost[first]
