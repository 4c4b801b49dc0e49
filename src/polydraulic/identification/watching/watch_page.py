"""What watching a log has found, as a page: alarms, evidence over time, and what of the catalogue could be told."""

from html import escape
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import time_axis
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.identification.watching.watch_log import WatchedLog, alarm_heads, alarm_rows, named_by
from polydraulic.pages.html import document, svg_image
from polydraulic.pages.html import table as html_table
from polydraulic.watch.drift import BIAS, DRIFT
from polydraulic.watch.watch import FREEZE, Outlook

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NOTHING = 0.005  # share of what an alarm takes that is shown as 0 %
_LINES = 6  # directions that are drawn by name
# told apart by all eyes (Okabe and Ito 2008), on white as on what shades an alarm
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#b07800", "#3a9bd6")


def watch_page_ending(path: str | Path) -> None:
    """Refuse another ending than that of pages."""
    if Path(path).suffix.lower() != ".html":
        raise InputError(f"{path}: a page ends in .html")


def write_watch_page(found: WatchedLog, path: str | Path) -> None:
    """Write what watching a log has found.

    Parameters
    ----------
    found : WatchedLog
    path : str or Path
        ``.html``.

    Raises
    ------
    InputError
        Another ending.
    """
    watch_page_ending(path)
    minutes = len(found.time) * found.of.shape.seconds / 60.0
    named = {name for alarm in found.alarms for name in named_by(alarm)}
    beyond = {d.name for d, most in zip(found.of.directions, found.evidence.max(axis=0), strict=True) if most >= 1.0}

    def told(f: Outlook) -> str:
        if f.name in named:
            return "named in an alarm"
        if f.name.endswith(BIAS) and f.name.removesuffix(BIAS) + DRIFT in named:
            return "named in an alarm, as a drift"
        if f.name in beyond:
            return "what an alarm named explains the same evidence better"
        return "no sign of it" if f.could_show else _why_unsure(f)

    rows = [[f.title, told(f)] for f in found.findings]
    parts = [
        f"<p>{escape(found.source)}: {minutes:.1f} min, {len(found.of.columns)} sensors. What is to be expected from "
        f"{escape(found.healthy)}, {found.expected.blocks} blocks of {found.of.shape.seconds:g} s. Tests are set to {found.rate:g} false alarms per hour.</p>",
        *(f"<p>Warning: {escape(doubt)}.</p>" for doubt in found.doubts),
        *([f"<p>Not judged: {escape(found.not_judged)}.</p>"] if found.not_judged else []),
        "<h2>Alarms</h2>",
        html_table("", alarm_heads(found.alarms), alarm_rows(found.alarms, found.began, found.parts))
        if found.alarms
        else "<p>None.</p>",
        "<h2>Evidence</h2>",
        "<p>Of each fault since it may have begun, as a share of what makes an alarm; no more than twice that is counted.</p>",
        svg_image(_svg(plot_watch(found)), "Evidence over time"),
        "<h2>What was watched</h2>",
        "<p>Each in the smallest size that counts. Where the machine's work gave a fault no occasion to show, nothing is said of it.</p>",
        html_table("", ("fault", "in this log"), rows),
    ]
    write_text(path, document(f"{found.of.machine.title}: watched", "\n".join(parts)))


def _why_unsure(f: Outlook) -> str:
    """Why nothing is said of a fault that would not have shown."""
    if f.share < _NOTHING:
        return "cannot tell: the work in this log gave it no occasion to show"
    share = f"{min(f.share, 0.99):.0%}"
    if f.name.endswith(FREEZE):
        return f"cannot tell: its function moved for only {share} of the time that it takes to be sure"
    return f"cannot tell: in this log it would have given only {share} of what an alarm takes"


def plot_watch(found: WatchedLog) -> "Figure":
    """Draw the evidence of all tests over time, and the alarms.

    Parameters
    ----------
    found : WatchedLog

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.0), dpi=100, layout="constrained")
    axis = figure.subplots()
    most = found.evidence.max(axis=0)
    first = [d.name for d in found.of.directions]
    drawn: list[int] = []
    for k in np.lexsort(
        (found.evidence.argmax(axis=0), -most)
    ).tolist():  # of those that come as far, the one that does so first
        if len(drawn) < _LINES and most[k] > 0.5 and first[k] not in [first[j] for j in drawn]:
            drawn.append(k)
    time, label = time_axis(found.time, found.began)
    axis.plot(time, found.evidence.max(axis=1), color="#777", linewidth=0.8, label="the most of all faults")
    for colour, k in zip(_COLOURS, drawn, strict=False):
        axis.plot(time, found.evidence[:, k], color=colour, linewidth=1.6, label=first[k])
    for number, alarm in enumerate(found.alarms):
        (since, until), _ = time_axis(np.array([alarm.since, alarm.until]), found.began)
        axis.axvspan(
            since, until, color="#222", alpha=0.07, linewidth=0.0, label="" if number else "alarm, since to until"
        )
    axis.axhline(1.0, color="#222", linewidth=1.0, linestyle="--", label="enough for an alarm")
    axis.set_ylim(0.0, 2.1)
    axis.set_xlabel(label)
    axis.set_ylabel("evidence / threshold")
    axis.grid(alpha=0.25)
    axis.legend(loc="upper left", fontsize=8)
    return figure


def _svg(figure: "Figure") -> str:
    import matplotlib

    text = StringIO()
    with matplotlib.rc_context({"svg.hashsalt": "watch"}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
