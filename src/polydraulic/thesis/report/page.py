"""The report's pages as HTML: the front page and one for each chapter; they need nothing but their folder."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from polydraulic.pages.html import document, table
from polydraulic.thesis.report.catalog import Chapter, Content, Number, results

# What the front page shows: numbers in this order, and the pictures that tell the story.
HEADLINES = (
    "database.Qi_mean_in3_s",
    "single.aim_maps.Qi_error_max_in3_s",
    "single.aim_v08.joint_displacement_error_max_deg",
    "sim.sine.end_effector_error_max_m",
    "ours.sim.sine.end_effector_error_max_m",
    "sim.step.end_effector_error_max_m",
    "ours.sim.step.end_effector_error_max_m",
    "sim.pulse.end_effector_error_max_m",
    "ours.sim.pulse.end_effector_error_max_m",
    "sim.task.end_effector_error_max_m",
    "ours.sim.task.end_effector_error_max_m",
    "torque.task.end_effector_error_max_m",
    "ours.torque.task.end_effector_error_max_m",
    "ours.operators.p95_m",
    "ours.measured.median_m",
    "table_1.reduction_percent",
    "table_4.rows.1.reduction_percent",
    "ours.time_of_a_step",
)
PICTURES = ("3-1", "5-9", "7-1", "7-3")


class Shown(NamedTuple):
    """A figure that has been drawn."""

    title: str
    see: str
    panels: list[str]


def front_page(chapters: Sequence[Chapter], figures: Mapping[str, Shown], rows: list[dict[str, Any]]) -> str:
    """Headline numbers, the pictures that tell the story, and where everything is."""
    by_id = {row["id"]: row for row in rows}
    headlines = [by_id[identity] for identity in HEADLINES if identity in by_id]
    printed = sum(row["thesis"] is not None for row in rows)
    links = "\n".join(
        f'<li><a href="chapter_{c.number}.html">Chapter {c.number}: {escape(c.title)}</a>'
        f" ({len(c.figures)} figures)</li>"
        for c in chapters
    )
    pictures = "\n".join(_figure(number, figures[number]) for number in PICTURES if number in figures)
    return document(
        "The thesis and this package, number by number",
        f"""<p>A thesis of the 1990s learnt the pump and main valves of a Caterpillar 215B excavator as polynomial abductive
networks. This report repeats its study with <em>polydraulic</em>, on a machine calibrated to its printed statistics, and
then shows what can be done today. {printed} printed numbers stand next to ours; where one cannot be met, its note says why.
The last column names the file and line that makes a number. Everything is in <a href="results.json">results.json</a>.</p>
<ul>
{links}
</ul>
<h2>Headlines</h2>
{_results_table(headlines)}
<h2>The story in pictures</h2>
{pictures}""",
    )


def chapter_page(chapter: Chapter, content: Content, figures: Mapping[str, Shown]) -> str:
    """One chapter: what was done, tables, every printed number, every figure."""
    tables = "\n".join(table(*grid) for grid in content.tables)
    rows = results(content)
    numbers = f"<h2>Every printed number next to ours</h2>\n{_results_table(rows)}" if rows else ""
    drawn = "\n".join(_figure(number, figure) for number, figure in figures.items())
    return document(
        f"Chapter {chapter.number}: {chapter.title}",
        f"""<p><a href="index.html">The report</a></p>
{content.text}
{tables}
{numbers}
<h2>Figures</h2>
{drawn}""",
    )


def _figure(number: str, figure: Shown) -> str:
    data = ", ".join(
        f'<a href="data/fig_{number}{panel}.csv">data{" " + panel if panel else ""}</a>' for panel in figure.panels
    )
    title = f"Fig {number}. {figure.title}"
    return f"""<figure id="fig-{number}"><img src="figures/{number}.svg" alt="{escape(title)}" loading="lazy">
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
            row["source"],
        ]
        for row in rows
    ]
    return table("", ["section", "quantity", "unit", "thesis", "ours", "note", "made in"], cells)


def _shown(value: Number) -> str:
    if isinstance(value, list):
        return ", ".join(
            " to ".join(f"{v:.4g}" for v in item) if isinstance(item, list) else f"{item:.4g}" for item in value
        )
    return f"{value:.4g}"
