"""A model card: what a model was learnt from, how far it can be trusted, and what it is; as a page and as JSON."""

import io
import json
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, as_drawn, as_shown, dated, moment, shown_unit, with_unit
from polydraulic.errors import InputError
from polydraulic.export.formula import to_text
from polydraulic.files import write_texts
from polydraulic.identification.dynamic_fit import DynamicFit, DynamicOutputFit, remarks
from polydraulic.identification.judging import OutputFit, unit_after
from polydraulic.identification.machine.machine_card import machine_facts
from polydraulic.identification.machine.machine_fit import MachineFit
from polydraulic.identification.run_plot import plot_separately
from polydraulic.identification.table_fit import TableFit
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.shown_model import region_names, shown_model
from polydraulic.networks.plot import ROW, draw_network, layers_of, node_rows
from polydraulic.networks.proof.bounds import model_bounds
from polydraulic.pages.html import document, svg_image
from polydraulic.pages.html import table as html_table
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table, began, shown_table

SCHEMA = 1
_SHOWN = 12  # regions whose network is drawn and written out
_BINS = 20  # of the coverage map
_PAIRED = 5  # inputs of which it shows all pairs
_EFFORT = 200  # sub-boxes a region, of the proofs
_PER_LAYER = 0.75  # inches of a drawing, that its boxes stand side by side


def card_ending(path: str | Path) -> Path:
    """Path of a card, or an InputError."""
    path = Path(path)
    if path.suffix.lower() != ".html":
        raise InputError(f"{path}: a model card ends in .html")
    return path


def write_card(
    fit: TableFit | DynamicFit | MachineFit,
    path: str | Path,
    *,
    source: str | None = None,
    max_boxes: int = _EFFORT,
    shown: int = _SHOWN,
    units: str = DEFAULT,
    progress: Progress = quiet,
) -> dict[str, Any]:
    """Write the card of what was fitted: a page that needs nothing else, and JSON beside it.

    Parameters
    ----------
    fit : TableFit, DynamicFit or MachineFit
    path : str or Path
        Of the page, ``.html``; the JSON has the same name and the ending ``.card.json``, since a model may be called ``.json``.
    source : str, optional
        Where the data came from, as the card is to name it; the name of their file if not given.
    max_boxes : int
        Sub-boxes per region that the proofs may take.
    shown : int
        Regions of a model, whose networks are drawn and written out.
    units : str
        Of the page: ``"metric"``, ``"field"`` or ``"si"``; columns in units of their own stay. The JSON has the units of the table.
    progress : Progress, optional
        Called as each model begins.

    Returns
    -------
    dict
        What the JSON holds.

    Raises
    ------
    InputError
        Another ending, or a place that cannot be written.
    """
    path, source = card_ending(path), fit.source if source is None else source
    if isinstance(fit, MachineFit):
        entries, seen = machine_facts(fit, units)
    else:
        entries, seen = {}, _coverage_of(_inputs(fit.models), shown_table(fit.table, units))
    data, sections = _data(fit.models, fit.table, source), []
    facts: list[dict[str, Any]] = []
    outputs: Sequence[OutputFit | DynamicOutputFit] = fit.outputs
    for found in outputs:
        progress(f"card: {found.model.output.name}, proofs and pictures", len(facts), len(outputs))
        facts.append(_facts(found.model, max_boxes))
        read, told = found.shown(units), _shown_facts(facts[-1], found.model, units)
        sections.append(
            _section(read, told, shown) if isinstance(read, OutputFit) else _dynamic_section(read, told, shown)
        )
    doubts = _doubts(fit)
    card: dict[str, Any] = {"schema": SCHEMA, "data": data | entries, "models": facts, "warnings": doubts}
    body = f"""{"".join(f"<p><strong>Warning:</strong> {escape(doubt)}.</p>" for doubt in doubts)}
<h2>Data</h2>
{_columns(data, units)}
{seen}
{_said_of_units(fit.models, units)}
{"".join(sections)}"""
    numbers = json.dumps(card, indent=1, allow_nan=False) + "\n"
    write_texts({path.with_suffix(".card.json"): numbers, path: document(f"Model card: {source}", body)})
    return card


