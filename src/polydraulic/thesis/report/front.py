"""The report's first page: three numbers, the pictures that carry them, then the tables and where everything is."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from polydraulic.pages.html import document
from polydraulic.thesis.beyond import N_OPERATORS, OPERATOR_SECONDS
from polydraulic.thesis.report.catalog import Chapter, Number, Paragraph
from polydraulic.thesis.report.page import THESIS, Shown, figure_html, navigation, paragraphs, results_table
from polydraulic.thesis.timing import PAIRS

Values = Mapping[str, dict[str, Any]]  # rows of results.json by id

# The pictures, and what each has to do with the story; shown as far as their chapters were made.
STORY = (
    ("5-T1", "The task: swing and lift, reach, dump, swing back. Grey: the linkage at the ends of these four phases; coloured: the "
             "paths of the end-effector with the exact valve flows and with networks in their place; dots: where it ends."),
    ("5-37", "What the networks have to supply in every time step: the flows into swing and stick. Below, their errors: those of "
             "the thesis' setting are largest while both valves are open."),
    ("5-44", "What the flow errors do to the end-effector, with networks in the thesis' setting and with polydraulic's "
             "(the scales differ)."),
    ("7-1", ""),
    ("7-4", ""),
    ("7-3", ""),
)  # fmt: skip
WITH_PRINTED = (
    "database.Qi_mean_in3_s",
    "single.aim_maps.Qi_error_max_in3_s",
    "single.aim_v08.joint_displacement_error_max_deg",
    "sim.sine.end_effector_error_max_m",
    "sim.step.end_effector_error_max_m",
    "sim.pulse.end_effector_error_max_m",
    "sim.task.end_effector_error_max_m",
    "torque.task.end_effector_error_max_m",
    "table_1.reduction_percent",
    "table_4.rows.1.reduction_percent",
)
BEYOND = (
    "polydraulic.sim.sine.end_effector_error_max_m",
    "polydraulic.sim.step.end_effector_error_max_m",
    "polydraulic.sim.pulse.end_effector_error_max_m",
    "polydraulic.sim.task.end_effector_error_max_m",
    "polydraulic.torque.task.end_effector_error_max_m",
    "polydraulic.operators.p95_m",
    "polydraulic.measured.median_m",
    "polydraulic.identified.median_m",
    "polydraulic.diagnosis.clock_s",
    "polydraulic.time_of_a_step",
)
TERMS = (
    ("thesis", "A number printed in the thesis."),
    ("computed", "The same number, computed by this report. Every run of the report computes it from the parameters."),
    ("exact", "Flows from the closed-form solution of the valve circuit. All errors are differences between a run with some other flow "
              "model and the run with the exact flow, on the same machine with the same lever voltages."),
    ("thesis' setting", "Polynomial networks learnt here as the thesis describes: in given regions, grown until the predicted squared error "
                        "is smallest, not refined."),
    ("polydraulic", "Polynomial networks learnt with the method of this software. In chapter 4 from the same data in the same regions; from chapter 5 on "
                    "those that come with the package."),
    ("iterative", "The flow model that the thesis replaced: pump pressure and flows by repeated sweeps, to a relative bound eps."),
    ("end-effector error", "Distance between the tips of the stick in two runs."),
)  # fmt: skip


class Headline(NamedTuple):
    """A number of the first page.

    Attributes
    ----------
    title, value : str
    means, limits : str
        What the number says, and what it does not.
    """

    title: str
    value: str
    means: str
    limits: str


def front_page(chapters: Sequence[Chapter], figures: Mapping[str, Shown], rows: Sequence[dict[str, Any]]) -> str:
    """Three numbers, the pictures that carry them, then the tables, the terms and the chapters."""
    values = {row["id"]: row for row in rows}
    n_printed = sum(row["thesis"] is not None for row in rows)
    intro = [
        Paragraph(
            "A thesis of the 1990s simulated a Caterpillar 215B excavator and replaced the iterative calculation of its pump and main "
            "valve flows by polynomial abductive networks. This report repeats that study with polydraulic and continues it. "
            f"In its chapters {n_printed} printed numbers stand next to computed ones, with a note where they differ; this page has those "
            "that tell most."
        )
    ]
    pictures = "\n".join(figure_html(name, figures[name], see=see) for name, see in STORY if name in figures)
    body = f"""{paragraphs(intro)}
{_three(headlines(values))}
{f"<h2>The story in pictures</h2>{pictures}" if pictures else ""}
{_chosen("Numbers of the thesis, printed and computed", values, WITH_PRINTED)}
{_chosen("Numbers beyond the thesis", values, BEYOND)}
<h2>Terms</h2>
<dl>{"".join(f"<dt>{escape(term)}</dt><dd>{escape(meaning)}</dd>" for term, meaning in TERMS)}</dl>
<h2>The thesis repeated, chapter by chapter</h2>
{_contents([c for c in chapters if c.number in THESIS])}
<h2>Beyond the thesis, chapter by chapter</h2>
{_contents([c for c in chapters if c.number not in THESIS])}
<h2>Where the numbers come from</h2>
<p>The column &ldquo;made in&rdquo; names the file (in <code>polydraulic/thesis/report/chapters</code>) and the line of code that makes a number.
All numbers are in <a href="results.json">results.json</a>; the data of every figure are linked in its caption.</p>"""
    return document("Excavator flows from polynomial networks: a thesis repeated and continued", body, top=navigation(chapters, None))  # fmt: skip


def headlines(values: Values) -> list[Headline]:
    """The three numbers, as far as the chapters that they come from were made."""
    makers = (_task, _operators, _cost)
    return [found for make in makers if (found := make(values)) is not None]


def _task(values: Values) -> Headline | None:
    repeated, ours = (values.get(f"{where}sim.task.end_effector_error_max_m") for where in ("", "polydraulic."))
    if repeated is None or ours is None:
        return None
    return Headline(
        "Accuracy in the thesis' task",
        _mm(ours["computed"]),
        f"Largest end-effector error in 13 s of digging motion with polydraulic's networks. Networks in the thesis' setting reach "
        f"{_mm(repeated['computed'])} on the same machine; the thesis printed {_mm(repeated['thesis'])}.",
        "It is the difference from the exact solution of the same circuit, not from a real excavator. The thesis does not print its "
        "orifice areas; those used here are calibrated to its printed statistics, so that its own error can only be compared roughly.",
    )


def _operators(values: Values) -> Headline | None:
    names = ("p95_m", "median_m", "largest_m")
    found = [values.get(f"polydraulic.operators.{name}") for name in names]
    if any(row is None for row in found):
        return None
    p95, median, largest = (_mm(row["computed"]) for row in found if row is not None)
    return Headline(
        "Accuracy in work nobody trained for",
        p95,
        f"95 % of {N_OPERATORS} runs of {OPERATOR_SECONDS:g} s by random operators have a smaller end-effector error during the whole run. "
        f"Half of them stay below {median}; the largest error is {largest}.",
        "The operators are random signals over the whole range of motion, end stops included, not people at work, and the machine has "
        "exactly the parameters that the networks were trained for. Chapter 8 has networks learnt from sensor readings.",
    )


def _cost(values: Values) -> Headline | None:
    step, saved = values.get("polydraulic.time_of_a_step"), values.get("table_4.rows.1.reduction_percent")
    if step is None or saved is None:
        return None
    return Headline(
        "Cost of a time step",
        f"{step['computed']:.2f} × exact",
        "Computing time of a whole time step with polydraulic's networks, as a multiple of that with the exact closed-form flow; "
        f"measured on the computer that made this report in {PAIRS} pairs; {step['note']}.",
        f"Speed is not the reason to use networks. The thesis saved {saved['thesis']:.0f} % of its iteration's computing time; here, networks in the "
        f"thesis' setting {_saving(saved['computed'])}. Their use: they are learnt from measured flows, without knowing orifice areas.",
    )


def _saving(percent: float) -> str:
    return f"save {percent:.0f} %" if percent >= 0.0 else f"take {-percent:.0f} % more than the iteration"


def _mm(metres: Number) -> str:
    assert isinstance(metres, float)
    return f"{1e3 * metres:.2g} mm" if metres < 0.01 else f"{1e3 * metres:.0f} mm"


def _three(shown: Sequence[Headline]) -> str:
    boxes = "\n".join(
        f"<section><h3>{escape(h.title)}</h3><strong>{escape(h.value)}</strong>"
        f'<p>{escape(h.means)}</p><p class="note"><b>What it does not say.</b> {escape(h.limits)}</p></section>'
        for h in shown
    )
    return f'<div class="three">\n{boxes}\n</div>' if boxes else ""


def _chosen(title: str, values: Values, names: Sequence[str]) -> str:
    rows = [values[name] for name in names if name in values]
    return f"<h2>{escape(title)}</h2>\n{results_table(rows, thesis=rows[0]['thesis'] is not None)}" if rows else ""


def _contents(chapters: Sequence[Chapter]) -> str:
    items = "".join(
        f'<li><a href="chapter_{c.number}.html">Chapter {c.number}: {escape(c.title)}</a>. {escape(c.about)} '
        f"({len(c.figures)} figures)</li>"
        for c in chapters
    )
    return f"<ul>{items}</ul>" if items else "<p>Not made in this run.</p>"
