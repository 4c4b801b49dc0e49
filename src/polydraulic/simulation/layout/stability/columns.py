"""How far a run is from tipping, as columns, and what is said of it: least margins, when it tips, how early that could be foreseen."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from polydraulic.machine.stability.margins import MEASURES
from polydraulic.machine.stability.whole_body import standing_margins
from polydraulic.parameters.layout.chassis import Chassis, edge_names
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import AddedColumn, Columns

FORESEEN = 60.0  # s: no tip is foreseen further ahead
WARNED = 2.0  # s ahead of a foreseen tip, a warning begins
_UNITS = {"distance": "m", "dynamic_distance": "m", "force_angle": "N m", "energy": "J"}
_NAME = "stability"


def stability_columns(
    machine: LayoutMachine, module: Any, plant: Any, rows: np.ndarray, columns: Columns, forces: np.ndarray
) -> Iterator[AddedColumn]:
    """Columns of margins.

    Parameters
    ----------
    machine : LayoutMachine
        With its payload, and a chassis.
    module, plant
        As prepared for the run.
    rows : (n_row, n_column) array
        Recorded.
    columns : Columns
        What stands where in them.
    forces : (n_row, 3) array, N
        At the tip.

    Yields
    ------
    AddedColumn
        ``stability.EDGE.distance``, ``.dynamic_distance`` (m), ``.force_angle`` (N m) and ``.energy`` (J) of each edge, by the direction in which
        the machine tips over it (``forward_left``); the least of each as ``stability.distance`` and so on; ``stability.edge``, the number of the edge
        with the least dynamic distance; ``stability.time_to_tip`` (s), by `time_to_tip`.

    Raises
    ------
    InputError
        A machine without a chassis.
    """
    found = row_margins(machine, module, plant, rows, columns, forces)
    assert machine.chassis is not None
    names = [name.replace(" ", "_") for name in edge_names(machine.chassis)]
    for measure, unit in _UNITS.items():
        values = found[:, :, MEASURES.index(measure)]
        for k, name in enumerate(names):
            yield AddedColumn(f"{_NAME}.{name}.{measure}", unit, values[:, k])
        yield AddedColumn(f"{_NAME}.{measure}", unit, values.min(axis=1))
    yield AddedColumn(f"{_NAME}.edge", "1", critical_edges(found).astype(float))
    yield AddedColumn(f"{_NAME}.time_to_tip", "s", time_to_tip(found))


def row_margins(
    machine: LayoutMachine, module: Any, plant: Any, rows: np.ndarray, columns: Columns, forces: np.ndarray
) -> np.ndarray:
    """Margins at recorded rows, (n_row, n_edge, 5): the fields of `EdgeMargins`; arguments as of `stability_columns`.

    The blow of an end stop that is met lasts a step, and a machine does not tip in one: such a row has the margins of steady rates.
    """
    positions, rates = (rows[:, [columns.place[f"{f}.{q}"] for f in machine.names]] for q in ("angle", "rate"))
    acted = np.empty((len(rows), 3 * len(machine.names)))
    module.torques(plant, np.ascontiguousarray(rows), forces, acted)
    gained = acted[:, 2::3]
    low, high = (np.array([getattr(f.stops, end) for f in machine.functions]) for end in ("low", "high"))
    after = positions + plant.dt * rates
    stops = (np.abs(rates + plant.dt * gained) <= 1e-9 * np.abs(rates)) & (rates != 0.0)
    blow = (stops & ((after >= high) | (after <= low))).any(axis=1)
    return standing_margins(machine, positions, rates, np.where(blow[:, None], 0.0, gained), forces)


def critical_edges(margins: np.ndarray) -> np.ndarray:
    """Number of the edge with the least dynamic distance, of margins (..., n_edge, 5)."""
    return np.asarray(margins[..., MEASURES.index("dynamic_distance")].argmin(axis=-1))


def time_to_tip(margins: np.ndarray) -> np.ndarray:
    """How soon a machine tips if its centre of gravity goes on as it moves now, s, at most `FORESEEN`.

    Parameters
    ----------
    margins : (..., n_edge, 5) array
        Fields of `EdgeMargins`.

    Returns
    -------
    (...) array
        The lesser of static and dynamic distance over the speed at which the static one closes, least over the edges; 0 where it tips.
    """
    left = np.minimum(margins[..., MEASURES.index("distance")], margins[..., MEASURES.index("dynamic_distance")])
    closing = margins[..., MEASURES.index("closing")]
    soon = np.divide(left, closing, out=np.full_like(left, FORESEEN), where=closing > 1e-9)
    return np.asarray(np.clip(np.where(left <= 0.0, 0.0, soon), 0.0, FORESEEN).min(axis=-1))


def tips(chassis: Chassis, time: np.ndarray, added: list[AddedColumn], events: list[Any]) -> dict[str, object]:
    """Entries for a trajectory's `info`: names of edges, the least margin, and what is said of tipping, among the events too.

    Parameters
    ----------
    chassis : Chassis
    time : (n_row,) array, s
    added : list of AddedColumn
        Those of `stability_columns` among others.
    events : list
        Of the run.

    Returns
    -------
    dict
        ``stability_edges``; ``stability_least``: time in s, least dynamic distance in m, direction; ``tips``: of each tip its time in s, direction, and for how
        many s before it a tip had been foreseen within `WARNED` s; ``events`` with them.
    """
    names = edge_names(chassis)
    of = {column.name: column.values for column in added}
    edge = of[f"{_NAME}.edge"].astype(int)
    least, soon = of[f"{_NAME}.dynamic_distance"], of[f"{_NAME}.time_to_tip"]
    row = int(least.argmin())
    found: list[list[Any]] = []
    happened = []
    over = least <= 0.0
    for k in np.flatnonzero(over[1:] != over[:-1]) + 1:
        at, direction = float(time[k]), names[edge[k if over[k] else k - 1]]
        happened.append([at, "chassis", f"tips {direction}" if over[k] else "stands again"])
        if over[k]:
            found.append([at, direction, _warned(time[: k + 1], soon[: k + 1])])
    if over[0]:
        found.insert(0, [float(time[0]), names[edge[0]], 0.0])
    return {
        "stability_edges": list(names),
        "stability_least": [float(time[row]), float(least[row]), names[edge[row]]],
        "tips": found,
        "events": sorted([*events, *happened], key=lambda event: event[0])[:MAX_EVENTS],
    }


def _warned(time: np.ndarray, soon: np.ndarray) -> float:
    """For how long, up to the last row, a tip had been foreseen within `WARNED` s."""
    calm = np.flatnonzero(soon > WARNED)
    first = calm[-1] + 1 if len(calm) else 0
    return float(time[-1] - time[min(first, len(time) - 1)])
