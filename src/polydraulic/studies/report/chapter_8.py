"""Chapter 8, from measurements: how much data of what quality buys what accuracy, the work that the thesis left."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.parameters import LINKS, Machine
from polydraulic.studies.adaptation_study import torque_limit_study, worn_pump_study
from polydraulic.studies.cache import Lab
from polydraulic.studies.measured import JUDGES, SWEEPS, USUAL, Conditions, Outcome, describe, outcome
from polydraulic.studies.report.catalog import Chapter, Content, Figure, Grid, result
from polydraulic.studies.report.draw import canvas
from polydraulic.studies.three_links import SCENARIOS
from polydraulic.tables import Table

if TYPE_CHECKING:
    import matplotlib.figure

_THESIS = 0.347  # m, largest end-effector error of the printed task, with networks learnt from a simulation
_PANELS = {
    "minutes": ("minutes", "minutes of operation", 1.0),
    "noise": ("noise", "noise of all sensors [% of range]", 100.0),
    "stroke": ("stroke", "joystick travel that is used [%]", 100.0),
    "dropout": ("dropout", "silent time of each sensor [%]", 100.0),
}


def _all(lab: Lab) -> dict[Conditions, Outcome]:
    """Outcome of every condition, each once."""
    return {c: outcome(lab, c) for sweep in SWEEPS.values() for c in sweep}


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    found = _all(lab)
    usual = found[USUAL]
    rows = [
        [
            describe(c),
            str(o.rows),
            " / ".join(f"{o.flow_rms[link]:.1f}" for link in LINKS),
            f"{1e3 * o.median:.0f}",
            f"{1e3 * o.worst:.0f}",
            *(f"{1e3 * o.scenarios[name]:.0f}" for name in SCENARIOS),
        ]
        for c, o in found.items()
    ]
    header = [
        "conditions",
        "rows",
        "flow errors of swing / boom / stick, rms [in3/s]",
        f"{len(JUDGES)} operators of 60 s, median [mm]",
        "worst [mm]",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    table = Grid(
        "What networks learnt from measurements reach; largest end-effector errors against exact", header, rows
    )
    return Content(_text(usual), {}, _numbers(usual), [table])


def _numbers(usual: Outcome) -> list[dict[str, Any]]:
    what = f"learnt from sensors ({describe(USUAL)})"
    return [
        result("ours.measured.median_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} operators, {what}", "m", usual.median),
        result("ours.measured.worst_m", "8", f"worst of {len(JUDGES)} operators, {what}", "m", usual.worst),
        result("ours.measured.task_m", "8", f"task: largest end-effector error, {what}", "m", usual.scenarios["task"]),
    ]  # fmt: skip


def what_data_buy(lab: Lab) -> Figure:
    """End-effector error over amount and quality of the data."""
    data = {}
    for name, (attribute, label, scale) in _PANELS.items():
        outcomes = [outcome(lab, c) for c in SWEEPS[name]]
        data[name] = Table(
            {
                label: scale * np.array([float(getattr(c, attribute)) for c in SWEEPS[name]]),
                "median": 1e3 * np.array([o.median for o in outcomes]),
                "worst": 1e3 * np.array([o.worst for o in outcomes]),
            },
            {"median": "mm", "worst": "mm"},
        )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, 2, width=9.6, height=2.8)
        for axis, table in zip(axes.ravel(), data.values(), strict=True):
            label = table.names[0]
            for column, style in (("median", "o-"), ("worst", "s--")):
                axis.semilogy(table[label], table[column], style, label=column)
            axis.axhline(1e3 * _THESIS, color="0.5", linestyle=":", label="thesis, task")
            axis.set_xlabel(label)
            axis.set_ylabel("end-effector error [mm]")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="small")
        return figure

    see = (
        f"Each panel changes one thing of: {describe(USUAL)}. Judged by operators whom the networks never saw; the dotted line is "
        "what the thesis reached in its task with networks learnt from a simulation."
    )
    return Figure("How much data of what quality buys what accuracy", see, data, draw)


def _text(usual: Outcome) -> str:
    return f"""<p>The thesis learnt from its own simulation and left to others to derive the model from measurements, and to relate how
    incomplete the data are to how accurate the model is. Here a random operator works on the exact machine, friction, end stops and
    relief valves included; sensors with noise and dropouts read spools, port pressures and flows; networks are learnt from nothing
    else, on top of the pumps' flow, the relief setting and the deadband. They go into the machine and drive it with the voltages of
    operators whom they never saw.</p>
    <p><strong>What an engineer can take from it.</strong> {describe(USUAL)}: half of the operators stay within
    {1e3 * usual.median:.0f} mm and all of them within {1e3 * usual.worst:.0f} mm over a minute without any correction, the task within
    {1e3 * usual.scenarios["task"]:.0f} mm. What matters most is coverage: networks learnt from operators who hold back fail by metres
    when others use the whole joystick, in a log as long. Then flow sensors: flows reconstructed from joint angles leave out what the
    oil's compression takes. Noise of a third of a percent of the range costs little, one of one percent a lot.</p>
    <p>The whole path, with log files, a channel map and a quality report, is in the guide to measured logs
    (docs/measured_logs.md); networks that follow a machine which changes are in docs/dynamic_models.md.</p>"""


def adaptation(lab: Lab) -> Figure:
    """Errors of networks that follow a machine which changes, over the minutes of operation."""
    studies = {"torque limit": torque_limit_study, "worn pumps": worn_pump_study}
    data = {}
    for name, study in studies.items():

        def made(name: str = name, study: Callable[[Machine], Table] = study) -> Table:
            lab.say(f"adaptation: {name}")
            return study(lab.machine)

        data[name] = lab.computed.table(f"adaptation {name}", made)

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.0)
        titles = (
            "(a) a torque limit that the networks never saw",
            "(b) pumps that lose 10 %, and new ones after 10 min",
        )
        for axis, table, title in zip(axes[0], data.values(), titles, strict=True):
            for kind, color in (("fitted", "C3"), ("adapted", "C0")):
                axis.semilogy(table["minute"], 1e3 * table[f"tip.{kind}"], "o-", color=color, label=kind)
                axis.semilogy(
                    table["minute"], 1e3 * table[f"tip.worst_{kind}"], ":", color=color, label=f"{kind}, worst judge"
                )
            axis.set_xlabel("minutes of operation")
            axis.set_ylabel("end-effector error [mm]")
            axis.set_title(title, fontsize="medium")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="small")
        return figure

    see = (
        "The networks' output layers follow what is measured, within limits and with a way back; the fitted ones stay wrong. "
        "Replaced pumps, which nobody announces, cost a few minutes."
    )
    return Figure("Networks that follow a machine which changes", see, data, draw)


CHAPTER = Chapter(8, "From measurements", content, {"8-1": what_data_buy, "8-2": adaptation})
