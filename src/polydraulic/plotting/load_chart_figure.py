"""A lift chart as a picture and as a page: capacity over reach and height, the side of the machine in front of it, and what limits it where."""

import io
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import DEFAULT, amount, as_shown, checked_units, shown_unit
from polydraulic.machine.stability.lifting import HYDRAULIC_SHARE, TIPPING_SHARE
from polydraulic.machine.stability.load_chart import LoadChart, load_chart
from polydraulic.pages.html import Cell, document, svg_image, table
from polydraulic.parameters.layout.schema import LayoutMachine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure

_FINE = 4  # cells of the picture in one of the chart, each way
_LEVELS = 9
_TIPS, _HOLDS = "#b03a2e", "#1f4e79"
RULE = (
    f"The lower of {TIPPING_SHARE:.0%} of the load that tips the machine on level, firm ground and {HYDRAULIC_SHARE:.0%} of the load that its "
    "hydraulics hold (ISO 10567). The load hangs at the tip as a point mass, what is at the end of the arm is part of the machine."
)


def draw_load_chart(
    machine: LayoutMachine, chart: LoadChart, *, held: dict[str, float] | None = None, units: str = DEFAULT
) -> "Figure":
    """Draw a lift chart: colours say how much, numbers what stands in the table, hatching where tipping limits.

    Parameters
    ----------
    machine : LayoutMachine
        That the chart is of.
    chart : LoadChart
        From `load_chart`.
    held : dict from function to position, optional
        As given to `load_chart`.
    units : str
        ``"metric"``, ``"field"`` or ``"si"``.

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib.figure import Figure

    checked_units(units)
    step = float(chart.height[1] - chart.height[0]) if len(chart.height) > 1 else float(chart.reach[0])
    fine = load_chart(machine, step=step / _FINE, moved=chart.moved, lifting=chart.lifting, held=held)
    count = len(chart.over)
    across, up = (float(np.ptp(values)) for values in (fine.reach, fine.height))
    width = float(np.clip(6.2 * across / max(up, 1e-9), 3.2, 9.0))
    figure = Figure(figsize=(1.8 + (width + 0.4) * count, 7.6), dpi=100, layout="constrained")
    axes = figure.subplots(1, count, squeeze=False, sharey=True)[0]
    levels = _levels(fine.capacity)
    shown = [_panel(axis, chart, fine, k, levels, units) for k, axis in enumerate(axes)]
    axes[0].set_ylabel(f"height of the tip above the ground [{shown_unit('m', units)}]")
    bar = figure.colorbar(shown[0], ax=list(axes), pad=0.01, fraction=0.035)
    bar.set_label(f"lift capacity [{shown_unit('kg', units)}]")
    bar.set_ticks(levels.tolist(), labels=[f"{as_shown(level, 'kg', units):.0f}" for level in levels])
    figure.suptitle(f"{chart.title}: lift capacity", fontweight="bold", x=0.01, ha="left")
    note = "Numbers: capacity. Red and hatched: tipping limits it; blue: hydraulics do."
    figure.supxlabel(note, fontsize=8, color="0.35", x=0.01, ha="left")
    return figure


def _levels(capacity: np.ndarray) -> np.ndarray:
    """Steps of colour, kg: rising by equal factors, since capacity falls about as one over the reach."""
    known = capacity[np.isfinite(capacity)]
    low, high = (float(np.quantile(known, share)) for share in (0.01, 0.99)) if len(known) else (1.0, 2.0)
    steps = np.geomspace(max(low, 1.0), max(high, 1.1 * low, 2.0), _LEVELS)
    digits = 10.0 ** (np.floor(np.log10(steps)) - 1.0)
    return np.unique(np.round(steps / digits) * digits)


def _panel(axis: "Axes", chart: LoadChart, fine: LoadChart, k: int, levels: np.ndarray, units: str) -> "QuadContourSet":
    scale = as_shown(1.0, "m", units)
    x, y = scale * fine.reach, scale * fine.height
    shown = axis.contourf(
        x, y, np.ma.masked_invalid(fine.capacity[k]), levels=levels, cmap="YlGnBu", extend="both", alpha=0.75
    )
    tips = np.where(fine.limit[k] >= 0, (fine.limit[k] < fine.tipping).astype(float), np.nan)
    if np.nanmax(tips, initial=0.0) > 0.0:
        axis.contourf(x, y, np.ma.masked_invalid(tips), levels=[0.5, 1.5], colors="none", hatches=["///"])
    axis.axhline(0.0, color="#8a6d3b", linewidth=1.0)
    for row, height in enumerate(chart.height):
        for column, reach in enumerate(chart.reach):
            load = chart.capacity[k, row, column]
            if isfinite(load):
                colour = _TIPS if chart.limit[k, row, column] < chart.tipping else _HOLDS
                text = f"{as_shown(float(load), 'kg', units):.0f}"
                box = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none", "alpha": 0.8}
                axis.text(
                    scale * reach, scale * height, text, ha="center", va="center", fontsize=7.5, color=colour, bbox=box
                )
    axis.set_aspect("equal")
    axis.set_title(f"over the {chart.over[k]}", loc="left", fontsize=10)
    axis.set_xlabel(f"reach [{shown_unit('m', units)}]")
    axis.grid(alpha=0.25)
    return shown


def load_chart_rows(chart: LoadChart, over: int, units: str = DEFAULT) -> list[list[str]]:
    """A chart as text: a header of reaches, then a row for each height from above, a dash where the tip cannot be.

    Parameters
    ----------
    chart : LoadChart
    over : int
        Place in `chart.over`.
    units : str

    Returns
    -------
    list of list of str
        Each capacity with what limits it, ``3692 left`` or ``4076 boom``.
    """
    known = np.isfinite(chart.capacity[over])
    columns, rows = np.flatnonzero(known.any(axis=0)), np.flatnonzero(known.any(axis=1))[::-1]
    found = [["height", *(amount(float(chart.reach[c]), "m", units) for c in columns)]]
    for row in rows:
        cells = [_cell(chart, over, int(row), int(c), units) for c in columns]
        found.append([amount(float(chart.height[row]), "m", units), *cells])
    return found


def _cell(chart: LoadChart, over: int, row: int, column: int, units: str) -> str:
    load = float(chart.capacity[over, row, column])
    if not isfinite(load):
        return "-"
    what = chart.limits[chart.limit[over, row, column]].removeprefix("tipping ")
    return f"{as_shown(load, 'kg', units):.0f} {what}"


def load_chart_page(
    machine: LayoutMachine, chart: LoadChart, *, held: dict[str, float] | None = None, units: str = DEFAULT
) -> str:
    """A page with picture and tables of a chart; arguments as of `draw_load_chart`."""
    stream = io.BytesIO()
    figure = draw_load_chart(machine, chart, held=held, units=units)
    figure.savefig(stream, format="svg", metadata={"Date": None}, bbox_inches="tight")
    tables = []
    for k, over in enumerate(chart.over):
        header, *rows = load_chart_rows(chart, k, units)
        cells = [[Cell(text, "number") for text in row] for row in rows]
        tables.append(table(f"Over the {over}, in {shown_unit('kg', units)}", header, cells))
    how = f"Moved by {chart.moved[0]} and {chart.moved[1]}; {chart.lifting} lifts at the pump's pressure, all others hold at their relief valves."
    body = f"<p>{RULE} {how}</p>{svg_image(stream.getvalue(), 'Lift capacity')}"
    return document(f"{chart.title}: lift capacity", body + "".join(tables))
