"""A model card: what a model was learnt from, how far it can be trusted, and what it is; as a page and as JSON."""

import io
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export import to_text
from polydraulic.files import write_text
from polydraulic.networks import Model, model_bounds
from polydraulic.networks.plot import draw_network
from polydraulic.studies.fit import Fit
from polydraulic.studies.html import document
from polydraulic.studies.html import table as html_table
from polydraulic.tables import Table

SCHEMA = 1
_SHOWN = 12  # regions whose network is drawn and written out
_BINS = 20  # of the coverage map
_EFFORT = 200  # sub-boxes a region, of the proofs


def write_card(
    fits: Sequence[Fit], table: Table, source: str, path: str | Path, seen: tuple[dict[str, Any], str] | None = None
) -> dict[str, Any]:
    """Write the card of models fitted to a table: a page that needs nothing else, and JSON beside it.

    Parameters
    ----------
    fits : sequence of Fit
        From `fit_table`.
    table : Table
        What they were fitted to.
    source : str
        Where the table came from, as it shall stand in the card.
    path : str or Path
        Of the page, ``.html``; the JSON has the same name and the ending ``.card.json``, since a model may be called ``.json``.
    seen : (dict, str), optional
        What is said of the data as a whole, as entries of the JSON and as HTML; where the rows lie by the first model's inputs if not
        given.

    Returns
    -------
    dict
        What the JSON holds.

    Raises
    ------
    InputError
        Another ending, or a place that cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".html":
        raise InputError(f"{path}: a model card ends in .html")
    entries, shown = seen or ({}, _coverage_of(fits[0].model, table))
    card: dict[str, Any] = {
        "schema": SCHEMA,
        "data": _data(fits, table, source) | entries,
        "models": [_facts(found.model) for found in fits],
    }
    sections = "\n".join(_section(found, facts) for found, facts in zip(fits, card["models"], strict=True))
    body = f"""<h2>Data</h2>
{_columns(card["data"])}
{shown}
{sections}"""
    write_text(path.with_suffix(".card.json"), json.dumps(card, indent=1, allow_nan=False) + "\n")
    write_text(path, document(f"Model card: {source}", body))
    return card


def _data(fits: Sequence[Fit], table: Table, source: str) -> dict[str, Any]:
    """Rows, columns with their ranges, how rows were held out."""
    variables = [v for found in fits for v in found.model.inputs] + [found.model.output for found in fits]
    names = list(dict.fromkeys(v.name for v in variables))
    columns = [
        {"name": name, "unit": table.unit(name), "low": float(table[name].min()), "high": float(table[name].max())}
        for name in names
    ]
    found: dict[str, Any] = {
        "source": source,
        "rows": len(table),
        "columns": columns,
        "held_out": fits[0].model.training["held_out"],
    }
    if "time" in table.names:
        found["seconds"] = float(table["time"].max() - table["time"].min())
    if "segment" in table.names:
        found["segments"] = len(np.unique(table["segment"]))
    return found


def _facts(model: Model) -> dict[str, Any]:
    """What is known of one model: errors, intervals, proved bounds, domain."""
    bounds = model_bounds(model, max_boxes=_EFFORT)
    regions = [
        {"region": name, "proved_low": region.low, "proved_high": region.high}
        for name, region in zip(model.region_names(), bounds.regions, strict=True)
        if region is not None
    ]
    return {
        "output": str(model.output),
        "inputs": [str(variable) for variable in model.inputs],
        "domain": model.domain().tolist(),
        "coefficients": model.n_coefficients,
        "networks": len(model.networks),
        "proved_low": bounds.low,
        "proved_high": bounds.high,
        "regions": regions,
        "training": model.training,
    }


def _section(found: Fit, facts: dict[str, Any]) -> str:
    model, training = found.model, facts["training"]
    unit = escape(model.output.unit)
    widths = training["interval_half_widths"]
    interval = (
        f"{training['interval_level']:.0%} intervals of plus or minus {min(widths):.4g} to {max(widths):.4g} {unit} by region "
        f"hold for {found.covered:.1%} of the rows they were not set by"
        if widths
        else "too few rows were held out to state intervals"
    )
    regions = [
        [r["region"], str(r["rows"]), f"{r['rms']:.4g}", f"{r['largest']:.4g}"] for r in training["held_out_by_region"]
    ]
    proved = [[r["region"], f"{r['proved_low']:.4g}", f"{r['proved_high']:.4g}"] for r in facts["regions"]]
    domain = [
        [str(v), f"{low:.6g}", f"{high:.6g}"] for v, (low, high) in zip(model.inputs, facts["domain"], strict=True)
    ]
    shown = min(len(model.networks), _SHOWN)
    more = "" if shown == len(model.networks) else f"<p>The first {shown} of {len(model.networks)} regions.</p>"
    return f"""<h2>{escape(facts["output"])}</h2>
