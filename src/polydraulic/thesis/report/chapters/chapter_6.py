"""Chapter 6, pumps with a torque limit: what networks that never saw one do, and what networks do that did."""

from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.flow.database import PRESSURE_HIGH, boom_table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Chapter, Content, Figure, Grid, Ours, result
from polydraulic.thesis.report.differences import compared
from polydraulic.thesis.report.figures.chapter_5 import in_field, map_figure
from polydraulic.thesis.report.machine_runs import effector, effector_error, quantity_figure
from polydraulic.thesis.three_links import ThreeLinkStudy, three_link_study

_SMALLER = (
    "networks that never saw the limit, against the exact flow with it; in our runs the limit acts less, see above"
)
_TWICE = ("exact", "polynomial", "polynomial with limit")
_KINDS = ("polynomial", "polynomial with limit", "ours", "ours with limit")


def content(lab: Lab) -> Content:
    """Numbers of chapter 6."""
    study = three_link_study(lab)
    sine, task = (compared(study, name, limited=True) for name in ("sine", "task"))
    start = study.machine().pumps.torque_limit_start
    ours = {
        "torque.sine.threshold_psi": Ours(units.from_si(start, "psi")),
        "torque.sine.swing_flow_error_10p5s_in3_s": Ours(sine.largest("swing.q_in", 10.0, 11.0), _SMALLER),
        "torque.sine.stick_flow_error_10p5s_in3_s": Ours(sine.largest("stick.q_in", 10.0, 11.0), _SMALLER),
        "torque.sine.boom_error_13s_deg": Ours(sine.at("boom.angle", 13.0), _SMALLER),
        "torque.sine.swing_error_6p5s_deg": Ours(sine.at("swing.angle", 6.5), _SMALLER),
        "torque.sine.swing_error_13s_deg": Ours(sine.at("swing.angle", 13.0), _SMALLER),
        "torque.sine.stick_error_6p5s_deg": Ours(sine.at("stick.angle", 6.5), _SMALLER),
        "torque.sine.stick_error_13s_deg": Ours(sine.at("stick.angle", 13.0), _SMALLER),
        "torque.sine.end_effector_error_13s_m": Ours(sine.distance(13.0), _SMALLER),
        "torque.task.boom_error_13s_deg": Ours(task.at("boom.angle", 13.0), _SMALLER),
        "torque.task.swing_error_7s_deg": Ours(task.at("swing.angle", 7.0), _SMALLER),
        "torque.task.stick_error_7s_deg": Ours(task.at("stick.angle", 7.0), _SMALLER),
        "torque.task.stick_error_13s_deg": Ours(task.at("stick.angle", 13.0), _SMALLER),
        "torque.task.end_effector_error_max_m": Ours(task.largest_distance(), _SMALLER),
    }
    return Content(_text(study), ours, _extra(study), [_errors(study)])


def _extra(study: ThreeLinkStudy) -> list[dict[str, Any]]:
    sine, task = (compared(study, name, "ours with limit", limited=True) for name in ("sine", "task"))
    blind = compared(study, "task", "ours", limited=True)
    what = "networks of this package trained with the limit"
    return [
        result("ours.torque.sine.end_effector_error_13s_m", "6.2", f"torque-limited sine: end-effector error at 13 s, {what}",
               "m", sine.distance(13.0)),
        result("ours.torque.sine.end_effector_error_max_m", "6.2", f"torque-limited sine: largest end-effector error, {what}",
               "m", sine.largest_distance()),
        result("ours.torque.task.end_effector_error_max_m", "6.3", f"torque-limited task: largest end-effector error, {what}",
               "m", task.largest_distance()),
        result("ours.torque.task.blind_error_max_m", "6.3",
               "torque-limited task: largest end-effector error, networks of this package that never saw the limit",
               "m", blind.largest_distance()),
    ]  # fmt: skip


def _errors(study: ThreeLinkStudy) -> Grid:
    rows = []
    for name, printed in (("sine", "547 (at 13 s)"), ("task", "539")):
        found = [compared(study, name, kind, limited=True) for kind in _KINDS]
        rows.append(
            [name, printed, *(f"{1e3 * c.largest_distance():.1f} ({1e3 * c.distance(13.0):.1f})" for c in found)]
        )
    header = [
        "run",
        "thesis",
        "historical setting, without the limit",
        "historical setting, with it",
        "this package, without it",
        "this package, with it",
    ]
    return Grid(
        "Largest end-effector error (and that at 13 s) against exact on the torque-limited machine, mm", header, rows
    )


