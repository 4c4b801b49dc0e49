"""The quality report of an imported log: what is wrong with it and what it can tell; as a page and as JSON."""

import json
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

from polydraulic.display import DEFAULT, moment, readable
from polydraulic.files import write_texts
from polydraulic.measure.checks.channel_check import ChannelCheck, value_in
from polydraulic.measure.checks.coverage import Coverage, coverage
from polydraulic.measure.checks.deadband import Deadband, find_deadbands
from polydraulic.measure.findings import SHOWN, Finding
from polydraulic.measure.flows import flow_statement, rate_statement
from polydraulic.measure.importing import Imported, missing_in_words
from polydraulic.pages.html import Cell, bullets, document, table
from polydraulic.unit_table import ATMOSPHERE
from polydraulic.units import Conversion

SCHEMA = 1


class Told(NamedTuple):
    """What a log can tell: coverage of its inputs, and deadbands."""

    coverage: Coverage | None
    deadbands: list[Deadband]


def what_it_tells(imported: Imported) -> Told:
    """Coverage and deadbands of the inputs, from the excerpt of the table."""
    table, channels = imported.excerpt, imported.channels
    inputs, outputs = channels.of_role("input"), channels.of_role("output")
    if not inputs or len(table) == 0:
        return Told(None, [])
    return Told(coverage(table, inputs), find_deadbands(table, inputs, outputs, channels.raster))


def write_quality(imported: Imported, path: str | Path, *, units: str = DEFAULT) -> Told:
    """Write the quality report: a page that needs nothing else, and JSON beside it.

    Parameters
    ----------
    imported : Imported
        From `import_log`.
    path : str or Path
        Of the page; the JSON has the same name and the ending ``.json``.
    units : str
        Of what is read: ``"metric"``, ``"field"`` or ``"si"``; kinds that a system has no unit for stay in that of the log.

    Returns
    -------
    Told
        What else the report says.

    Raises
    ------
    InputError
        A place that cannot be written.
    """
    told = what_it_tells(imported)
    path = Path(path)
    numbers = json.dumps(quality_data(imported, told, units=units), indent=1, allow_nan=False) + "\n"
    write_texts({path.with_suffix(".json"): numbers, path: _page(imported, told, units)})
    return told


def quality_data(imported: Imported, told: Told, *, units: str = DEFAULT) -> dict[str, Any]:
    """All that the report says as plain data; in SI, but statistics of channels in the unit of the log, which is given, and texts in `units`."""
    channels = imported.channels
    shown = imported.shown(units)
    return {
        "format": "polydraulic log quality",
        "schema": SCHEMA,
        "source": imported.source.name,
        "raster_s": channels.raster,
        "atmosphere_Pa": _atmosphere(imported),
        "span_s": list(imported.span),
        "rows": imported.n_row,
        "segments": imported.n_segment,
        "rows_missing": imported.missing,
        "rows_too_short_for_flows": imported.too_short,
        "findings": [
            {
                "kind": f.kind,
                "level": f.level,
                "channel": f.channel,
                "count": f.count,
                "rows": [list(span) for span in f.rows],
                "text": str(f),
            }
            for f in imported.findings
        ],
        "channels": [_statistics(check) for check in imported.checks],
        "flows": [flow_statement(flow, channels.raster) for flow in channels.flows],
        "rates": _rates(imported),
        "deadbands": [d._asdict() | {"text": d.statement(shown.get(d.input))} for d in told.deadbands],
        "coverage": None if told.coverage is None else _coverage_data(told.coverage, shown),
    }


def _rates(imported: Imported) -> list[str]:
    channels, units = imported.channels, imported.channels.made()
    return [rate_statement(rate, units[rate.name], channels.raster) for rate in channels.rates]


def _atmosphere(imported: Imported) -> float | None:
    """What was subtracted from absolute pressures, Pa; None if there are none."""
    given = imported.channels.atmosphere
    absolute = any(check.conversion.absolute for check in imported.checks)
    return None if not absolute else ATMOSPHERE if given is None else given


def _partial(imported: Imported) -> str:
    if imported.missing is None:
        return ""
    return f"; it is partial, rows without a value of a channel: {escape(missing_in_words(imported.missing))}"


def _pressures(imported: Imported) -> str:
    taken = _atmosphere(imported)
    if taken is None:
        return ""
    whose = "the standard atmosphere" if imported.channels.atmosphere is None else "as the map says"
    return f"The table has gauge pressures: {taken / 1e5:.6g} bar were subtracted from absolute ones ({whose}). "


def _statistics(check: ChannelCheck) -> dict[str, Any]:
    c, n = check.channel, check.count
    return {
        "source": c.source,
        "name": c.name,
        "role": c.role,
        "unit": c.unit,
        "raster_s": check.raster if check.raster == check.raster else None,
        "values": n,
        "low": check.low if n else None,
        "high": check.high if n else None,
        "mean": check.mean if n else None,
        "deviation": (check.square / n) ** 0.5 if n else None,
    }