<p>{facts["networks"]} network(s), {facts["coefficients"]} coefficients. On the rows held out ({escape(training["held_out"])}): R²
{found.r2:.5f}, rms error {found.rms:.4g} {unit}, largest {found.largest:.4g} {unit}; {interval}. Proved: no output leaves
{facts["proved_low"]:.6g} to {facts["proved_high"]:.6g} {unit}, whatever the inputs.</p>
{html_table("Errors on the rows held out", ["region", "rows", f"rms [{model.output.unit}]", f"largest [{model.output.unit}]"], regions)}
{html_table("Domain: inputs outside are moved to its border", ["input", "low", "high"], domain)}
{html_table("Proved range by region", ["region", "low", "high"], proved)}
{_picture(_errors(found))}
<h3>What it is</h3>
{more}{_picture(_networks(model, shown))}
<pre>{escape(to_text(model) if len(model.networks) <= _SHOWN else "See the model file: more regions than fit here.")}</pre>"""


def _columns(data: dict[str, Any]) -> str:
    rows = [[c["name"], c["unit"], f"{c['low']:.6g}", f"{c['high']:.6g}"] for c in data["columns"]]
    spans = "".join(
        f", {data[key]:.6g} {word}" for key, word in (("seconds", "s"), ("segments", "segment(s)")) if key in data
    )
    caption = f"{data['source']}: {data['rows']} rows{spans}; held out: {data['held_out']}"
    return html_table(caption, ["column", "unit", "low", "high"], rows)


def _coverage_of(model: Model, table: Table) -> str:
    return f"""{_picture(_coverage(model, table))}
<p>Where the rows lie, for every pair of inputs; white is where nothing was seen.</p>"""


def _coverage(model: Model, table: Table) -> Any:
    """Histograms of all pairs of inputs."""
    from matplotlib.figure import Figure

    names = [variable.name for variable in model.inputs][:5]
    n = max(len(names) - 1, 1)
    figure = Figure(figsize=(3.0 * n, 2.6 * n), layout="constrained")
    axes = figure.subplots(n, n, squeeze=False)
    for row in range(n):
        for column in range(n):
            axis = axes[row, column]
            if len(names) == 1:
                axis.hist(table[names[0]], bins=_BINS)
                axis.set_xlabel(names[0])
            elif column > row:
                axis.set_axis_off()
            else:
                x, y = table[names[column]], table[names[row + 1]]
                counts, xs, ys = np.histogram2d(x, y, bins=_BINS)
                axis.pcolormesh(
                    xs, ys, np.where(counts > 0.0, np.log10(np.maximum(counts, 1.0)), np.nan).T, rasterized=True
                )
                axis.set_xlabel(names[column], fontsize="small")
                axis.set_ylabel(names[row + 1], fontsize="small")
    return figure


def _errors(found: Fit) -> Any:
    """Predicted over measured, and the errors, of the rows held out."""
    from matplotlib.figure import Figure

    y, error = found.held.y, found.held.predicted - found.held.y
    figure = Figure(figsize=(8.0, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(y, found.held.predicted, ",", rasterized=True)
    left.set_xlabel(f"measured {found.model.output}")
    left.set_ylabel("predicted")
    right.hist(error, bins=60)
    right.set_xlabel(f"error [{found.model.output.unit}]")
    right.set_yscale("log")
    return figure


def _networks(model: Model, shown: int) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 2.0 * shown), layout="constrained")
    axes = figure.subplots(shown, 1, squeeze=False)
    for axis, network, name in zip(axes[:, 0], model.networks, model.region_names(), strict=False):
        draw_network(axis, network, model.inputs, model.output)
        axis.set_title(name, fontsize="small")
    return figure


def _picture(figure: Any) -> str:
    """A figure as an image inside the page."""
    import base64

    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=120)
    return (
        f'<figure><img src="data:image/svg+xml;base64,{base64.b64encode(stream.getvalue()).decode()}" alt=""></figure>'
    )
