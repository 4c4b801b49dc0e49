"""Runs on logs drawn, of models and of machines: measured and simulated over time, one panel per output or joint."""

from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.display import DEFAULT, as_drawn, as_shown, shown_unit, time_axis, with_unit
from polydraulic.identification.log_replay import Replay
from polydraulic.identification.runs import DynamicRun, ModelRuns
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.shown_model import shown_model
from polydraulic.tables import began

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MEASURED, _ON_ITS_OWN = "#9ec5e8", "#e07a1f"  # as runs of the machine are drawn
_SHOWN = 6  # runs that have a panel of their own, windows of a replay
_COLORS = ("#2f8f4e", "#b5367a", "#5b4bb5", "#c98a12", "#1f8fa8", "#7a5230")  # of joints in their order, then dashed


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
    """Each run in a panel of its own, the longest ones if they are many: what cards show of rows that were held out.

    Panels share one axis, but those of a joint that turns without end: whole turns apart, nothing would be seen of its runs.
    """
    from matplotlib.figure import Figure

    length = np.bincount(run.number)
    shown = np.sort(np.argsort(-length, kind="stable")[:_SHOWN])
    figure = Figure(figsize=(8.0, 0.6 + 1.7 * len(shown)), layout="constrained")
    response: Any = model.training.get("response")
    endless = bool(response and response.get("continuous"))
    axes = figure.subplots(len(shown), 1, squeeze=False, sharey=not endless)[:, 0]
    label = ""
    for axis, number in zip(axes, shown, strict=True):
        label = _draw(axis, run, run.number == number, _half_width(model, run))
        axis.set_ylabel(as_drawn(str(model.output)), fontsize="small")
    axes[-1].set_xlabel(label)
    _legend(figure, axes[0])
    return figure


def shown_windows(found: Replay) -> str:
    """Which windows `plot_replay` shows, in words."""
    n = len(found.windows)
    return f"the first {_SHOWN} of {n} windows" if n > _SHOWN else f"all {n} windows"


def plot_replay(found: Replay, *, units: str = DEFAULT) -> "Figure":
    """Measured angles of each joint, above them the runs, restarted in each window, and how far apart they are.

    Parameters
    ----------
    found : Replay
        Its first six windows are shown, over dates where the log has dates; the figure says of how many.
    units : str
        ``"metric"``, ``"field"`` or ``"si"``.
    """
    from matplotlib.figure import Figure

    joints = found.drifts[:-1]  # the last one is the tip's
    kinds, label = list(dict.fromkeys(joint.unit for joint in joints)), ""
    n, n_all = len(joints), len(joints) + len(kinds)
    figure = Figure(figsize=(7.0, 1.5 * n_all), layout="constrained")
    axes = figure.subplots(n_all, 1, sharex=True)
    apart = dict(zip(kinds, axes[n:], strict=True))
    for place, (axis, joint) in enumerate(zip(axes[:n], joints, strict=True)):
        below, line = apart[joint.unit], "-" if place < len(_COLORS) else "--"
        for number, window in enumerate(found.windows[:_SHOWN]):
            time, label = time_axis(window.time, found.began)
            measured, run = (as_shown(of[:, place], joint.unit, units) for of in (window.measured, window.run))
            names = ("measured", "run", "restarted") if number == 0 else (None, None, None)
            axis.plot(time, measured, color=_MEASURED, linewidth=3.5, label=names[0])
            axis.plot(time, run, color=_ON_ITS_OWN, linewidth=1.1, label=names[1])
            axis.plot(time[:1], run[:1], "o", color=_ON_ITS_OWN, markersize=4.0, label=names[2])
            color, name = _COLORS[place % len(_COLORS)], joint.name if number == 0 else None
            below.plot(time, run - measured, line, color=color, linewidth=0.9, label=name)
        what = "angle" if joint.unit == "rad" else "position"
        axis.set_ylabel(f"{joint.name}\n{with_unit(what, shown_unit(joint.unit, units))}")
        axis.grid(alpha=0.3)
    axes[0].set_title(shown_windows(found), loc="left", fontsize="medium")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right", ncols=3, frameon=False)
    for unit, below in apart.items():
        below.set_ylabel(f"run - measured\n[{shown_unit(unit, units)}]")
        below.grid(alpha=0.3)
        below.legend(
            ncols=6, fontsize="small", frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1
        )
    axes[-1].set_xlabel(label)
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