def _coverage_data(found: Coverage, units: dict[str, Conversion]) -> dict[str, Any]:
    return {
        "box": {name: list(ends) for name, ends in found.box.items()},
        "cells_visited": found.visited,
        "cells": found.cells,
        "pairs": [
            {"x": p.x, "y": p.y, "share": p.share, "holes": [h._asdict() for h in p.holes], "counts": p.counts.tolist()}
            for p in found.pairs
        ],
        "holes": found.statements(units),
    }


def _page(imported: Imported, told: Told, units: str) -> str:
    from polydraulic.measure.quality_plots import coverage_svg, signals_svg

    findings = list(imported.findings)
    errors = sum(f.level == "error" for f in findings)
    verdict = (
        '<p class="good">Nothing was found that is wrong with this log.</p>'
        if not findings
        else f'<p class="{"error" if errors else "warning"}">{errors} error(s), {len(findings) - errors} warning(s).</p>'
    )
    first, last = imported.span
    shown, read = imported.shown(units), len(imported.excerpt)
    whole = "all rows" if read == imported.n_row else f"{read} of {imported.n_row} rows, from all over the log"
    deadbands = bullets([d.statement(shown.get(d.input)) for d in told.deadbands])
    flows = bullets([flow_statement(flow, imported.channels.raster) for flow in imported.channels.flows])
    body = f"""{verdict}
<p>{last - first:.4g} s of log, from {moment(first + imported.began)} to {moment(last + imported.began)}. The table has {imported.n_row} rows every {imported.channels.raster:g} s in
{imported.n_segment} segment(s) without a gap{_partial(imported)}.</p>
<h2>What was found</h2>
{_findings(findings)}
<h2>Channels</h2>
{_channels(imported.checks, shown)}
<p class="note">{_pressures(imported)}Smallest and largest value over time; red lines are the plausible range where it is near.</p>
{signals_svg(imported.checks, shown, imported.began)}
<h2>What it can tell</h2>
<p class="note">From {whole}.</p>
<h3>Deadbands</h3>
{deadbands or "<p>No output that is a rate, a flow or a position is explained by an input well enough to look for one.</p>"}
<h3>Reconstructed flows</h3>
{flows or "<p>None asked for.</p>"}
<h3>Rates by differentiation</h3>
{bullets(_rates(imported)) or "<p>None asked for.</p>"}
<h3>Coverage of the inputs</h3>
{_coverage(told.coverage, shown)}
{coverage_svg(told.coverage, shown) if told.coverage is not None and told.coverage.pairs else ""}"""
    return document(f"Quality of {imported.source.name}", body)


def _findings(findings: list[Finding]) -> str:
    rows: list[list[str | Cell]] = []
    for f in findings:
        spans = ", ".join(str(a) if a == b else f"{a} to {b}" for a, b in f.rows)
        more = ", ..." if len(f.rows) == SHOWN else ""
        kind, count = Cell(f.kind, f.level), Cell(str(f.count or ""), "number")
        rows.append([kind, f.channel or "log", count, spans + more, str(f).partition(": ")[2]])
    return table("", ["what", "channel", "rows", "which", "meaning"], rows) if rows else "<p>Nothing.</p>"


def _channels(checks: list[ChannelCheck], units: dict[str, Conversion]) -> str:
    names = (
        "source",
        "unit in the log",
        "column",
        "role",
        "every [s]",
        "values",
        "smallest",
        "mean",
        "largest",
        "deviation",
        "unit",
    )
    rows: list[list[str | Cell]] = []
    for check in checks:
        s, unit = _statistics(check), units[check.channel.name]
        low, mean, high = (None if s[key] is None else value_in(check, unit, s[key]) for key in ("low", "mean", "high"))
        deviation = (
            None if s["deviation"] is None else value_in(check, unit, s["deviation"]) - value_in(check, unit, 0.0)
        )
        numbers = (s["raster_s"], s["values"], low, mean, high, deviation)
        texts = (str(s[key]) for key in ("source", "unit", "name", "role"))
        rows.append([*texts, *(Cell(_number(value), "number") for value in numbers), unit.unit])
    return table("", names, rows)


def _coverage(found: Coverage | None, units: dict[str, Conversion]) -> str:
    if found is None:
        return "<p>There are no inputs, or no rows.</p>"
    text = (
        f"<p>{found.visited} of {found.cells} cells of the box of all inputs (four levels each) hold a row. The box is the "
        "range that each input has in the table.</p>"
    )
    return text + (bullets(found.statements(units)[:15]) or "<p>No holes in the maps of two inputs.</p>")


def _number(value: Any) -> str:
    return "–" if value is None else (str(value) if isinstance(value, int) else readable(value, 5))
