"""Chapter 7, beyond the thesis: the best networks, what each idea brings, every flow model, random operators, limits."""

from typing import Any

from polydraulic.thesis.beyond import (
    BY_OPERATORS,
    FLOWS,
    N_OPERATORS,
    Rung,
    ablation,
    costs,
    map_errors,
    operator_errors,
    output_ranges,
    tip_errors,
)
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Chapter, Content, Grid, Paragraph, printed_mm, result
from polydraulic.thesis.report.differences import compared
from polydraulic.thesis.report.figures.chapter_7 import FIGURES
from polydraulic.thesis.report.figures.draw import name_of
from polydraulic.thesis.three_links import SCENARIOS, ThreeLinkStudy, three_link_study
from polydraulic.thesis.timing import PAIRED

_PROVED = "input flows: proved, see the last table"
_BOUNDS = {
    "exact": "0 to the pump's flow, in closed form",
    "iterative": "by clamps; where it does not converge, flows do not add up to the pump's",
    "stiff": "not negative; flows and volume changes add up to the pump's flow",
    "tlm": "not negative",
    "lookup": "between the smallest and largest entry of its tables",
} | dict.fromkeys(("polynomial", "ours", "fine", "direct", "neural"), _PROVED)
_NEEDS = dict.fromkeys(FLOWS, "flows at the ports") | dict.fromkeys(("exact", "iterative"), "orifice areas")
_NEEDS |= dict.fromkeys(("stiff", "tlm"), "orifice areas, volumes") | {
    "lookup": "flows at the ports on a complete grid"
}


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    study = three_link_study(lab)
    return Content(
        _text(study), {}, _numbers(study), [_goals(study), _ideas(study), _flow_models(study), _operators(study), _ranges(study)]
    )  # fmt: skip


def _at(errors: list[float], share: float) -> float:
    """Error below which a share of the runs stays; of rising errors."""
    return errors[min(int(share * len(errors)), len(errors) - 1)]


def _numbers(study: ThreeLinkStudy) -> list[dict[str, Any]]:
    maps, operators, cost = map_errors(study), operator_errors(study)["ours"], costs(study)
    with_relief = "at random points, edges and corners included, with relief valves"
    return [
        result("polydraulic.maps.boom_error_max_in3_s", "7", f"boom input flow: largest error {with_relief}", "in3/s", maps["boom"].largest),
        result("polydraulic.maps.D_swing_error_max_in3_s", "7", f"swing input flow in section D: largest error {with_relief}", "in3/s", maps["swing in D"].largest),
        result("polydraulic.maps.D_stick_error_max_in3_s", "7", f"stick input flow in section D: largest error {with_relief}", "in3/s", maps["stick in D"].largest),
        result("polydraulic.operators.median_m", "7", f"{N_OPERATORS} runs of 60 s by random operators: half of the largest end-effector errors are below", "m", _at(operators, 0.5)),
        result("polydraulic.operators.p95_m", "7", f"{N_OPERATORS} runs of 60 s by random operators: 95 % of the largest end-effector errors are below", "m", _at(operators, 0.95)),
        result("polydraulic.operators.largest_m", "7", f"{N_OPERATORS} runs of 60 s by random operators: largest end-effector error of all", "m", operators[-1]),
        result("polydraulic.time_of_a_step", "7", "time per step of the simulation with polydraulic's networks, as a multiple of that with the exact flow", "1", cost["ours"].time.median, f"median and quartiles: {cost['ours'].time}"),
    ]  # fmt: skip


