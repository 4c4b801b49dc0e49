"""Figures beyond the thesis: errors by scenario, by idea, by flow model, and of random operators."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.tables import Table
from polydraulic.thesis.beyond import (
    BY_OPERATORS,
    FLOWS,
    N_OPERATORS,
    OPERATOR_SECONDS,
    ablation,
    costs,
    operator_errors,
    tip_errors,
)
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Figure, printed_mm
from polydraulic.thesis.report.figures.draw import STYLES, canvas, name_of
from polydraulic.thesis.report.figures.volumes import volumes
from polydraulic.thesis.three_links import SCENARIOS, three_link_study

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure


def by_scenario(lab: Lab) -> Figure:
    """Largest end-effector errors: printed, in the thesis' setting, and of polydraulic's networks."""
    errors = tip_errors(three_link_study(lab))
    columns = {
        "thesis": [1e-3 * float(printed_mm(f"sim.{name}.end_effector_error_max_m")) for name in SCENARIOS],
        "thesis' setting": [errors["polynomial"][name] for name in SCENARIOS],
        "polydraulic": [errors["ours"][name] for name in SCENARIOS],
    }
    table = Table({name: 1e3 * np.array(values) for name, values in columns.items()}, dict.fromkeys(columns, "mm"))

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=8.0, height=3.4)
        _bars(axes[0, 0], table, list(SCENARIOS), ["0.6", STYLES["polynomial"][0], STYLES["ours"][0]])
        axes[0, 0].set_ylabel("largest end-effector error [mm]")
        return figure

    return Figure("End-effector errors of the four runs", _ratios(table), {"": table}, draw)


def _ratios(table: Table) -> str:
    gain = table["thesis' setting"] / table["polydraulic"]
    return (
        f"On the same machine, errors with polydraulic's networks are {gain.min():.0f} to {gain.max():.0f} times smaller than with "
        "networks in the thesis' setting. Neither was trained or selected on these runs. The printed errors are from the thesis' own "
        "machine model, whose orifice areas are not known."
    )


def by_idea(lab: Lab) -> Figure:
    """What each idea brings."""
    found = ablation(three_link_study(lab))
    table = Table(
        {
            "swing in D, rms": np.array([rung.swing[0] for rung in found.values()]),
            "stick in D, rms": np.array([rung.stick[0] for rung in found.values()]),
            "end-effector, worst run": np.array([1e3 * max(rung.tip.values()) for rung in found.values()]),
        },
        {"swing in D, rms": "in3/s", "stick in D, rms": "in3/s", "end-effector, worst run": "mm"},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=11.0, height=3.6)
        places = np.arange(len(found))
        for name in table.names[:2]:
            axes[0, 0].semilogy(places, table[name], "o-", label=name)
        axes[0, 0].set_ylabel("map error in section D [in3/s]")
        axes[0, 0].legend(fontsize="small")
        axes[0, 1].semilogy(places, table[table.names[2]], "o-", color="k", label=table.names[2])
        axes[0, 1].set_ylabel("largest end-effector error [mm]")
        axes[0, 1].legend(fontsize="small")
        for axis in axes[0]:
            axis.set_xticks(places, list(found), rotation=25, ha="right", fontsize="small")
            axis.grid(alpha=0.3, which="both")
        return figure

    see = "Searching for the regions reduces the errors most, then refining all coefficients together; larger networks alone do little."
    return Figure("What each step of the method contributes", see, {"": table}, draw)


def by_flow_model(lab: Lab) -> Figure:
    """Error against time for every flow model."""
    study = three_link_study(lab)
    errors, cost = tip_errors(study), costs(study)
    shown = [kind for kind in FLOWS if kind not in ("exact", "direct")]
    table = Table(
        {
            "time": np.array([cost[kind].time.median for kind in shown]),
            **{name: 1e3 * np.array([errors[kind][name] for kind in shown]) for name in SCENARIOS},
        },
        {"time": "of exact", **dict.fromkeys(SCENARIOS, "mm")},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=8.0, height=4.0)
        axis = axes[0, 0]
        for name, marker in zip(SCENARIOS, "osD^", strict=True):
            axis.loglog(table["time"], table[name], marker, label=name)
        for kind, time in zip(shown, table["time"], strict=True):
            axis.text(time, 1.3 * 1e3 * max(errors[kind].values()), name_of(kind), ha="center", fontsize="small")
        axis.axvline(1.0, color="0.6", linestyle="--")
        axis.set_xlabel("time of a whole step, as a share of that with the exact flow")
        axis.set_ylabel("largest end-effector error [mm]")
        axis.set_ylim(top=2e4)
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize="small")
        return figure

    see = (
        "Models left of the dashed line are faster than the exact flow, which has no error by definition. What networks offer is "
        "independence of orifice areas, not speed. The differences of stiff and tlm come from the oil volume between pump and "
        "valves, which the exact flow neglects."
    )
    return Figure("Every flow model: error and time", see, {"": table}, draw)


def by_operator(lab: Lab) -> Figure:
    """Distribution of the errors of random operators."""
    found = operator_errors(three_link_study(lab))
    share = np.linspace(0.0, 1.0, len(next(iter(found.values()))))
    table = Table(
        {"share": share, **{name_of(kind): 1e3 * np.array(found[kind]) for kind in BY_OPERATORS}},
        {name_of(kind): "mm" for kind in BY_OPERATORS},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=8.0, height=3.6)
        axis = axes[0, 0]
        for kind in BY_OPERATORS:
            color = STYLES[kind][0] if kind in STYLES else "0.4"
            axis.semilogx(table[name_of(kind)], 100.0 * share, label=name_of(kind), color=color)
        axis.axhline(95.0, color="0.6", linestyle="--")
        axis.set_xlabel("largest end-effector error of a run [mm]")
        axis.set_ylabel("runs with a smaller error [%]")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize="small")
        return figure

    see = f"{N_OPERATORS} runs of {OPERATOR_SECONDS:g} s by random operators who use the whole range of motion, end stops included; no network was trained on them."
    return Figure("End-effector errors of random operators", see, {"": table}, draw)


def _bars(axis: "matplotlib.axes.Axes", table: Table, labels: list[str], colors: list[str]) -> None:
    places, width = np.arange(len(labels)), 0.8 / len(table.names)
    for k, (name, color) in enumerate(zip(table.names, colors, strict=True)):
        axis.bar(places + (k - 0.5 * (len(colors) - 1)) * width, table[name], width, label=name, color=color)
    axis.set_yscale("log")
    axis.set_xticks(places, labels)
    axis.grid(alpha=0.3, axis="y", which="both")
    axis.legend(fontsize="small")


FIGURES: dict[str, Callable[[Lab], Figure]] = {
    "7-1": by_scenario,
    "7-2": by_idea,
    "7-3": by_flow_model,
    "7-4": by_operator,
    "7-5": volumes,
}
