"""Chapter 7, beyond the thesis: the best networks, what each idea brings, every flow model, random operators, limits."""

from typing import Any

from polydraulic.thesis.beyond import (
    BY_OPERATORS,
    FLOWS,
    N_OPERATORS,
    ablation,
    costs,
    map_errors,
    operator_errors,
    output_ranges,
    tip_errors,
)
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Chapter, Content, Grid, result
from polydraulic.thesis.report.differences import compared
from polydraulic.thesis.report.figures.chapter_7 import FIGURES, PRINTED_TIP, name_of
from polydraulic.thesis.three_links import SCENARIOS, ThreeLinkStudy, three_link_study
from polydraulic.thesis.timing import TURNED

_PROVED = "input flows proved, see the last table"
_BOUNDS = {
    "exact": "in closed form: 0 to the pump's flow",
    "iterative": "by clamps; where its sweeps do not settle the balance is off",
    "stiff": "not negative; the pump's flow goes into flows and volumes",
    "tlm": "not negative",
    "lookup": "between the entries of its tables",
} | dict.fromkeys(("polynomial", "ours", "direct", "neural"), _PROVED)
_NEEDS = dict.fromkeys(FLOWS, "flows at the ports") | dict.fromkeys(("exact", "iterative"), "orifice areas")
_NEEDS |= dict.fromkeys(("stiff", "tlm"), "orifice areas, volumes") | {"lookup": "flows at the ports on a whole grid"}


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
    with_relief = "random points with faces and corners, relief valves included"
    return [
        result("ours.maps.boom_error_max_in3_s", "7", f"boom input flow: largest error, {with_relief}", "in3/s", maps["boom"].largest),
        result("ours.maps.D_swing_error_max_in3_s", "7", f"swing input flow in section D: largest error, {with_relief}", "in3/s", maps["swing in D"].largest),
        result("ours.maps.D_stick_error_max_in3_s", "7", f"stick input flow in section D: largest error, {with_relief}", "in3/s", maps["stick in D"].largest),
        result("ours.operators.median_m", "7", f"{N_OPERATORS} random operators of 60 s: median of the largest end-effector errors", "m", _at(operators, 0.5)),
        result("ours.operators.p95_m", "7", f"{N_OPERATORS} random operators of 60 s: 95 % of the largest end-effector errors", "m", _at(operators, 0.95)),
        result("ours.operators.largest_m", "7", f"{N_OPERATORS} random operators of 60 s: largest of them all", "m", operators[-1]),
        result("ours.time_of_a_step", "7", "time of a step with this package's networks, as a share of that with the exact flow", "1", cost["ours"].time.median),
    ]  # fmt: skip


def _goals(study: ThreeLinkStudy) -> Grid:
    """Thesis, what was asked for at least, the goal, and what was reached."""
    tips, maps, operators = tip_errors(study), map_errors(study), operator_errors(study)
    limited = {name: compared(study, name, "ours with limit", limited=True) for name in ("sine", "task")}
    historical = {name: compared(study, name, "polynomial", limited=True) for name in ("sine", "task")}
    rows = [
        [f"end-effector error, {name}, largest [mm]", f"{1e3 * PRINTED_TIP[name]:.0f}",
         f"{1e3 * tips['polynomial'][name]:.0f}", f"{1e3 * tips['ours'][name]:.1f}"]
        for name in SCENARIOS
    ]  # fmt: skip
    rows += [
        ["torque-limited sine, at 13 s [mm]", "547", f"{1e3 * historical['sine'].distance(13.0):.0f}", f"{1e3 * limited['sine'].distance(13.0):.1f}"],
        ["torque-limited sine, largest [mm]", "–", f"{1e3 * historical['sine'].largest_distance():.0f}", f"{1e3 * limited['sine'].largest_distance():.1f}"],
        ["torque-limited task, largest [mm]", "539", f"{1e3 * historical['task'].largest_distance():.0f}", f"{1e3 * limited['task'].largest_distance():.1f}"],
        ["boom input flow, largest map error [in3/s]", "6.85", "chapter 4", f"{maps['boom'].largest:.2f}"],
        ["section D, swing / stick, largest map error [in3/s]", "about 15 / 60", "chapter 5", f"{maps['swing in D'].largest:.1f} / {maps['stick in D'].largest:.1f}"],
        [f"{N_OPERATORS} random operators of 60 s, 95 % of the largest errors [mm]", "–", f"{1e3 * _at(operators['polynomial'], 0.95):.0f}", f"{1e3 * _at(operators['ours'], 0.95):.0f}"],
    ]  # fmt: skip
    return Grid(
        "Against the exact flow: printed, reproduced with the thesis' setting, and this package's networks",
        ["", "thesis", "thesis' setting", "this package"],
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
        "",
        "coefficients",
        "swing in D, rms / largest [in3/s]",
        "stick in D",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    return Grid(
        "What each idea brings: five settings on the sections of Table 3 and the same points; then regions found, a network for each mode of the pump, and the cascade",
        header,
        rows,
    )


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
        "time of exact (quartiles)",
        "tables [KiB]",
        "needs",
        "flows bounded",
    ]
    return Grid(f"Every flow model: end-effector errors, time of a whole step ({TURNED}), memory, bounds", header, rows)  # fmt: skip


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
    header = ["flow model", "median [mm]", "95 % [mm]", "largest [mm]"]
    return Grid(f"Largest end-effector errors of {N_OPERATORS} random operators of 60 s", header, rows)


def _ranges(study: ThreeLinkStudy) -> Grid:
    rows = [
        [*_named(name), *(f"{low:.4g} to {high:.4g}" for low, high in (found.proved, found.unclamped))]
        for name, found in output_ranges(study).items()
    ]
    header = ["networks", "output", "proved [in3/s]", "at random points, without the final clamp [in3/s]"]
    return Grid("Ranges of the input-flow networks over their whole domains", header, rows)


def _named(name: str) -> tuple[str, str]:
    kind, output = name.split(" ")
    return name_of(kind), output


def _text(study: ThreeLinkStudy) -> str:
    cost = costs(study)
    return f"""<p>The networks that come with the package: regions found where the map bends; a network for each mode of the pump
    (constant flow, open relief valve, torque limit), of which the least counts; coefficients refined together; the stick's
    network fed by what the swing leaves. They were trained on points of the circuit, by a search that asks for more of them where a
    network errs; no run below took part in training or in any choice.</p>
    <p><strong>Where polynomial networks do not pay.</strong> In speed: in compiled code the closed form of the circuit is exact,
    needs no training and costs less than networks that come close to it (a step with them takes {cost["ours"].time.median:.2f} of a step
    with it; with small ones, in the thesis' setting, {cost["polynomial"].time.median:.2f}); the iteration that the thesis replaced costs
    less still where it converges. A lookup table of {cost["lookup"].memory / 1e6:.1f} MB, filled from the exact flow, is faster, and
    closer where no relief valve opens. Without its clamps a polynomial leaves the physical range at corners of its domain (last
    table), so that nobody should use one without them.</p>
    <p><strong>Where they do.</strong> No orifice areas: a network is learnt from flows, pressures and spool positions that can be
    measured, at scattered points, which no lookup table of four inputs can be. Proved bounds over the whole domain. A bounded
    number of operations a step. {cost["ours"].memory / 1024.0:.0f} KiB of tables that leave Python as C.</p>"""


CHAPTER = Chapter(7, "Beyond the thesis", content, FIGURES)