def _goals(study: ThreeLinkStudy) -> Grid:
    """Errors: printed, in the thesis' setting, and of polydraulic's networks."""
    tips, maps, operators = tip_errors(study), map_errors(study), operator_errors(study)
    fine = map_errors(study, "fine")
    limited = {name: compared(study, name, "ours with limit", limited=True) for name in ("sine", "task")}
    historical = {name: compared(study, name, "polynomial", limited=True) for name in ("sine", "task")}
    rows = [
        [f"end-effector error, {name}, largest [mm]", printed_mm(f"sim.{name}.end_effector_error_max_m"),
         f"{1e3 * tips['polynomial'][name]:.0f}", f"{1e3 * tips['ours'][name]:.1f}",
         f"{1e3 * tips['fine'][name]:.1f}"]
        for name in SCENARIOS
    ]  # fmt: skip
    rows += [
        ["torque-limited sine, at 13 s [mm]", printed_mm("torque.sine.end_effector_error_13s_m"), f"{1e3 * historical['sine'].distance(13.0):.0f}", f"{1e3 * limited['sine'].distance(13.0):.1f}", "–"],
        ["torque-limited sine, largest [mm]", "–", f"{1e3 * historical['sine'].largest_distance():.0f}", f"{1e3 * limited['sine'].largest_distance():.1f}", "–"],
        ["torque-limited task, largest [mm]", printed_mm("torque.task.end_effector_error_max_m"), f"{1e3 * historical['task'].largest_distance():.0f}", f"{1e3 * limited['task'].largest_distance():.1f}", "–"],
        ["boom input flow, largest map error [in3/s]", "6.85", "see chapter 4", f"{maps['boom'].largest:.2f}", f"{fine['boom'].largest:.2f}"],
        ["section D, swing / stick, largest map error [in3/s]", "about 15 / 60", "see chapter 5", f"{maps['swing in D'].largest:.1f} / {maps['stick in D'].largest:.1f}", f"{fine['swing in D'].largest:.1f} / {fine['stick in D'].largest:.1f}"],
        [f"{N_OPERATORS} runs of 60 s by random operators, 95 % of the largest errors are below [mm]", "–", f"{1e3 * _at(operators['polynomial'], 0.95):.0f}", f"{1e3 * _at(operators['ours'], 0.95):.0f}", f"{1e3 * _at(operators['fine'], 0.95):.0f}"],
    ]  # fmt: skip
    worse = fine["swing in D"].largest > maps["swing in D"].largest
    return Grid(
        "Errors against the exact flow: printed, repeated in the thesis' setting, and with polydraulic's networks"
        + worse
        * "; the finer ones were kept for their rms over the map, and err by more at its worst point, where the stick's inlet just opens",
        ["quantity", "thesis", "thesis' setting", "polydraulic", "polydraulic, finer"],
        rows,
    )


