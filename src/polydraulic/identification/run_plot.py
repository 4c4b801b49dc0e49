"""Free runs drawn: measured and simulated over time, one panel per output."""

from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import DEFAULT, as_drawn, time_axis
from polydraulic.identification.runs import DynamicRun, ModelRuns
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.shown_model import shown_model
from polydraulic.tables import began

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MEASURED, _ON_ITS_OWN = "#9ec5e8", "#e07a1f"  # as runs of the machine are drawn
_SHOWN = 6  # runs that have a panel of their own


def plot_runs(found: ModelRuns, *, units: str = DEFAULT) -> "Figure":
    """All runs on one axis of time, one panel per output.

    Parameters
    ----------
    found : ModelRuns
        From `run_models`; over dates where its log has dates.
    units : str
        ``"metric"``, ``"field"`` or ``"si"``; outputs in units of their own stay.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 0.8 + 2.4 * len(found.runs)), layout="constrained")
    axes = figure.subplots(len(found.runs), 1, squeeze=False, sharex=True)[:, 0]
    label = ""
    for axis, own, answered in zip(axes, found.models, found.runs, strict=True):
        model, run = shown_model(own, units), answered.shown(own.output.unit, units)
        label = _draw(axis, run, np.ones(len(run.row), dtype=bool), _half_width(model, run), began(found.log))
        axis.set_ylabel(as_drawn(str(model.output)))
    axes[-1].set_xlabel(label)
    _legend(figure, axes[0])
    return figure


def plot_separately(model: Model, run: DynamicRun) -> "Figure":
    """Each run in a panel of its own, the longest ones if they are many: what cards show of rows that were held out."""
    from matplotlib.figure import Figure

    length = np.bincount(run.number)
    shown = np.sort(np.argsort(-length, kind="stable")[:_SHOWN])
    figure = Figure(figsize=(8.0, 0.6 + 1.7 * len(shown)), layout="constrained")
    axes = figure.subplots(len(shown), 1, squeeze=False, sharey=True)[:, 0]
    label = ""
    for axis, number in zip(axes, shown, strict=True):
        label = _draw(axis, run, run.number == number, _half_width(model, run))
        axis.set_ylabel(as_drawn(str(model.output)), fontsize="small")
    axes[-1].set_xlabel(label)
    _legend(figure, axes[0])
    return figure


def _draw(axis: "Axes", run: DynamicRun, shown: np.ndarray, half_width: float | None, began: float = 0.0) -> str:
    """Draw rows of a run; returns the label of the axis of time."""
    time, number = run.time[shown], run.number[shown]
    # no line from one run to the next
    ends = np.flatnonzero(np.diff(number)) + 1
    time, measured, free = (np.insert(values, ends, np.nan) for values in (time, run.measured[shown], run.free[shown]))
    at, label = time_axis(time, began)
    if half_width is not None:
        axis.fill_between(
            at, free - half_width, free + half_width, color=_ON_ITS_OWN, alpha=0.15, linewidth=0.0, rasterized=True
        )
    axis.plot(at, measured, color=_MEASURED, linewidth=2.0, label="measured")
    axis.plot(at, free, color=_ON_ITS_OWN, linewidth=1.0, label="free run")
    axis.margins(x=0.01)
    axis.grid(alpha=0.3)
    return label


def _half_width(model: Model, run: DynamicRun) -> float | None:
    """Half width of the interval, where a model states one for runs of this length."""
    widths, longest = model.training.get("interval_half_widths"), model.training.get("free_run_rows")
    if not isinstance(widths, list) or len(widths) != 1 or not isinstance(longest, int) or run.longest > longest:
        return None
    return float(widths[0])


def _legend(figure: "Figure", axis: "Axes") -> None:
    handles, labels = axis.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=len(handles), frameon=False)
