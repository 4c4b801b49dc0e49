"""Trajectories side by side: errors by column, and the standard plot of a run."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# What the field reads these columns in.
FIELD_UNITS = {
    "m": "in",
    "Pa": "psi",
    "m3/s": "in3/s",
    "rad": "deg",
    "rad/s": "deg/s",
    "V": "V",
    "s": "s",
}


class Difference(NamedTuple):
    """How far one column of a run is from the reference, in the column's unit."""

    unit: str
    largest: float  # with its sign
    time: float  # s, when it was largest
    rms: float
    final: float


def compare(reference: Table, model: Table) -> dict[str, Difference]:
    """Differences model - reference, for every column that both have.

    Raises
    ------
    InputError
        If the two do not have the same times.
    """
    t = reference["time"]
    if len(t) != len(model) or not np.allclose(t, model["time"], rtol=0.0, atol=1e-9):
        raise InputError(f"the runs have different times: {len(t)} and {len(model)} rows; simulate both alike")
    found = {}
    for name in reference.names:
        if name in model.columns and name != "time":
            error = model[name] - reference[name]
            k = int(np.argmax(np.abs(error)))
            rms = float(np.sqrt(np.mean(error * error)))
            found[name] = Difference(reference.unit(name), float(error[k]), float(t[k]), rms, float(error[-1]))
    return found


def in_field_units(table: Table, name: str) -> tuple[np.ndarray, str]:
    """A column and its unit as the field reads it; effector positions stay in metres."""
    unit = table.unit(name)
    field = "m" if name.startswith("effector") else FIELD_UNITS.get(unit, unit)
    return units.from_si(table[name], field), field


PANELS = (
    ("spool displacement", ("spool",)),
    ("flow", ("q_in", "q_out")),
    ("line pressure", ("p_in", "p_out")),
    ("joint angle", ("angle",)),
    ("joint rate", ("rate",)),
)


def plot_run(runs: Mapping[str, Table], *, link: str = "boom") -> "Figure":
    """Spool, flows, line pressures and motion of one link over time, one colour a run.

    Parameters
    ----------
    runs : mapping from label to trajectory
    link : str
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 10.0), layout="constrained")
    axes = figure.subplots(len(PANELS), 1, sharex=True)
    for axis, (title, quantities) in zip(axes, PANELS, strict=True):
        unit = ""
        for number, (label, table) in enumerate(runs.items()):
            for quantity, style in zip(quantities, ("-", "--"), strict=False):
                values, unit = in_field_units(table, f"{link}.{quantity}")
                name = f"{label} {quantity}" if len(quantities) > 1 else label
                axis.plot(table["time"], values, style, color=f"C{number}", label=name, linewidth=1.2)
        axis.set_ylabel(f"{title}\n[{unit}]")
        axis.grid(alpha=0.3)
        if len(runs) > 1 or len(quantities) > 1:
            axis.legend(fontsize="small", loc="upper right")
    axes[-1].set_xlabel("time [s]")
    first = next(iter(runs.values()))
    figure.suptitle(f"{link}: {first.info.get('scenario', '')}")
    return figure
