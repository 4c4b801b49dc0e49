"""The card of an identified machine: how well it fits, its curves and how sure they are, what was not determined, how far it drifts."""

from html import escape
from io import StringIO
from pathlib import Path

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit, with_unit
from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.identification.equations.free_runs import FREE_RUN_HEADS, free_run_rows, free_runs
from polydraulic.identification.equations.identify import Identification
from polydraulic.identification.equations.words import (
    NUMBER_HEADS,
    VALVE_HEADS,
    WINDOW_HEADS,
    number_rows,
    valve_rows,
    window_rows,
)
from polydraulic.pages.html import bullets, document, svg_image
from polydraulic.pages.html import table as html_table
from polydraulic.progress import Progress, quiet

_SURE = 2.0  # standard errors that a band is wide
_DROP = 1e6  # Pa, at which conductances are shown as flows
_BINS = 60


def identification_card_ending(path: str | Path) -> None:
    """Refuse another ending than that of cards."""
    if Path(path).suffix.lower() != ".html":
        raise InputError(f"{path}: a card ends in .html")


def write_identification_card(
    found: Identification, path: str | Path, *, units: str = DEFAULT, progress: Progress = quiet
) -> None:
    """Write the card of an identified machine.

    Parameters
    ----------
    found : Identification
    path : str or Path
        ``.html``.
    units : str
        Of what is shown.
    progress : Progress, optional
        Told as the machine runs against its log.
    """
    identification_card_ending(path)
    runs, why = free_runs(found, progress=progress)
    parts = [
        f"<p>Identified from {escape(found.source)}, {len(found.table)} rows.</p>",
        "<p>Every fifth block of half a minute was held out to choose knots and to state errors; the curves below are those of all rows.</p>"
        if found.circuits
        else "",
        html_table("Flows left on blocks held out, root mean square", VALVE_HEADS, valve_rows(found, units))
        if found.circuits
        else "",
        html_table(
            f"Runs of {found.runs.windows} windows of {found.runs.seconds:g} s against sensors, robust standard deviation of what is left",
            WINDOW_HEADS,
            window_rows(found, units),
        )
        if found.runs is not None
        else "",
        html_table("Numbers", NUMBER_HEADS, rows) if (rows := number_rows(found, units)) else "",
        "<h2>What is determined, and what is not</h2>",
        bullets([*found.remarks, *found.kept]) or "<p>All that was free is determined.</p>",
        "<h2>Run against the log</h2>",
        "<p>From the measured state at the start of each window the machine is driven by the joysticks alone, over the last fifth of the log; largest "
        "distance in a window.</p>"
        if runs
        else f"<p>{escape(why)}.</p>",
        html_table("", FREE_RUN_HEADS, free_run_rows(runs, units)) if runs else "",
        "<h2>Curves</h2>" if found.circuits else "",
        f"<p>Conductances as flows at a drop of {as_shown(_DROP, 'Pa', units):g} {shown_unit('Pa', units)}, with {_SURE:g} standard errors; dashed, before. "
        "Below, how often the log has a spool there. Grey is where it has never been.</p>"
        if found.circuits
        else "",
    ]
    for name in found.circuits:
        parts.append(f"<h3>{escape(name)}</h3>")
        for function in found.circuits[name].valves:
            parts.append(svg_image(_curves_svg(found, name, function, units), f"Curves of {function}"))
    write_text(path, document(f"{found.before.title}: identified", "\n".join(parts)))


def _curves_svg(found: Identification, circuit: str, function: str, units: str) -> str:
    import matplotlib
    from matplotlib.figure import Figure

    v, old = found.circuits[circuit].valves[function], found.before.function(function).valve
    figure = Figure(figsize=(11.0, 4.2), layout="constrained")
    axes = figure.subplots(2, 4, sharex=True, height_ratios=[3.0, 1.0], squeeze=False)
    x = as_shown(np.array(v.curves.knots), "m", units)
    spool = np.abs(found.table.whole([f"{function}.spool"])[f"{function}.spool"])
    for place, key in enumerate(("inlet", "bypass", "outlet_positive", "outlet_negative")):
        axis, below = axes[0, place], axes[1, place]
        scale = as_shown(_DROP**0.5, "m3/s", units)
        values, errors = np.array(getattr(v.curves, key)) * scale, np.nan_to_num(v.errors[key]) * scale
        axis.fill_between(
            x,
            np.maximum(values - _SURE * errors, 0.0),
            values + _SURE * errors,
            color="#2a6fb0",
            alpha=0.25,
            linewidth=0.0,
        )
        axis.plot(x, values, color="#2a6fb0", marker="o", markersize=3.0, linewidth=1.2)
        axis.plot(
            as_shown(np.array(old.knots), "m", units),
            np.array(getattr(old, key)) * scale,
            color="#888",
            linestyle="--",
            linewidth=0.9,
        )
        axis.set_ylim(0.0, 1.15 * max(float(values.max()), 1e-12))
        axis.set_title(f"{function}: {key.replace('_', ' ')}", loc="left", fontsize="small")
        below.hist(as_shown(spool, "m", units), bins=_BINS, range=(0.0, float(x[-1])), color="#2a6fb0", log=True)
        below.set_ylim(bottom=0.8)  # a single row shows, and whole decades are labelled
        for one in (axis, below):
            one.axvspan(as_shown(v.seen[1], "m", units), float(x[-1]) + 1e-12, color="#ddd", linewidth=0.0, zorder=0)
            one.tick_params(labelsize="small")
        below.set_xlabel(with_unit("travel", shown_unit("m", units)), fontsize="small")
    axes[0, 0].set_ylabel(with_unit("flow", shown_unit("m3/s", units)), fontsize="small")
    axes[1, 0].set_ylabel("rows", fontsize="small")
    text = StringIO()
    with matplotlib.rc_context({"svg.hashsalt": function}):
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()
