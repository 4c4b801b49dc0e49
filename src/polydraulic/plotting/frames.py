"""Runs on the raster of an animation: what both the GIF and the page show."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.plotting.run_figure import circuit_of, joint_column, moving_links
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table, shown_column

MAX_FRAMES = 20_000


class PlottedChannel(NamedTuple):
    """A quantity to show: of a function, of the pumps or of the end-effector; one (n_frame,) array per run, as it is shown."""

    group: str
    title: str
    unit: str
    values: list[np.ndarray]


class Frames(NamedTuple):
    """Everything an animation shows, frame by frame."""

    title: str
    names: list[str]  # of the runs
    rate: float  # frames a second
    time: np.ndarray  # (n_frame,) s
    positions: list[np.ndarray]  # a run: (n_frame, n_function) rad or m, of all joints
    effector: list[np.ndarray]  # a run: (n_frame, 3) m
    channels: list[PlottedChannel]


def frames_of(runs: Mapping[str, Table], names: Sequence[str], rate: float, units: str = DEFAULT) -> Frames:
    """Put runs on one raster, linear between their rows, from their start to the end of the shortest.

    Parameters
    ----------
    runs : mapping from label to trajectory
    names : sequence of str
        Functions of the machine that made them.
    rate : float, 1/s
        Frames per second of the run.
    units : str
        Of the channels.

    Raises
    ------
    InputError
        No run, a table that is not a trajectory of this machine, a rate that is not positive or gives too many frames.
    """
    moving = moving_links(runs)
    joints = [[joint_column(table, name, label) for name in names] for label, table in runs.items()]
    tables = list(runs.values())
    last = min(float(table["time"][-1]) for table in tables)
    if not (isfinite(rate) and 0.0 < rate * last <= MAX_FRAMES - 1):
        raise InputError(
            f"{rate} frames/s over {last:g} s: must give 1 to {MAX_FRAMES} frames; 10 to 25 frames/s look smooth"
        )
    time = np.arange(int(last * rate + 1e-9) + 1) / rate
    thin = [_thinned(table, time) for table in tables]
    return Frames(
        title=str(tables[0].info.get("scenario", "")),
        names=list(runs),
        rate=rate,
        time=time,
        positions=[table.matrix(columns) for table, columns in zip(thin, joints, strict=True)],
        effector=[table.matrix(EFFECTOR) for table in thin],
        channels=_channels(thin, moving, units),
    )


def _thinned(table: Table, time: np.ndarray) -> Table:
    columns = {name: np.interp(time, table["time"], values) for name, values in table.columns.items()}
    return Table({**columns, "time": time}, table.units, table.info)


def _channels(tables: list[Table], moving: list[str], units: str) -> list[PlottedChannel]:
    found = []

    def add(group: str, title: str, column: str) -> None:
        if all(column in table.names for table in tables):
            read = [shown_column(table, column, units) for table in tables]
            found.append(PlottedChannel(group, title, read[0][1], [values for values, _ in read]))

    for name in moving:
        for title, quantity in (
            ("angle", "angle"),
            ("position", "position"),
            ("flow in", "q_in"),
            ("inlet pressure", "p_in"),
            ("joystick", "voltage"),
        ):
            add(name, title, f"{name}.{quantity}")
    circuits = sorted({circuit_of(tables[0], name) for name in moving})
    told = [name for name in circuits if all(f"{name}.p_pump" in table.names for table in tables)]
    group = "pumps and tip" if told else "tip"
    for circuit in told:
        add(group, f"{circuit} pump pressure", f"{circuit}.p_pump")
    add(group, "tip height", "effector.z")
    if len(tables) > 1:
        apart = [as_shown(effector_distance(tables[0], table), "m", units) for table in tables]
        found.append(PlottedChannel(group, "tip from first", shown_unit("m", units), apart))
    return found
