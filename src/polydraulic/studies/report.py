"""The report: chapters -> one self-contained HTML page, ``results.json``, and every figure's data as CSV."""

import base64
import io
import json
from collections.abc import Callable, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.files import write_text
from polydraulic.parameters import Machine
from polydraulic.studies.catalog import Chapter, Figure, Number, results
from polydraulic.studies.single_link import STAGES, boom_study
from polydraulic.studies.single_link_chapters import chapter_3, chapter_4
from polydraulic.tables import write_table

CHAPTERS = {3: chapter_3, 4: chapter_4}
STEPS = (*STAGES, "draw", "write")
HEADLINES = (
    "database.Qi_mean_in3_s",
    "database.Qi_spread",
    "single.aim_maps.Qi_error_max_in3_s",
    "single.aim_v08.joint_displacement_error_max_deg",
    "single.aim_v05.joint_displacement_error_max_deg",
    "table_1.reduction_percent",
)


def write_report(
    machine: Machine,
    folder: Path,
    *,
    chapters: Sequence[int] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> list[dict[str, Any]]:
    """Compute the chapters and write ``index.html``, ``results.json`` and ``data/*.csv``.

    Parameters
    ----------
    machine : Machine
    folder : Path
    chapters : sequence of int, optional
        All if not given.
    progress : function of str
        Called with each of `STEPS` as it begins.

    Returns
    -------
    list of dict
        The rows of ``results.json``.

    Raises
    ------
    InputError
        Unknown chapter, or a folder that cannot be written; the latter before anything is computed.
    """
    chosen = sorted(set(CHAPTERS if chapters is None else chapters))
    unknown = [number for number in chosen if number not in CHAPTERS]
    if unknown:
        raise InputError(f"no chapter {unknown[0]} in the report; choose from {sorted(CHAPTERS)}")
    write_text(folder / "data" / "README.txt", "Data of the figures in index.html; units in the headers.\n")
    study = boom_study(machine, progress)
    made = [CHAPTERS[number](study) for number in chosen]
    progress("draw")
    images = {figure.number: _svg(figure) for chapter in made for figure in chapter.figures}
    progress("write")
    rows = [row for chapter in made for row in results(chapter)]
    for chapter in made:
        for figure in chapter.figures:
            for panel, table in figure.data.items():
                write_table(table, folder / "data" / f"fig_{figure.number}{panel}.csv")
    write_text(folder / "results.json", json.dumps(rows, indent=1, allow_nan=False) + "\n")
    write_text(folder / "index.html", _page(made, images, rows))
    return rows


def _svg(figure: Figure) -> str:
    import matplotlib

    stream = io.StringIO()
    with matplotlib.rc_context({"svg.hashsalt": figure.number, "font.size": 9}):
        figure.draw().savefig(stream, format="svg", metadata={"Date": None}, dpi=150)
    return stream.getvalue()


def _page(chapters: list[Chapter], images: dict[str, str], rows: list[dict[str, Any]]) -> str:
    style = (files("polydraulic.studies") / "report.css").read_text(encoding="utf-8")
    headlines = [row for row in rows if row["id"] in HEADLINES]
    links = " · ".join(f'<a href="#chapter-{c.number}">Chapter {c.number}: {escape(c.title)}</a>' for c in chapters)
    body = "\n".join(_chapter(chapter, images, results(chapter)) for chapter in chapters)
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>polydraulic: the thesis and this package</title>
<meta name="viewport" content="width=device-width"><style>{style}</style></head><body>
<h1>The thesis and this package, number by number</h1>
<p>A thesis of the 1990s learnt the pump and main valves of a Caterpillar 215B excavator as polynomial abductive networks.
This report repeats its study of the boom with <em>polydraulic</em>: same nodes, same criterion, a machine calibrated to its
printed statistics. Where a printed number cannot be met, the note says why.</p>
<p>{links}</p>
<h2>Headlines</h2>
{_results_table(headlines)}
{body}
</body></html>
"""


def _chapter(chapter: Chapter, images: dict[str, str], rows: list[dict[str, Any]]) -> str:
    figures = "\n".join(_figure(figure, images[figure.number]) for figure in chapter.figures)
    tables = "\n".join(_table(title, header, cells) for title, header, cells in chapter.tables)
    return f"""<section id="chapter-{chapter.number}"><h2>Chapter {chapter.number}: {escape(chapter.title)}</h2>
{chapter.text}
{tables}
<h3>Every printed number next to ours</h3>
{_results_table(rows)}
<h3>Figures</h3>
{figures}</section>"""


def _figure(figure: Figure, svg: str) -> str:
    # As an image each drawing keeps its own ids; inlined, those of two drawings would clash.
    source = "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()
    data = ", ".join(
        f'<a href="data/fig_{figure.number}{panel}.csv">data{" " + panel if panel else ""}</a>' for panel in figure.data
    )
    title = f"Fig {figure.number}. {figure.title}"
    return f"""<figure id="fig-{figure.number}"><img src="{source}" alt="{escape(title)}">
<figcaption><strong>{escape(title)}.</strong> {escape(figure.see)} ({data})</figcaption></figure>"""


def _results_table(rows: list[dict[str, Any]]) -> str:
    cells = [
        [
            row["section"],
            row["quantity"],
            row["unit"],
            "–" if row["thesis"] is None else _shown(row["thesis"]),
            _shown(row["ours"]),
            row["note"],
        ]
        for row in rows
    ]
    return _table("", ["section", "quantity", "unit", "thesis", "ours", "note"], cells)


def _shown(value: Number) -> str:
    if isinstance(value, list):
        return ", ".join(
            " to ".join(f"{v:.4g}" for v in item) if isinstance(item, list) else f"{item:.4g}" for item in value
        )
    return f"{value:.4g}"


def _table(title: str, header: list[str], rows: list[list[str]]) -> str:
    caption = f"<caption>{escape(title)}</caption>" if title else ""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "\n".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"