def _doubts(fit: TableFit | DynamicFit | MachineFit) -> list[str]:
    """What makes the models doubtful; those of a machine say so themselves."""
    if isinstance(fit, MachineFit):
        return []
    return fit.doubts


def _inputs(models: Sequence[Model]) -> list[str]:
    """Columns that any of the models reads; of dynamic ones those that none of them predicts."""
    outputs = {model.output.name for model in models}
    read = [name for model in models for name in _signals(model)]
    return [name for name in dict.fromkeys(read) if name not in outputs]


def _signals(model: Model) -> list[str]:
    if model.dynamics is None:
        return [variable.name for variable in model.inputs]
    return [lag.signal for lag in model.dynamics.lags]


def _data(models: Sequence[Model], table: Table, source: str) -> dict[str, Any]:
    """Rows, columns with their ranges, how rows were held out."""
    names = [*_inputs(models), *(model.output.name for model in models)]
    columns = [
        {"name": name, "unit": table.unit(name), "low": float(table[name].min()), "high": float(table[name].max())}
        for name in names
    ]
    found: dict[str, Any] = {
        "source": source,
        "rows": len(table),
        "columns": columns,
        "held_out": models[0].training["held_out"],
    }
    if "time" in table.names:
        first, last = (float(end) + began(table) for end in (table["time"].min(), table["time"].max()))
        found["seconds"] = last - first
        if dated(first):
            found |= {"first": first, "last": last}  # s since 1970
    if "segment" in table.names:
        found["segments"] = len(np.unique(table["segment"]))
    return found


def _facts(model: Model, max_boxes: int) -> dict[str, Any]:
    """What is known of one model: errors, intervals, proved bounds, domain."""
    bounds = model_bounds(model, max_boxes=max_boxes)
    regions = [
        {"region": name, "proved_low": region.low, "proved_high": region.high}
        for name, region in zip(model.region_names(), bounds.regions, strict=True)
        if region is not None
    ]
    dynamics = model.dynamics
    memory = (
        {
            "lags": [[lag.signal, lag.steps] for lag in dynamics.lags],
            "largest_steps": list(dynamics.step),
            "raster": dynamics.raster,
        }
        if dynamics
        else {}
    )
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
        **memory,
    }


def _shown_facts(facts: dict[str, Any], model: Model, units: str) -> dict[str, Any]:
    """The facts of a model as its page shows them; what is proved is proved of the model itself."""
    read, unit = shown_model(model, units), model.output.unit
    names = dict(zip(model.region_names(), region_names(read), strict=True))

    def moved(entry: dict[str, Any]) -> dict[str, Any]:
        return entry | {key: as_shown(entry[key], unit, units) for key in ("proved_low", "proved_high")}

    found = moved(facts) | {
        "output": str(read.output),
        "domain": read.domain().tolist(),
        "regions": [moved(region) | {"region": names[region["region"]]} for region in facts["regions"]],
        "training": read.training,
    }
    return found | ({"largest_steps": list(read.dynamics.step)} if read.dynamics else {})


def _said_of_units(models: Sequence[Model], units: str) -> str:
    """That the page shows other units than the model file has, if so."""
    used = [variable.unit for model in models for variable in (*model.inputs, model.output)]
    changed = dict.fromkeys(f"{shown_unit(unit, units)} for {unit}" for unit in used if shown_unit(unit, units) != unit)
    told = f"Shown in {', '.join(changed)}; the model file and its exports work in the units of the table."
    return f"<p>{escape(told)}</p>" if changed else ""


