"""Chapter 8, from measurements: how much data of what quality buys what accuracy, the work that the thesis left."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.display import with_unit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table
from polydraulic.thesis.adaptation_study import SENSORS, torque_limit_study, worn_pump_study
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.measured import (
    JUDGE_SECONDS,
    JUDGES,
    SWEEPS,
    USUAL,
    Conditions,
    Outcome,
    conditions_in_words,
    outcomes,
)
from polydraulic.thesis.report.catalog import Chapter, Content, Figure, Grid, Paragraph, printed_mm, result
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.thesis.three_links import SCENARIOS

if TYPE_CHECKING:
    import matplotlib.figure

_PANELS = {
    "minutes": ("minutes", "operation", "min", 1.0),
    "noise": ("noise", "noise of all sensors", "% of range", 100.0),
    "stroke": ("stroke", "used share of the joystick travel", "%", 100.0),
    "dropout": ("dropout", "time in which each sensor is silent", "%", 100.0),
    "friction": ("friction", "joint friction, multiple of the machine's", "", 1.0),
    "friction without flow sensors": ("friction", "the same, without flow sensors", "", 1.0),
}

_ADAPTATION: dict[str, Callable[[LayoutMachine], Table]] = {
    "torque limit": torque_limit_study,
    "worn pumps": worn_pump_study,
}
_WORN = 10  # minute in which the pumps are worn most; after it they are new


def _all(lab: Lab) -> dict[Conditions, Outcome]:
    """Outcome of every condition, each once."""
    every = list(dict.fromkeys(c for sweep in SWEEPS.values() for c in sweep))
    return dict(zip(every, outcomes(lab, every), strict=True))


def content(lab: Lab) -> Content:
    """Numbers of this chapter."""
    found = _all(lab)
    usual = found[USUAL]
    changes = {name: _change(lab, name) for name in _ADAPTATION}
    rows = [
        [
            _named(c),
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
        "input-flow error of swing / boom / stick, rms [in3/s]",
        f"{len(JUDGES)} test runs of 60 s, median [mm]",
        "worst test run [mm]",
        *(f"{name} [mm]" for name in SCENARIOS),
    ]
    table = Grid(
        "Networks learnt from measurements: flow errors, and largest end-effector errors. The first row has the usual conditions; "
        "the others name what differs from them",
        header,
        rows,
    )
    return Content([*_text(found), _adaptation_text(changes)], {}, _numbers(usual, changes), [table])


def _named(conditions: Conditions) -> str:
    """What differs from the usual conditions."""
    usual = conditions_in_words(USUAL).split(", ")
    return ", ".join(word for word in conditions_in_words(conditions).split(", ") if word not in usual) or ", ".join(
        usual
    )


def _numbers(usual: Outcome, changes: dict[str, Table]) -> list[dict[str, Any]]:
    limit, worn = changes["torque limit"], changes["worn pumps"]
    judged = "median over test runs of the largest end-effector error"
    what = f"networks learnt from sensor readings ({conditions_in_words(USUAL)})"
    return [
        result("polydraulic.measured.median_m", "8", f"median of the largest end-effector errors of {len(JUDGES)} test runs, {what}", "m", usual.median),
        result("polydraulic.measured.worst_m", "8", f"worst of {len(JUDGES)} test runs, {what}", "m", usual.worst),
        result("polydraulic.measured.task_m", "8", f"task: largest end-effector error, {what}", "m", usual.scenarios["task"]),
        result("polydraulic.adaptation.limit_exact_m", "8", f"{judged}, torque limit learnt for 10 min from ideal sensors", "m", float(limit["tip.exact"][-1])),
        result("polydraulic.adaptation.worn_exact_m", "8", f"{judged}, pumps that lost 10 % of their flow, followed with ideal sensors", "m", float(worn["tip.exact"][_WORN])),
        result("polydraulic.adaptation.limit_real_m", "8", f"{judged}, torque limit learnt for 10 min from real sensors", "m", float(limit["tip.real"][-1])),
        result("polydraulic.adaptation.worn_real_m", "8", f"{judged}, pumps that lost 10 % of their flow, followed with real sensors", "m", float(worn["tip.real"][_WORN])),
    ]  # fmt: skip


def what_data_buy(lab: Lab) -> Figure:
    """End-effector error over amount and quality of the data."""
    data, known = {}, _all(lab)
    for name, (attribute, label, unit, scale) in _PANELS.items():
        found = [known[c] for c in SWEEPS[name]]
        data[name] = Table(
            {
                label: scale * np.array([float(getattr(c, attribute)) for c in SWEEPS[name]]),
                "median": 1e3 * np.array([o.median for o in found]),
                "worst": 1e3 * np.array([o.worst for o in found]),
            },
            {"median": "mm", "worst": "mm", **({label: unit} if unit else {})},
        )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, 3, width=12.0, height=2.8)
        for axis, table in zip(axes.ravel(), data.values(), strict=True):
            label = table.names[0]
            for column, style in (("median", "o-"), ("worst", "s--")):
                axis.semilogy(table[label], table[column], style, label=column)
            axis.axhline(
                float(printed_mm("sim.task.end_effector_error_max_m")), color="0.5", linestyle=":", label="thesis, task"
            )
            axis.set_xlabel(with_unit(label, table.unit(label)))
            axis.set_ylabel("end-effector error [mm]")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="small")
        return figure

    see = (
        f"Each panel varies one condition; the others are the usual ones: {conditions_in_words(USUAL)} (in the last panel also no flow sensors). Tested in runs by operators whose "
        "work the networks were not trained on. Dotted line: what the thesis reached in its task, with networks learnt from a simulation."
    )
    return Figure("Accuracy over amount and quality of the measured data", see, data, draw)


def _text(found: dict[Conditions, Outcome]) -> list[Paragraph]:
    usual, stiff = found[USUAL], found[USUAL._replace(friction=5.0)]
    free, blind = found[USUAL._replace(friction=0.0)], found[USUAL._replace(flow_sensors=False)]
    blind_free, blind_stiff = (found[USUAL._replace(flow_sensors=False, friction=friction)] for friction in (0.0, 5.0))
    inlets = found[USUAL._replace(outlet_sensors=False)]
    quiet, loud, deaf = (found[USUAL._replace(noise=noise)] for noise in (0.0, 0.01, 0.03))
    others = [found[c] for c in SWEEPS["operator"][1:]]

    def median(o: Outcome) -> str:
        return f"{1e3 * o.median:.0f} mm"

    def worst(o: Outcome) -> str:
        return f"{1e3 * o.worst:.0f} mm"

    rms, loud_rms = blind.flow_rms["swing"], blind_stiff.flow_rms["swing"]
    return [
        Paragraph(
            "The thesis learnt its networks from its own simulation. It left two questions to later work: how to derive the model from "
            "measurements, and how its accuracy depends on incomplete data. Here a random operator works on the exact machine, with friction, end stops "
            "and relief valves. Sensors with noise and dropouts read spool positions, port pressures and flows. Networks are learnt from "
            "these readings, the pumps' flow, the relief setting and the deadband, and from nothing else. They are then tested in runs of "
            f"{JUDGE_SECONDS:g} s by {len(JUDGES)} operators whose work they were not trained on.",
            "What was done.",
        ),
        Paragraph(
            f"Under the usual conditions ({conditions_in_words(USUAL)}), the end-effector stays within {median(usual)} of the exact run in half of the test runs and within "
            f"{worst(usual)} in all of them, over a minute without any correction; in the thesis' task within "
            f"{1e3 * usual.scenarios['task']:.0f} mm. Logs of other operators, as long and as good, lead to medians of "
            f"{' and '.join(median(o) for o in others)} (worst {' and '.join(worst(o) for o in others)}): smaller differences than "
            "these, such as the small steps in the figure, mean nothing.",
            "What can be expected.",
        ),
        Paragraph(
            "Coverage of the operating range first: networks learnt from operators who use only part of the joystick travel have errors of "
            "metres when others use all of it, even if the log is as long. Then flow sensors: flows reconstructed from joint angles omit the flow that "
            f"compresses the oil. Sensor noise: the median is {median(quiet)} without noise, {median(loud)} with noise of 1 % of the "
            f"range, {median(deaf)} with 3 %.",
            "What matters most.",
        ),
        Paragraph(
            "The joints of the machine on which the log is recorded, and on which the networks are tested, have no friction, that of "
            f"the parameter set, or five times as much. With flow sensors the medians are {median(free)}, {median(usual)} and {median(stiff)} (worst "
            f"{worst(free)}, {worst(usual)} and {worst(stiff)}): no trend, since the networks represent valves and pumps, and friction "
            "only changes the pressures at which these work. With flows from joint angles the medians are "
            f"{median(blind_free)}, {median(blind)} and {median(blind_stiff)}; the swing's flow error is {rms:.0f} in3/s rms with the usual "
            f"friction and {loud_rms:.0f} with five times as much. A joint that sticks needs pressure before it moves, and oil flow that only raises "
            "the pressure does not show in a joint angle.",
            "Friction.",
        ),
        Paragraph(
            "With sensors for the flows into the actuators only, the flows out of them follow from the ratio of the cylinder areas. "
            "The networks of the input flows are as good, those of the output flows are not: the median is "
            f"{median(inlets)}, the worst test run {worst(inlets)}.",
            "Missing sensors.",
        ),
        Paragraph(
            "The whole procedure with log files, a channel map and a quality report is described in docs/measured_logs.md; networks that "
            "adapt to a machine that changes, in docs/dynamic_models.md.",
        ),
    ]


def _change(lab: Lab, name: str) -> Table:
    """Errors of networks that follow one change of the machine."""

    def made() -> Table:
        lab.say(f"adaptation: {name}")
        return _ADAPTATION[name](lab.machine)

    return lab.computed.table(f"adaptation {name}", made)


def adaptation(lab: Lab) -> Figure:
    """Errors of networks that follow a machine which changes, over the minutes of operation."""
    data = {name: _change(lab, name) for name in _ADAPTATION}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.2)
        titles = (
            "(a) a torque limit that was not in the training data",
            f"(b) pumps that lose 10 % of their flow, replaced after {_WORN} min",
        )
        labels = {"fitted": "not adapted", "exact": "adapted, ideal sensors", "real": "adapted, real sensors"}
        for axis, table, title in zip(axes[0], data.values(), titles, strict=True):
            for (kind, label), color in zip(labels.items(), ("C3", "C0", "C1"), strict=True):
                axis.semilogy(table["minute"], 1e3 * table[f"tip.{kind}"], "o-", markersize=4, color=color, label=label)
                axis.semilogy(table["minute"], 1e3 * table[f"tip.worst_{kind}"], ":", color=color)
            axis.plot([], [], ":", color="0.3", label="worst test run of each")
            axis.set_xlabel("operation [min]")
            axis.set_ylabel("end-effector error [mm]")
            axis.set_title(title, fontsize="medium")
            axis.grid(alpha=0.3, which="both")
            axis.legend(fontsize="x-small")
        return figure

    see = (
        "The output layers of the adapted networks are updated from measurements, within limits; networks that are not adapted keep their error. "
        "Real sensors have noise, delays and times without signal. After the pumps are replaced, which is not announced, the networks need a few minutes."
    )
    return Figure("Networks that adapt to a machine that changes", see, data, draw)


def _adaptation_text(changes: dict[str, Table]) -> Paragraph:
    """What adaptation reaches with ideal and with real sensors."""
    limit, worn, real = changes["torque limit"], changes["worn pumps"], SENSORS["real"]

    def tip(table: Table, kind: str, minute: int) -> str:
        return f"{table[f'tip.{kind}'][minute]:.2f} m"

    last = len(limit) - 1
    return Paragraph(
        f"Networks that adapt to it learn from ideal sensors or from real ones (noise of {100.0 * real.noise:g} % of the range, "
        f"delays of {1e3 * real.delay:g} ms and, for flows, {1e3 * real.flow_delay:g} ms, silent {100.0 * real.dropout:g} % of the time). All values "
        "are medians over the test runs of the largest end-effector error. Torque limit that was not in the training data: "
        f"{tip(limit, 'fitted', 0)} before adaptation, {tip(limit, 'exact', last)} after {last} minutes with ideal sensors and "
        f"{tip(limit, 'real', last)} with real ones. Pumps that have lost 10 % of their flow: {tip(worn, 'fitted', _WORN)} without adaptation, "
        f"{tip(worn, 'exact', _WORN)} and {tip(worn, 'real', _WORN)} with it. One minute after the pumps were replaced: "
        f"{tip(worn, 'exact', _WORN + 1)} and {tip(worn, 'real', _WORN + 1)}; {len(worn) - 1 - _WORN} minutes after: "
        f"{tip(worn, 'exact', -1)} and {tip(worn, 'real', -1)}, where the networks as first learnt have {tip(worn, 'fitted', -1)}. "
        "Only a reset of the adapted networks restores that at once.",
        "A machine that changes.",
    )


CHAPTER = Chapter(
    8,
    "From measurements",
    "Networks learnt from sensor readings instead of a simulation: how much data of what quality is needed, and a machine that changes.",
    content,
    {"8-1": what_data_buy, "8-2": adaptation},
)
