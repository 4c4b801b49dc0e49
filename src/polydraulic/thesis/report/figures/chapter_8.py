"""Figures of chapter 8: what data buy, what sensors buy, networks that follow a machine which changes."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import with_unit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table
from polydraulic.thesis.adaptation_study import torque_limit_study, worn_pump_study
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.measured.conditions import SWEEPS, USUAL, Conditions, conditions_in_words
from polydraulic.thesis.measured.study import Outcome, outcomes
from polydraulic.thesis.report.catalog import Figure, printed_mm
from polydraulic.thesis.report.figures.draw import canvas

if TYPE_CHECKING:
    import matplotlib.figure

WORN = 10  # minute in which the pumps are worn most; after it they are new
WAYS = {"networks": "C0", "identified": "C2"}
_PANELS = {
    "minutes": ("minutes", "operation", "min", 1.0),
    "noise": ("noise", "noise of all sensors", "% of range", 100.0),
    "stroke": ("stroke", "used share of the joystick travel", "%", 100.0),
    "dropout": ("dropout", "time in which each sensor is silent", "%", 100.0),
    "friction": ("friction", "joint friction, multiple of the machine's", "", 1.0),
    "friction without flow sensors": ("friction", "the same, without flow sensors", "", 1.0),
}
_LOGS = {
    "all sensors": USUAL,
    "no outlet flows": SWEEPS["outlet sensors"][1],
    "no flows": SWEEPS["sensors"][1],
    "no flows, no pressures": SWEEPS["sensors"][2],
    "commands and angles": SWEEPS["sensors"][3],
    **{f"operator {c.operator}": c for c in SWEEPS["operator"][1:]},
}
_ADAPTATION: dict[str, Callable[[LayoutMachine], Table]] = {
    "torque limit": torque_limit_study,
    "worn pumps": worn_pump_study,
}


def all_outcomes(lab: Lab) -> dict[Conditions, Outcome]:
    """Outcome of every condition, each once."""
    every = list(dict.fromkeys(c for sweep in SWEEPS.values() for c in sweep))
    return dict(zip(every, outcomes(lab, every), strict=True))


def _errors(found: Sequence[Outcome]) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Medians and worst errors of both ways in mm, NaN where there are no networks; and their units."""
    columns = {
        f"{way}, {which}": np.array(
            [np.nan if (reached := getattr(o, way)) is None else 1e3 * getattr(reached, which) for o in found]
        )
        for way in WAYS
        for which in ("median", "worst")
    }
    return columns, dict.fromkeys(columns, "mm")


def what_data_buy(lab: Lab) -> Figure:
    """End-effector error over amount and quality of the data."""
    data, known = {}, all_outcomes(lab)
    for name, (attribute, label, unit, scale) in _PANELS.items():
        columns, units = _errors([known[c] for c in SWEEPS[name]])
        data[name] = Table(
            {label: scale * np.array([float(getattr(c, attribute)) for c in SWEEPS[name]]), **columns},
            {**units, **({label: unit} if unit else {})},
        )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, 3, width=12.0, height=2.8)
        for axis, table in zip(axes.ravel(), data.values(), strict=True):
            label = table.names[0]
            for way, color in WAYS.items():
                axis.semilogy(table[label], table[f"{way}, median"], "o-", color=color, label=f"{way}, median")
                axis.semilogy(
                    table[label], table[f"{way}, worst"], "s--", color=color, markersize=4, label=f"{way}, worst"
                )
            axis.axhline(
                float(printed_mm("sim.task.end_effector_error_max_m")), color="0.5", linestyle=":", label="thesis, task"
            )
            axis.set_xlabel(with_unit(label, table.unit(label)))
            axis.set_ylabel("end-effector error [mm]")
            axis.grid(alpha=0.3, which="both")
        # between both ways, where no curve passes
        axes[0, 0].legend(fontsize="x-small", ncols=2, loc="center right", bbox_to_anchor=(1.0, 0.36))
        return figure

    see = (
        f"Each panel varies one condition; the others are the usual ones: {conditions_in_words(USUAL)} (in the last panel also no flow sensors). "
        "Networks and the identified machine come from the same log, and are tested in the same runs, by operators whose work they never saw. Dotted "
        "line: what the thesis reached in its task, with networks learnt from a simulation."
    )
    return Figure("Accuracy over amount and quality of the measured data", see, data, draw)


def what_sensors_buy(lab: Lab) -> Figure:
    """End-effector error by the sensors that a log has, and by the operator who was logged."""
    known = all_outcomes(lab)
    columns, units = _errors([known[c] for c in _LOGS.values()])
    table = Table({"row": np.arange(1.0, len(_LOGS) + 1.0), **columns}, units)

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=9.6, height=3.6)
        axis, places = axes[0, 0], np.arange(len(_LOGS))
        for shift, (way, color) in zip((-0.12, 0.12), WAYS.items(), strict=True):
            median, worst = table[f"{way}, median"], table[f"{way}, worst"]
            axis.vlines(places + shift, median, worst, color=color, linewidth=1.2)
            axis.plot(places + shift, median, "o", color=color, label=f"{way}, median")
            axis.plot(places + shift, worst, "_", color=color, markersize=10, label=f"{way}, worst")
        axis.set_yscale("log")
        axis.set_xticks(places, list(_LOGS), rotation=20, ha="right", rotation_mode="anchor")
        axis.set_ylabel("end-effector error [mm]")
        axis.grid(alpha=0.3, which="both", axis="y")
        axis.legend(fontsize="small", ncols=2)
        return figure

    see = (
        "Fewer and fewer sensors of the same work, then all sensors of two other operators. Levers' voltages are always known. Networks need spools and pressures. "
        "Rows of the data are in the order of the axis."
    )
    return Figure("Accuracy by the sensors of the log, and by its operator", see, {"": table}, draw)


def change(lab: Lab, name: str) -> Table:
    """Errors of networks that follow one change of the machine, `torque limit` or `worn pumps`."""

    def made() -> Table:
        lab.say(f"adaptation: {name}")
        return _ADAPTATION[name](lab.machine)

    return lab.computed.table(f"adaptation {name}", made)


def adaptation(lab: Lab) -> Figure:
    """Errors of networks that follow a machine which changes, over the minutes of operation."""
    data = {name: change(lab, name) for name in _ADAPTATION}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.2)
        titles = (
            "(a) a torque limit that was not in the training data",
            f"(b) pumps that lose 10 % of their flow, replaced after {WORN} min",
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


FIGURES = {"8-1": what_data_buy, "8-2": what_sensors_buy, "8-3": adaptation}