def _section(found: OutputFit, facts: dict[str, Any], most: int) -> str:
    model, training = found.model, facts["training"]
    unit = escape(unit_after(model.output))
    widths = training["interval_half_widths"]
    interval = (
        f"{training['interval_level']:.0%} intervals of plus or minus {_span(widths)}{unit} hold for {found.covered:.1%} of the rows they were not set by"
        if widths
        else "too few rows were held out to state intervals"
    )
    regions = [
        [r["region"], str(r["rows"]), f"{r['rms']:.4g}", f"{r['largest']:.4g}"] for r in training["held_out_by_region"]
    ]
    proved = [[r["region"], f"{r['proved_low']:.4g}", f"{r['proved_high']:.4g}"] for r in facts["regions"]]
    return f"""<h2>{escape(facts["output"])}</h2>
<p>{facts["networks"]} network(s), {facts["coefficients"]} coefficients. On the rows held out ({escape(training["held_out"])}): R²
{found.r2:.5f}, rms error {found.rms:.4g}{unit}, largest {found.largest:.4g}{unit}; {interval}. Proved: no output leaves
{facts["proved_low"]:.6g} to {facts["proved_high"]:.6g}{unit}, whatever the inputs.</p>
{html_table("Errors on the rows held out", ["region", "rows", *_heads("rms", "largest", model=model)], regions)}
{_domain(model, facts)}
{html_table("Proved range by region", ["region", *_heads("low", "high", model=model)], proved)}
{_picture(_errors(found.model, found.held.y, found.held.predicted))}
{_what_it_is(model, most)}"""


def _span(widths: Sequence[float]) -> str:
    """Half widths of intervals in words."""
    low, high = (f"{end(widths):.4g}" for end in (min, max))
    return low if low == high else f"{low} to {high} by region"


def _dynamic_section(found: DynamicOutputFit, facts: dict[str, Any], most: int) -> str:
    model, unit = found.model, unit_after(found.model.output)
    rows = [
        [name, *(f"{value:.4g}" for kind in errors for value in kind)]
        for name, errors in {"this model": found.errors, **found.others}.items()
    ]
    heads = [
        f"{kind}: {what}"
        for kind in ("free run", "one step")
        for what in ("R2", *_heads("rms", "largest", model=model))
    ]
    low, high = facts["largest_steps"]
    runs, *others = remarks(found)
    told = [
        *others,
        f"rows {facts['raster']:g} s apart; from one to the next the output changes by {low:.4g} to {high:.4g}{unit} at most",
        f"proved: no answer leaves {facts['proved_low']:.6g} to {facts['proved_high']:.6g}{unit}, whatever the model reads; it "
        "does not follow that a run stays close to the truth",
    ]
    return f"""<h2>{escape(facts["output"])}</h2>
<ul>{"".join(f"<li>{escape(item)}</li>" for item in told)}</ul>
{html_table(f"Errors: {runs}; one step ahead in the same rows", ["model", *heads], rows)}
{_picture(plot_separately(model, found.held))}
<p>Free runs through the blocks held out, by a model that has not seen them: each starts from measured rows and then reads its own predictions.
Shaded: the intervals.</p>
{_picture(_errors(model, found.held.measured, found.held.free))}
{_domain(model, facts)}
{_what_it_is(model, most)}"""


def _domain(model: Model, facts: dict[str, Any]) -> str:
    rows = [[str(v), f"{low:.6g}", f"{high:.6g}"] for v, (low, high) in zip(model.inputs, facts["domain"], strict=True)]
    return html_table("Domain: inputs outside are moved to its border", ["input", "low", "high"], rows)


def _what_it_is(model: Model, most: int) -> str:
    drawn = min(len(model.networks), most)
    more = "" if drawn == len(model.networks) else f"<p>The first {drawn} of {len(model.networks)} regions.</p>"
    text = to_text(model) if len(model.networks) <= most else "See the model file: more regions than fit here."
    return f"""<h3>What it is</h3>
{more}{_picture(_networks(model, drawn))}
<pre>{escape(text)}</pre>"""


def _heads(*names: str, model: Model) -> list[str]:
    """Names of errors with the output's unit."""
    return [str(Variable(name, model.output.unit)) for name in names]


