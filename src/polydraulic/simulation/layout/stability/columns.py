"""How far a run is from tipping, as columns, and what is said of it: least margins, when it tips, how early that could be foreseen."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from polydraulic.machine.stability.watched import BEHIND, SHOWN, n_watched, watch_all, watched_room
from polydraulic.machine.stability.whole_body import body_of
from polydraulic.parameters.layout.chassis import Chassis, edge_names
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import MAX_EVENTS
from polydraulic.simulation.layout.columns import AddedColumn, Columns

WARNED = 2.0  # s ahead of a foreseen tip, a warning begins
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
        with the least dynamic distance; ``stability.time_to_tip`` (s); ``stability.gravity_x``, ``_y`` (m), where the line of gravity
        through the common centre of gravity meets the ground.

    Raises
    ------
    InputError
        A machine without a chassis.
    """
    found = row_margins(machine, module, plant, rows, columns, forces)
    assert machine.chassis is not None
    for (name, unit), values in zip(margin_columns(machine.chassis), found.T, strict=True):
        yield AddedColumn(name, unit, values)


def row_margins(
    machine: LayoutMachine, module: Any, plant: Any, rows: np.ndarray, columns: Columns, forces: np.ndarray
) -> np.ndarray:
    """Margins at recorded rows, (n_row, n_watched), in the order of `machine.stability.watched`; arguments as of `stability_columns`.

    The blow of an end stop that is met lasts a step, and a machine does not tip in one: such a row has the margins of steady rates.
    """
    n, body = len(machine.names), body_of(machine)
    motions = np.empty((len(rows), 3 * n))
    for k, quantity in enumerate(("angle", "rate")):
        motions[:, k * n : (k + 1) * n] = rows[:, [columns.place[f"{f}.{quantity}"] for f in machine.names]]
    acted = np.empty((len(rows), 3 * n))
    module.torques(plant, np.ascontiguousarray(rows), forces, acted)
    motions[:, 2 * n :] = acted[:, 2::3]
    found = np.empty((len(rows), n_watched(body.n_edge)))
    watch_all(body, plant.dt, watched_room(machine), motions, np.ascontiguousarray(forces, dtype=float), found)
    return found


def margin_columns(chassis: Chassis) -> list[tuple[str, str]]:
    """Names and units of the numbers of a row of `row_margins`."""
    edges = [*(f".{name.replace(' ', '_')}" for name in edge_names(chassis)), ""]
    found = [(f"{_NAME}{edge}.{measure}", unit) for measure, unit in SHOWN for edge in edges]
    return [*found, *((f"{_NAME}.{name}", unit) for name, unit in BEHIND)]


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
