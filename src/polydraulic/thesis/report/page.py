"""The report's chapter pages as HTML, and what the first page shares with them; they need nothing but their folder."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple
from urllib.parse import quote

from polydraulic.pages.html import Cell, document, table
from polydraulic.thesis.report.catalog import Chapter, Content, Number, Paragraph, results

THESIS = (3, 4, 5, 6)  # chapters that repeat the thesis; the others go beyond it


class Shown(NamedTuple):
    """A figure that has been drawn.

    Attributes
    ----------
    title, see : str
    panels : list of str
        Names of its tables of data; a single one has none.
    width : float
        In inches.
    """

    title: str
    see: str
    panels: list[str]
    width: float


def data_name(number: str, panel: str) -> str:
    """File of a panel's data, in the folder ``data``."""
    return f"fig_{number}{panel if len(panel) < 2 else '_' + panel.replace(' ', '_')}.csv"


def navigation(chapters: Sequence[Chapter], here: int | None) -> str:
    """Links to all pages; the one that is `here` is none."""
    first = "<b>Report</b>" if here is None else '<a href="index.html">Report</a>'
    rest = (
        f"<b>{c.number} {escape(c.title)}</b>"
        if c.number == here
        else f'<a href="chapter_{c.number}.html">{c.number} {escape(c.title)}</a>'
        for c in chapters
    )
    return f"<nav>{first} {' '.join(rest)}</nav>\n"


def chapter_page(chapter: Chapter, chapters: Sequence[Chapter], content: Content, figures: Mapping[str, Shown]) -> str:
    """One chapter: what was done, its tables, its numbers, its figures."""
    rows = results(content)
    tables = "\n".join(table(*grid) for grid in content.tables)
    drawn = "\n".join(figure_html(number, figure) for number, figure in figures.items())
    heading = "" if chapter.number in THESIS else "Beyond the thesis: "
    body = f"""{paragraphs(content.text)}
<h2>Figures in this chapter</h2>
{figure_list(figures)}
{f"<h2>Tables</h2>{tables}" if tables else ""}
{numbers_html(rows)}
<h2>Figures</h2>
{drawn}"""
    return document(
        f"{heading}Chapter {chapter.number}: {chapter.title}", body, top=navigation(chapters, chapter.number)
    )


def paragraphs(text: Sequence[Paragraph]) -> str:
    """Paragraphs, each with its lead in bold."""
    return "\n".join(f"<p>{f'<b>{escape(p.lead)}</b> ' if p.lead else ''}{escape(p.text)}</p>" for p in text)


def figure_list(figures: Mapping[str, Shown]) -> str:
    """Links to the figures of a page."""
    items = (f'<li><a href="#fig-{n}">Fig {n}</a> {escape(figure.title)}</li>' for n, figure in figures.items())
    return f'<ul class="figures">{"".join(items)}</ul>'


def figure_html(number: str, figure: Shown, *, see: str = "") -> str:
    """A figure with its caption and links to its data; `see` replaces what the chapter says of it."""
    data = ", ".join(
        f'<a href="data/{quote(data_name(number, panel))}">data{" " + escape(panel) if panel else ""}</a>'
        for panel in figure.panels
    )
    title, picture = f"Fig {number}. {figure.title}", f"figures/{number}.svg"
    return f"""<figure id="fig-{number}"><div class="scroll" style="--width:{figure.width:.2f}in">
<a href="{picture}"><img src="{picture}" alt="{escape(title)}"></a></div>
<figcaption><b>{escape(title)}.</b> {escape(see or figure.see)} ({data})</figcaption></figure>"""


def numbers_html(rows: Sequence[dict[str, Any]]) -> str:
    """Numbers of the thesis with the computed ones beside them; then those that the thesis does not have."""
    printed, others = ([row for row in rows if (row["thesis"] is None) is alone] for alone in (False, True))
    found = ""
    if printed:
        found += f"<h2>Every printed number and the computed one</h2>\n{results_table(printed)}\n"
    if others:
        found += (
            f"<h2>{'Further computed' if printed else 'Computed'} numbers</h2>\n{results_table(others, thesis=False)}\n"
        )
    return found


def results_table(rows: Sequence[dict[str, Any]], *, thesis: bool = True) -> str:
    """Rows of ``results.json`` as a table, with or without the thesis' values."""
    notes = any(row["note"] for row in rows)
    header = ["quantity", *(["thesis"] if thesis else []), "computed", "unit", *(["note"] if notes else []), "section", "made in"]  # fmt: skip
    cells: list[list[str | Cell]] = []
    for row in rows:
        values = [_value(row[key]) for key in (("thesis", "computed") if thesis else ("computed",))]
        unit = "" if row["unit"] == "1" else row["unit"]
        made_in = Cell(row["source"].rpartition("/")[2], "small")
        cells.append([row["quantity"], *values, unit, *([row["note"]] if notes else []), row["section"], made_in])
    return table("", header, cells)


def _value(value: Number) -> Cell:
    """A number, a list of numbers or a list of ranges with four digits."""
    if isinstance(value, list):
        return Cell(
            ", ".join(" to ".join(map(_digits, item)) if isinstance(item, list) else _digits(item) for item in value)
        )
    return Cell(_digits(value), "number")


def _digits(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"