def limited_map(lab: Lab) -> Figure:
    """Fig 6-1: boom input flow of a torque-limited pump."""
    machine = three_link_study(lab).machine(limited=True)
    n = 101
    travel, pressure = (
        grid.ravel()
        for grid in np.meshgrid(np.linspace(0.0, machine.spool.knots[-1], n), np.linspace(0.0, PRESSURE_HIGH, n))
    )
    q = boom_table(machine, travel, pressure, pressure, relief=False)["boom.q_in"]
    table = in_field(
        {"boom.travel": (travel, "in"), "boom.p_in": (pressure, "psi"), "boom.q_in": (q, "in3/s")},
    )
    see = "Above 2000 psi at the pump its flow falls with the pressure: the plateau of Fig 4-8 slopes."
    return map_figure("Boom input flow of a torque-limited pump", see, [("input flow", table)], error=False)


def _text(study: ThreeLinkStudy) -> str:
    pumps = study.machine().pumps
    start, exponent = units.from_si(pumps.torque_limit_start, "psi"), pumps.torque_limit_exponent
    return f"""<p>A pump with a torque limit delivers less above {start:.0f} psi: Q = Q_0 (P_s / P)^n with n = {exponent:g}, which is
    constant power. The machine is simulated with that limit; the networks of chapter 5 go on answering for constant flow,
    and others are trained, in the same way, on circuits that have it.</p>
    <p>The thesis found that its errors at least doubled and named the reason: the training data did not know the limit. In our
    runs the limit acts less: pumps reach {_highest(study, "sine"):.0f} psi in the sine and {_highest(study, "task"):.0f} psi in the task,
    mostly the boom's. The table shows what not knowing costs, and what is left once the limit is known. In the thesis' setting, one
    network a section, knowing it helps the boom and hurts the stick, whose network of section B has to follow one more kink; with a
    network for each mode of the pump the remedy works (Figs 6-R1, 6-R2).</p>"""


def _highest(study: ThreeLinkStudy, scenario: str) -> float:
    """Highest pump pressure of a torque-limited run in psi."""
    run = study.run(scenario, "exact", limited=True)
    return units.from_si(float(max(run["boom.p_pump"].max(), run["series.p_pump"].max())), "psi")


_SINE, _TASK = "Torque-limited sine", "Torque-limited task"
_LINKS = ("boom", "swing", "stick")

CHAPTER = Chapter(
    6,
    "Effect of non-constant pump flow",
    content,
    {
        "6-1": limited_map,
        "6-2": quantity_figure("sine", "q_in", f"{_SINE}: input flows",
                        "Swing and stick stay below the limit in our sine; networks that know it err no less there.",
                        _TWICE, limited=True),
        "6-3": quantity_figure("sine", "angle", f"{_SINE}: joint displacements",
                        "The boom's pump is above its limit: networks that do not know it lift the boom too far.", _TWICE, links=_LINKS, limited=True),
        "6-4": quantity_figure("sine", "rate", f"{_SINE}: joint velocities",
                        "Without the limit in its training data the boom moves a little too fast while the limit acts.", _TWICE, links=_LINKS, limited=True),
        "6-5": effector("sine", f"{_SINE}: end-effector (printed as Fig 7-5)", "Where it is.", _TWICE, limited=True),
        "6-6": effector_error("sine", f"{_SINE}: end-effector error (printed as Fig 7-6)",
                              "Left and right: the thesis' setting without and with the limit in its training data.",
                              ("polynomial", "polynomial with limit"), limited=True),
        "6-7": quantity_figure("task", "q_in", f"{_TASK}: input flows",
                        "Networks that know the limit err more while the stick works alone: one a section has to follow the limit's kink, too.", _TWICE, limited=True),
        "6-8": quantity_figure("task", "angle", f"{_TASK}: joint displacements",
                        "The boom gains from knowing the limit; the stick loses more, in section B.", _TWICE, links=_LINKS, limited=True),
        "6-9": quantity_figure("task", "rate", f"{_TASK}: joint velocities",
                        "From 3 to 7 s the stick is too slow with the network that knows the limit.", _TWICE, links=_LINKS, limited=True),
        "6-10": effector("task", f"{_TASK}: end-effector", "Where it is.", _TWICE, limited=True),
        "6-11": effector_error("task", f"{_TASK}: end-effector error",
                               "Left and right: the thesis' setting without and with the limit in its training data.",
                               ("polynomial", "polynomial with limit"), limited=True),
        "6-R1": effector_error("sine", f"{_SINE}: end-effector error, networks of this package",
                               "Left without, right with the limit in the training data: that is the remedy.",
                               ("ours", "ours with limit"), limited=True),
        "6-R2": effector_error("task", f"{_TASK}: end-effector error, networks of this package",
                               "Left without, right with the limit in the training data: that is the remedy.",
                               ("ours", "ours with limit"), limited=True),
    },
)  # fmt: skip
