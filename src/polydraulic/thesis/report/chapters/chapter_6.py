"""Chapter 6, pumps with a torque limit: what networks that never saw one do, and what networks do that did."""

from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import PRESSURE_HIGH, boom_table, pump_of, spool_of
from polydraulic.thesis.report.catalog import Chapter, Computed, Content, Figure, Grid, Paragraph, printed_mm, result
from polydraulic.thesis.report.differences import compared
from polydraulic.thesis.report.figures.chapter_5 import in_field, map_figure
from polydraulic.thesis.report.figures.machine_runs import effector, effector_error, quantity_figure
from polydraulic.thesis.three_links import ThreeLinkStudy, three_link_study

_SMALLER = "networks trained without the limit, against the exact flow with it; the limit acts less than in the thesis, see above"
_TWICE = ("exact", "polynomial", "polynomial with limit")
_KINDS = ("polynomial", "polynomial with limit", "ours", "ours with limit")


def content(lab: Lab) -> Content:
    """Numbers of chapter 6."""
    study = three_link_study(lab)
    sine, task = (compared(study, name, limited=True) for name in ("sine", "task"))
    start = pump_of(study.machine(), "boom").torque_limit_start
    computed = {
        "torque.sine.threshold_psi": Computed(units.from_si(start, "psi")),
        "torque.sine.swing_flow_error_10p5s_in3_s": Computed(sine.largest("swing.q_in", 10.0, 11.0), _SMALLER),
        "torque.sine.stick_flow_error_10p5s_in3_s": Computed(sine.largest("stick.q_in", 10.0, 11.0), _SMALLER),
        "torque.sine.boom_error_13s_deg": Computed(sine.at("boom.angle", 13.0), _SMALLER),
        "torque.sine.swing_error_6p5s_deg": Computed(sine.at("swing.angle", 6.5), _SMALLER),
        "torque.sine.swing_error_13s_deg": Computed(sine.at("swing.angle", 13.0), _SMALLER),
        "torque.sine.stick_error_6p5s_deg": Computed(sine.at("stick.angle", 6.5), _SMALLER),
        "torque.sine.stick_error_13s_deg": Computed(sine.at("stick.angle", 13.0), _SMALLER),
        "torque.sine.end_effector_error_13s_m": Computed(sine.distance(13.0), _SMALLER),
        "torque.task.boom_error_13s_deg": Computed(task.at("boom.angle", 13.0), _SMALLER),
        "torque.task.swing_error_7s_deg": Computed(task.at("swing.angle", 7.0), _SMALLER),
        "torque.task.stick_error_7s_deg": Computed(task.at("stick.angle", 7.0), _SMALLER),
        "torque.task.stick_error_13s_deg": Computed(task.at("stick.angle", 13.0), _SMALLER),
        "torque.task.end_effector_error_max_m": Computed(task.largest_distance(), _SMALLER),
    }
    return Content(_text(study), computed, _extra(study), [_errors(study)])


def _extra(study: ThreeLinkStudy) -> list[dict[str, Any]]:
    sine, task = (compared(study, name, "ours with limit", limited=True) for name in ("sine", "task"))
    blind = compared(study, "task", "ours", limited=True)
    what = "polydraulic's networks, trained with the limit"
    return [
        result("polydraulic.torque.sine.end_effector_error_13s_m", "6.2", f"torque-limited sine: end-effector error at 13 s, {what}",
               "m", sine.distance(13.0)),
        result("polydraulic.torque.sine.end_effector_error_max_m", "6.2", f"torque-limited sine: largest end-effector error, {what}",
               "m", sine.largest_distance()),
        result("polydraulic.torque.task.end_effector_error_max_m", "6.3", f"torque-limited task: largest end-effector error, {what}",
               "m", task.largest_distance()),
        result("polydraulic.torque.task.blind_error_max_m", "6.3",
               "torque-limited task: largest end-effector error, polydraulic's networks, trained without the limit",
               "m", blind.largest_distance()),
    ]  # fmt: skip


def _errors(study: ThreeLinkStudy) -> Grid:
    rows = []
    sine, task = (
        printed_mm(f"torque.{name}") for name in ("sine.end_effector_error_13s_m", "task.end_effector_error_max_m")
    )
    for name, printed in (("sine", f"({sine})"), ("task", task)):
        found = [compared(study, name, kind, limited=True) for kind in _KINDS]
        rows.append(
            [name, printed, *(f"{1e3 * c.largest_distance():.1f} ({1e3 * c.distance(13.0):.1f})" for c in found)]
        )
    header = [
        "run",
        "thesis",
        "thesis' setting, trained without the limit",
        "thesis' setting, with",
        "polydraulic, without",
        "polydraulic, with",
    ]
    return Grid("Largest end-effector error (in brackets: at 13 s) on the torque-limited machine, mm", header, rows)