def _ideas(study: ThreeLinkStudy) -> Grid:
    rows = [
        [
            idea,
            str(rung.coefficients),
            f"{rung.swing[0]:.2f} / {rung.swing[1]:.1f}",
            f"{rung.stick[0]:.2f} / {rung.stick[1]:.1f}",
            *(f"{1e3 * rung.tip[name]:.0f}" for name in SCENARIOS),
        ]
        for idea, rung in ablation(study).items()
    ]
    header = [
        "setting",
        "coefficients",
        "swing, rms / largest [in3/s]",
        "stick, rms / largest [in3/s]",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    return Grid(
        f"What each step of the method contributes: map errors in section D and largest end-effector errors{_prior_alone(ablation(study))}",
        header,
        rows,
    )


def _prior_alone(rungs: dict[str, Rung]) -> str:
    """Which runs the adaptive prior makes worse where nothing else is added to it, as the end of a caption."""
    (_, first), (name, second) = list(rungs.items())[:2]
    worse = [
        f"{run} ({1e3 * first.tip[run]:.0f} to {1e3 * second.tip[run]:.0f} mm)"
        for run in SCENARIOS
        if second.tip[run] > first.tip[run]
    ]
    return f"; the {name.removeprefix('+ ')} alone makes {' and '.join(worse)} worse" if worse else ""


def _flow_models(study: ThreeLinkStudy) -> Grid:
    cost, tips = costs(study), tip_errors(study)
    rows = [
        [
            name_of(kind),
            *(f"{1e3 * tips[kind][name]:.1f}" for name in SCENARIOS),
            str(cost[kind].time),
            f"{cost[kind].memory / 1024.0:.0f}",
            _NEEDS[kind],
            _BOUNDS[kind],
        ]
        for kind in FLOWS
    ]
    header = [
        "flow model",
        *(f"{name} [mm]" for name in SCENARIOS),
        "time / exact (quartiles)",
        "memory [KiB]",
        "needs",
        "bounds of its flows",
    ]
    return Grid(f"Every flow model: largest end-effector errors, time of a whole step against exact ({PAIRED}), memory, bounds", header, rows)  # fmt: skip


def _operators(study: ThreeLinkStudy) -> Grid:
    found = operator_errors(study)
    rows = [
        [
            name_of(kind),
            *(f"{1e3 * _at(found[kind], share):.0f}" for share in (0.5, 0.95)),
            f"{1e3 * found[kind][-1]:.0f}",
        ]
        for kind in BY_OPERATORS
    ]
    header = ["flow model", "50 % of the runs below [mm]", "95 % below [mm]", "largest [mm]"]
    return Grid(f"Largest end-effector errors in {N_OPERATORS} runs of 60 s by random operators", header, rows)


def _ranges(study: ThreeLinkStudy) -> Grid:
    rows = [
        [*_named(name), *(f"{low:.4g} to {high:.4g}" for low, high in (found.proved, found.unclamped))]
        for name, found in output_ranges(study).items()
    ]
    header = ["networks", "output", "proved range [in3/s]", "at random points, without the output limits [in3/s]"]
    return Grid("Range of the input-flow networks over their whole domain of inputs", header, rows)


def _named(name: str) -> tuple[str, str]:
    kind, output = name.split(" ")
    return name_of(kind), output.replace(".q_in", " input flow").replace("_", ", ")


def _text(study: ThreeLinkStudy) -> list[Paragraph]:
    cost = costs(study)
    return [
        Paragraph(
            "The networks that come with the package differ from the thesis' in four ways. The regions of the inputs are searched for, "
            "instead of given by the sections of Table 3. There is one network for each operating mode of the pump (constant flow, open relief "
            "valve, torque limit), and the smallest answer counts. All coefficients of a network are refined together. The stick's "
            "network reads the flow that the swing leaves (a cascade; without it, in the arrangement called direct, it reads both valves). "
            "They were trained on points of the exact circuit, more of them where a network had large errors. No run shown below "
            "was used for training or for any choice.",
            "What was done.",
        ),
        Paragraph(
            "The first five rows learn from the same points in the sections of Table 3. To the thesis' setting are added, one after the other: "
            "an error prior estimated from the residuals (adaptive prior); removal of terms that do not reduce the predicted error (carving); "
            "refinement of all coefficients together; the choice of the network's depth by the leave-one-out error. The last three rows have "
            "regions that were searched for and a network for each pump mode, then the cascade, and then the finer networks, which have borders at every "
            "knot of the orifice tables and more regions (flow model polynomial-fine).",
            "How to read the table of steps.",
        ),
        Paragraph(
            "Not in speed: in compiled code the closed form of the circuit is exact, needs no training and costs about as much as networks that "
            f"come close to it. A time step with polydraulic's networks takes {cost['ours'].time.median:.2f} times as long as with the closed form "
            f"(with the small networks of the thesis' setting {cost['polynomial'].time.median:.2f} times); the iteration that the thesis replaced is "
            f"fast where it converges. With a lookup table of {cost['lookup'].memory / 1e6:.1f} MB, filled from the exact flow, it takes "
            f"{cost['lookup'].time.median:.2f} times as long, and "
            "the table is more accurate than the networks where no relief valve opens. Without limits on its output a polynomial leaves the physical range, and by far, at "
            "corners of its domain (last table): nobody should use one without them.",
            "Where polynomial networks do not pay.",
        ),
        Paragraph(
            "Orifice areas need not be known: networks are learnt from flows, pressures and spool positions that can be measured, at "
            "scattered points, where a lookup table of four inputs needs a complete grid. Their output range is proved over the whole "
            "domain. The number of operations per step is bounded. "
            f"Their {cost['ours'].memory / 1024.0:.0f} KiB of coefficients can be exported as C.",
            "Where they do.",
        ),
    ]


CHAPTER = Chapter(
    7,
    "Better networks, and where they pay",
    "polydraulic's networks against the thesis' setting and against every other flow model; random operators; where networks do not pay.",
    content,
    FIGURES,
)