def _columns(data: dict[str, Any], units: str) -> str:
    rows = [
        [
            c["name"],
            shown_unit(c["unit"], units),
            *(f"{as_shown(c[end], c['unit'], units):.6g}" for end in ("low", "high")),
        ]
        for c in data["columns"]
    ]
    spans = "".join(
        f", {data[key]:.6g} {word}" for key, word in (("seconds", "s"), ("segments", "segment(s)")) if key in data
    )
    days = f", {moment(data['first'])} to {moment(data['last'])}" if "first" in data else ""
    caption = f"{data['source']}: {data['rows']} rows{spans}{days}; held out: {data['held_out']}"
    return html_table(caption, ["column", "unit", "low", "high"], rows)


def _coverage_of(inputs: Sequence[str], table: Table) -> str:
    shown = inputs[:_PAIRED]
    of = "inputs" if len(shown) == len(inputs) else f"the first {len(shown)} of {len(inputs)} inputs"
    pairs = f"Where the rows lie, for every pair of {of}: the brighter, the more rows, white where nothing was seen."
    return f"""{_picture(_coverage(shown, table))}
<p>{pairs if len(inputs) > 1 else "How many rows lie where."}</p>"""


def _coverage(names: Sequence[str], table: Table) -> Any:
    """Histograms of all pairs of inputs, or of the one there is."""
    from matplotlib.figure import Figure

    n = max(len(names) - 1, 1)
    figure = Figure(figsize=(3.0 * n, 2.6 * n), layout="constrained")
    axes = figure.subplots(n, n, squeeze=False)
    for row in range(n):
        for column in range(n):
            axis = axes[row, column]
            if len(names) == 1:
                axis.hist(table[names[0]], bins=_BINS)
                axis.set_xlabel(as_drawn(with_unit(names[0], table.unit(names[0]))))
                axis.set_ylabel("rows")
            elif column > row:
                axis.set_axis_off()
            else:
                x, y = table[names[column]], table[names[row + 1]]
                counts, xs, ys = np.histogram2d(x, y, bins=_BINS)
                axis.pcolormesh(
                    xs, ys, np.where(counts > 0.0, np.log10(np.maximum(counts, 1.0)), np.nan).T, rasterized=True
                )
                axis.set_xlabel(as_drawn(with_unit(names[column], table.unit(names[column]))), fontsize="small")
                axis.set_ylabel(as_drawn(with_unit(names[row + 1], table.unit(names[row + 1]))), fontsize="small")
    return figure


def _errors(model: Model, y: np.ndarray, predicted: np.ndarray) -> Any:
    """Predicted over measured, and the errors, of the rows held out."""
    from matplotlib.figure import Figure

    error = predicted - y
    figure = Figure(figsize=(8.0, 2.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(y, predicted, ",", rasterized=True)
    left.set_xlabel(as_drawn(f"measured {model.output}"))
    left.set_ylabel(as_drawn(f"predicted {model.output}"))
    right.hist(error, bins=60)
    right.set_xlabel(as_drawn(str(Variable("error", model.output.unit))))
    right.set_ylabel("rows")
    right.set_yscale("log")
    return figure


def _networks(model: Model, drawn: int) -> Any:
    from matplotlib.figure import Figure

    height = max(2.0, *(ROW * (1 + node_rows(network)) for network in model.networks[:drawn]))
    width = max(8.0, _PER_LAYER * (2 + max(max(layers_of(network)) for network in model.networks[:drawn])))
    figure = Figure(figsize=(width, height * drawn), layout="constrained")
    axes = figure.subplots(drawn, 1, squeeze=False)
    for axis, network, name in zip(axes[:, 0], model.networks, region_names(model), strict=False):
        draw_network(axis, network, model.inputs, model.output)
        axis.set_title(as_drawn(name), fontsize="small")
    return figure


def _picture(figure: Any) -> str:
    """A figure as an image inside the page."""
    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=120)
    return svg_image(stream.getvalue())
