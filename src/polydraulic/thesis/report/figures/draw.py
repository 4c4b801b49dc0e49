"""Panels that several figures share: maps over spool travel and pressure, quantities over time."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.tables import Table
from polydraulic.thesis.printed_units import in_field_units
from polydraulic.thesis.report.catalog import Figure as Catalogued

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# What flow models are called on all pages; any other kind keeps its name.
NAMES = {
    "polynomial": "thesis' setting",
    "ours": "polydraulic",
    "fine": "polydraulic, finer",
    "direct": "polydraulic, direct",
    "polynomial with limit": "thesis' setting, limit learnt",
    "ours with limit": "polydraulic, limit learnt",
    "pressure": "pump-pressure networks",
    "neural": "perceptrons",
}

# What is drawn over time, by the end of a column's name.
_QUANTITIES = {
    "q_in": "input flow",
    "q_out": "output flow",
    "p_in": "input line pressure",
    "p_out": "output line pressure",
    "p_pump": "pump pressure",
    "angle": "joint angle",
    "rate": "joint velocity",
}

# Colour, line and width of each flow model: exact lies broad and pale below the others.
STYLES = {
    "exact": ("#9ec5e8", "-", 3.5),
    "iterative": ("C2", "-", 1.0),
    "polynomial": ("C1", "-", 1.2),
    "pressure": ("C3", "-", 1.2),
    "neural": ("C4", "-", 1.2),
    "ours": ("C0", "-", 1.0),
    "fine": ("C6", "-", 1.0),
    "polynomial with limit": ("C5", "-", 1.2),
    "ours with limit": ("C9", "-", 1.2),
}


def name_of(kind: str) -> str:
    """What a kind of flow model is called."""
    return NAMES.get(kind, kind)


def canvas(rows: int, columns: int, *, width: float = 9.0, height: float = 3.0) -> tuple["Figure", np.ndarray]:
    """Return a figure with a grid of axes; `height` is that of one row, in inches."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height * rows), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False)


def map_panel(axis: "Axes", table: Table, z: str, title: str, *, error: bool = False) -> None:
    """Colour map of a column over the first two columns, which form a grid; errors get a scale centred on zero."""
    x, y = (np.unique(table[name]) for name in table.names[:2])
    values = table[z].reshape(len(y), len(x))
    limit = float(np.max(np.abs(values))) or 1.0
    scale = {"cmap": "RdBu_r", "vmin": -limit, "vmax": limit} if error else {"cmap": "viridis"}
    mesh = axis.pcolormesh(x, y, values, shading="nearest", rasterized=True, **scale)
    bar = axis.figure.colorbar(mesh, ax=axis)
    bar.set_label(f"[{table.unit(z)}]")
    across, up = table.names[:2]
    axis.set_xlabel(f"{across} [{table.unit(across)}]")
    axis.set_ylabel(f"{up} [{table.unit(up)}]")
    axis.set_title(title, fontsize="medium")


def time_panel(axis: "Axes", runs: Mapping[str, Table], column: str, title: str) -> None:
    """One column of several runs over time, in the field's unit."""
    unit = ""
    for name, table in runs.items():
        values, unit = in_field_units(table, column)
        line(axis, name, table["time"], values)
    quantity = _QUANTITIES.get(column.rpartition(".")[2], "position")
    finish(axis, f"{quantity} [{unit}]", title)


def difference_panel(axis: "Axes", runs: Mapping[str, Table], column: str) -> None:
    """The same column minus that of the exact run."""
    exact, unit = in_field_units(runs["exact"], column)
    for name, table in runs.items():
        if name != "exact":
            line(axis, name, table["time"], in_field_units(table, column)[0] - exact)
    finish(axis, f"minus exact [{unit}]", "")
    axis.set_xlabel("time [s]")


def line(axis: "Axes", name: str, time: np.ndarray, values: np.ndarray) -> None:
    """A run over time in the style of its flow model."""
    color, style, width = STYLES[name]
    axis.plot(time, values, style, color=color, linewidth=width, label=name_of(name))


def finish(axis: "Axes", label: str, title: str) -> None:
    """Label a panel that is complete."""
    axis.set_ylabel(label)
    axis.set_title(title, fontsize="medium")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")


def columns_of_runs(runs: Mapping[str, Table], columns: Sequence[str]) -> Table:
    """Columns of several runs side by side in the field's units: the data of a figure."""
    first = next(iter(runs.values()))
    data, units = {"time": first["time"]}, {"time": "s"}
    for column in columns:
        for name, table in runs.items():
            data[f"{name_of(name)} {column}"], units[f"{name_of(name)} {column}"] = in_field_units(table, column)
    return Table(data, units)


def over_time(title: str, see: str, runs: Mapping[str, Table], columns: Mapping[str, str]) -> Catalogued:
    """Figure of quantities over time, each with its title, and of their differences from exact below."""

    def draw() -> "Figure":
        figure, axes = canvas(2, len(columns), width=4.8 * len(columns), height=2.4)
        for place, (column, name) in enumerate(columns.items()):
            time_panel(axes[0, place], runs, column, name)
            difference_panel(axes[1, place], runs, column)
        return figure

    return Catalogued(title, see, {"": columns_of_runs(runs, list(columns))}, draw)