def limited_map(lab: Lab) -> Figure:
    """Fig 6-1: boom input flow of a torque-limited pump."""
    machine = three_link_study(lab).machine(limited=True)
    n = 101
    travel, pressure = (
        grid.ravel()
        for grid in np.meshgrid(np.linspace(0.0, spool_of(machine).end, n), np.linspace(0.0, PRESSURE_HIGH, n))
    )
    q = boom_table(machine, travel, pressure, pressure, relief=False)["boom.q_in"]
    table = in_field(
        {"boom.travel": (travel, "in"), "boom.p_in": (pressure, "psi"), "boom.q_in": (q, "in3/s")},
    )
    see = (
        "Above a pump pressure of 2000 psi the pump flow falls with the pressure: what is a plateau in Fig 4-8 slopes."
    )
    return map_figure("Boom input flow of a torque-limited pump", see, [("input flow", table)], error=False)


def _text(study: ThreeLinkStudy) -> list[Paragraph]:
    pump = pump_of(study.machine(), "boom")
    start, exponent = units.from_si(pump.torque_limit_start, "psi"), pump.torque_limit_exponent
    return [
        Paragraph(
            f"A pump with a torque limit delivers less flow above {start:.0f} psi: Q = Q_0 (P_s / P)^n with n = {exponent:g}; n = 1 is "
            "constant power. The machine is simulated with this limit, once with the networks of chapter 5, which were trained at "
            "constant pump flow, and once with networks trained in the same way on circuits that have the limit.",
            "What was done.",
        ),
        Paragraph(
            "The thesis found that the errors at least doubled, and named the reason: the training data did not contain the limit. "
            f"Here the limit acts less: the highest pump pressure is {_highest(study, 'sine'):.0f} psi in the sine and "
            f"{_highest(study, 'task'):.0f} psi in the task, mostly at the boom's pump.",
            "What differs.",
        ),
        Paragraph(
            "The table shows the error of networks trained without the limit and what remains if they are trained with it. In the thesis' "
            "setting, with one network per section, training with the limit improves the boom and worsens the stick, whose network of "
            "section B has to represent one more kink. With one network per operating mode of the pump, as in polydraulic, training with "
            "the limit works (Figs 6-R1, 6-R2).",
            "The remedy.",
        ),
    ]


def _highest(study: ThreeLinkStudy, scenario: str) -> float:
    """Highest pump pressure of a torque-limited run in psi."""
    run = study.run(scenario, "exact", limited=True)
    return units.from_si(float(max(run["boom.p_pump"].max(), run["series.p_pump"].max())), "psi")


_SINE, _TASK = "Torque-limited sine", "Torque-limited task"
_LINKS = ("boom", "swing", "stick")

CHAPTER = Chapter(
    6,
    "Effect of non-constant pump flow",
    "Pumps with a torque limit: the error of networks that were trained without it, and of networks trained with it.",
    content,
    {
        "6-1": limited_map,
        "6-2": quantity_figure("sine", "q_in", f"{_SINE}: input flows",
                        "In this sine the pump of swing and stick stays below the limit, and training with the limit does not reduce the error.",
                        _TWICE, limited=True),
        "6-3": quantity_figure("sine", "angle", f"{_SINE}: joint displacements",
                        "The boom's pump is above the limit: networks trained without the limit lift the boom too far.", _TWICE, links=_LINKS, limited=True),
        "6-4": quantity_figure("sine", "rate", f"{_SINE}: joint velocities",
                        "While the limit acts, the boom is slightly too fast with networks trained without it.", _TWICE, links=_LINKS, limited=True),
        "6-5": effector("sine", f"{_SINE}: end-effector (printed as Fig 7-5)", "Position of the end-effector.", _TWICE, limited=True),
        "6-6": effector_error("sine", f"{_SINE}: end-effector error (printed as Fig 7-6)",
                              "Thesis' setting. Left: trained without the limit; right: with it.",
                              ("polynomial", "polynomial with limit"), limited=True),
        "6-7": quantity_figure("task", "q_in", f"{_TASK}: input flows",
                        "While the stick works alone, errors are larger with the limit in the training data: the one network of the section has to represent one more kink.", _TWICE, limited=True),
        "6-8": quantity_figure("task", "angle", f"{_TASK}: joint displacements",
                        "With the limit in the training data the boom's error is smaller, but the stick's is larger by more, in section B.", _TWICE, links=_LINKS, limited=True),
        "6-9": quantity_figure("task", "rate", f"{_TASK}: joint velocities",
                        "From 3 to 7 s the stick is too slow with the network trained with the limit.", _TWICE, links=_LINKS, limited=True),
        "6-10": effector("task", f"{_TASK}: end-effector", "Position of the end-effector.", _TWICE, limited=True),
        "6-11": effector_error("task", f"{_TASK}: end-effector error",
                               "Thesis' setting. Left: trained without the limit; right: with it.",
                               ("polynomial", "polynomial with limit"), limited=True),
        "6-R1": effector_error("sine", f"{_SINE}: end-effector error, polydraulic's networks",
                               "Left: trained without the limit; right: with it. Training with the limit removes most of the error.",
                               ("ours", "ours with limit"), limited=True),
        "6-R2": effector_error("task", f"{_TASK}: end-effector error, polydraulic's networks",
                               "Left: trained without the limit; right: with it. Training with the limit removes most of the error.",
                               ("ours", "ours with limit"), limited=True),
    },
)  # fmt: skip
