"""The standard plot of a run, or of several runs of the same scenario on top of each other."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, as_drawn, as_shown, shown_unit, with_unit
from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table, shown_column

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class Panel(NamedTuple):
    """One row of the plot: what it shows of a function, full lines and dashed ones, and whether all share its scale."""

    title: str
    full: str
    dashed: str | None = None
    lines: str = ""
    shared: bool = True


PANELS = (
    Panel("joystick", "voltage"),
    Panel("spool", "spool"),
    Panel("flow", "q_in", "q_out", "full: into the actuator, dashed: out of it"),
    Panel("pressure", "p_in", "p_pump", "full: inlet (A, or B at a negative spool), dashed: pump"),
    Panel("angle", "angle", shared=False),  # links work in different ranges
)
_ABOUT_LINES: dict[str, Any] = {"fontsize": "x-small", "color": "0.4", "pad": 2.0}  # above a panel, where no curve is
# The first run lies broad and pale below the others; one that is alone has lines as any.
FIRST, ALONE = ("#9ec5e8", 3.5), ("#3b6ea5", 1.3)
OTHERS = ("#e07a1f", "#2f8f4e", "#b5367a", "#5b4bb5", "#7a6a3a")


def line_style(number: int, of: int = 2) -> tuple[str, float]:
    """Colour and width of the lines of run `number`, counted from zero, of so many."""
    if of == 1:
        return ALONE
    return FIRST if number == 0 else (OTHERS[(number - 1) % len(OTHERS)], 1.1)


def moving_links(runs: Mapping[str, Table]) -> list[str]:
    """Functions that move in the runs, in the order of the first run's columns.

    Raises
    ------
    InputError
        If there is no run, or one that is not a trajectory.
    """
    if not runs:
        raise InputError("there is no run to show; give at least one, for example {'exact': simulate(...)}")
    for label, table in runs.items():
        missing = [name for name in ("time", *EFFECTOR) if name not in table.names]
        if missing:
            raise InputError(f"run {label!r} has no column {missing[0]!r}; give tables made by simulate")
    first, *others = runs.values()
    moving = [name.removesuffix(".spool") for name in first.names if name.endswith(".spool")]
    return [link for link in moving if all(f"{link}.spool" in table.names for table in others)]


def joint_column(table: Table, name: str, label: str) -> str:
    """Column that holds where a function's joint is: its angle, or its position if it slides.

    Raises
    ------
    InputError
        If the run called `label` has neither.
    """
    found = [column for column in (f"{name}.angle", f"{name}.position") if column in table.names]
    if not found:
        raise InputError(
            f"run {label!r} has no column '{name}.angle' or '{name}.position'; give runs of the same machine"
        )
    return found[0]


def circuit_of(table: Table, link: str) -> str:
    """The circuit that feeds a function, as the run says; its own name where the run says nothing."""
    circuits: Any = table.info.get("circuits", {})
    return next((circuit for circuit, fed in circuits.items() if link in fed), link)


def plot_run(runs: Mapping[str, Table], *, units: str = DEFAULT) -> "Figure":
    """Joystick, spool, flow, pressure and angle (or position) of every moving function over time, one colour per run, and below the end-effector.

    The first run is the one that the others are compared with: the last panel shows how far their end-effectors are from
    its. For a single run it shows the end-effector's position.

    Parameters
    ----------
    runs : mapping from label to trajectory
    units : str
        ``"metric"`` (bar, l/min, mm, deg), ``"field"`` (psi, in3/s, in, deg) or ``"si"``.

    Returns
    -------
    matplotlib Figure

    Raises
    ------
    InputError
        If there is no run, a table that is not a trajectory, or an unknown system of units.
    """
    from matplotlib.figure import Figure

    links = moving_links(runs)
    width = max(8.0, 4.2 * min(len(links), 4) + 2.8 * max(len(links) - 4, 0))
    figure = Figure(figsize=(width, 11.0), layout="constrained")
    name_size = min(12.0, 100.0 * width / len(links) / max(len(link) for link in links))  # so that names keep apart
    grid = figure.add_gridspec(len(PANELS) + 1, len(links), height_ratios=[0.8, 0.8, 1.2, 1.2, 1.2, 1.0])
    first: Axes | None = None
    rows: dict[int, Axes] = {}  # the first axis of each
    for column, link in enumerate(links):
        for row, panel in enumerate(PANELS):
            axis = figure.add_subplot(grid[row, column], sharex=first, sharey=rows.get(row) if panel.shared else None)
            first = first or axis
            rows.setdefault(row, axis)
            _draw_panel(axis, runs, link, panel, units)
            axis.tick_params(labelbottom=row == len(PANELS) - 1, labelleft=column == 0 or not panel.shared)
            if row == 0:
                axis.set_title(link, fontweight="bold", fontsize=name_size)
            # not so where one joint turns and another slides
            if column and axis.get_ylabel() == rows[row].get_ylabel():
                axis.set_ylabel("")
    below = figure.add_subplot(grid[-1, :], sharex=first)
    _draw_effector(below, runs, units)
    below.set_xlabel("time [s]")
    title = next(iter(runs.values())).info.get("scenario", "")
    handles = [_handle(as_drawn(label), *line_style(number, len(runs))) for number, label in enumerate(runs)]
    figure.legend(handles=handles, loc="outside upper right", ncols=len(handles), frameon=False)
    figure.suptitle(as_drawn(str(title)), x=0.01, ha="left", fontweight="bold")
    return figure


def _draw_panel(axis: "Axes", runs: Mapping[str, Table], link: str, panel: Panel, units: str) -> None:
    unit, full = "", ""
    dashed: list[str] = []  # runs that have what the dashed lines show: networks know no pump pressure
    for number, (label, table) in enumerate(runs.items()):
        color, width = line_style(number, len(runs))
        full = joint_column(table, link, "") if panel.full == "angle" else f"{link}.{panel.full}"
        values, unit = shown_column(table, full, units)
        axis.plot(table["time"], values, color=color, linewidth=width)
        owner = circuit_of(table, link) if panel.dashed == "p_pump" else link
        if panel.dashed and f"{owner}.{panel.dashed}" in table.names:
            values, unit = shown_column(table, f"{owner}.{panel.dashed}", units)
            axis.plot(table["time"], values, "--", color=color, linewidth=0.6 * width)
            dashed.append(label)
    axis.set_ylabel(with_unit(full.rpartition(".")[2] if panel.full == "angle" else panel.title, unit))
    if dashed:
        alone = f" ({as_drawn(', '.join(dashed))} alone)" if len(dashed) < len(runs) else ""
        axis.set_title(panel.lines + alone, loc="right", **_ABOUT_LINES)
    axis.grid(alpha=0.3)


def _draw_effector(axis: "Axes", runs: Mapping[str, Table], units: str) -> None:
    reference, *others = runs.values()
    if others:
        for number, table in enumerate(others, start=1):
            color, width = line_style(number)
            distance = as_shown(effector_distance(reference, table), "m", units)
            axis.plot(table["time"], distance, color=color, linewidth=width)
        axis.set_ylabel(with_unit(f"tip from\n{as_drawn(next(iter(runs)))}", shown_unit("m", units)))
        axis.set_ylim(bottom=0.0)
    else:
        for name, style in zip(EFFECTOR, ("-", "--", ":"), strict=True):
            values, unit = shown_column(reference, name, units)
            axis.plot(reference["time"], values, style, color="0.25", linewidth=1.3, label=name[-1])
            axis.set_ylabel(with_unit("tip position", unit))
        axis.set_title("full: x, dashed: y, dotted: z", loc="right", **_ABOUT_LINES)
    axis.set_xlim(float(reference["time"][0]), float(np.max(reference["time"])))
    axis.grid(alpha=0.3)


def _handle(label: str, color: str, width: float) -> object:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=color, linewidth=width, label=label)


def picture_ending(path: str | Path) -> str:
    """Format of a picture, from its path, or an InputError."""
    formats = ("svg", "png", "pdf")
    ending = Path(path).suffix.lower().removeprefix(".")
    if ending not in formats:
        raise InputError(f"{path}: a picture ends in one of {[f'.{name}' for name in formats]}")
    return ending


def save_figure(figure: "Figure", path: str | Path) -> None:
    """Write a figure, whole or not at all.

    Parameters
    ----------
    figure : matplotlib Figure
    path : str or Path
        Ends in ``.svg``, ``.png`` or ``.pdf``. The same figure gives the same SVG.

    Raises
    ------
    InputError
        Another ending, or a place that cannot be written.
    """
    import matplotlib

    ending = picture_ending(path)
    with matplotlib.rc_context({"svg.hashsalt": Path(path).stem}), replacing(path) as temporary:
        figure.savefig(temporary, format=ending, dpi=150)
