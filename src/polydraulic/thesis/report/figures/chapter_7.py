"""Figures beyond the thesis: errors by scenario, by idea, by flow model, and of random operators."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.tables import Table
from polydraulic.thesis.beyond import BY_OPERATORS, FLOWS, ablation, costs, operator_errors, tip_errors
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.figures.draw import canvas
from polydraulic.thesis.report.figures.volumes import volumes
from polydraulic.thesis.three_links import SCENARIOS, three_link_study

if TYPE_CHECKING:
    import matplotlib.axes
    import matplotlib.figure

PRINTED_TIP = {"sine": 0.313, "step": 1.4, "pulse": 0.867, "task": 0.347}  # m, thesis 5.3
_NAMES = {"polynomial": "thesis' setting", "ours": "this package", "direct": "this package, direct"}


def name_of(kind: str) -> str:
    """What a kind of flow model is called in this chapter."""
    return _NAMES.get(kind, kind)


def by_scenario(lab: Lab) -> Figure:
    """Largest end-effector errors: printed, reproduced, and of this package's networks."""
    errors = tip_errors(three_link_study(lab))
    columns = {
        "printed": [PRINTED_TIP[name] for name in SCENARIOS],
        "thesis' setting": [errors["polynomial"][name] for name in SCENARIOS],
        "this package": [errors["ours"][name] for name in SCENARIOS],
    }
    table = Table({name: 1e3 * np.array(values) for name, values in columns.items()}, dict.fromkeys(columns, "mm"))

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=8.0, height=3.4)
        _bars(axes[0, 0], table, list(SCENARIOS))
        axes[0, 0].set_ylabel("largest end-effector error [mm]")
        return figure

    return Figure("End-effector errors of the four runs", _ratios(table), {"": table}, draw)


def _ratios(table: Table) -> str:
    gain = table["thesis' setting"] / table["this package"]
    return (
        f"Networks of this package are {gain.min():.0f} to {gain.max():.0f} times closer than the thesis' setting on the same "
        "machine; neither was trained or chosen on these runs."
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
        axes[0, 0].set_ylabel("[in3/s]")
        axes[0, 0].legend(fontsize="small")
        axes[0, 1].semilogy(places, table[table.names[2]], "o-", color="k", label=table.names[2])
        axes[0, 1].set_ylabel("[mm]")
        axes[0, 1].legend(fontsize="small")
        for axis in axes[0]:
            axis.set_xticks(places, list(found), rotation=25, ha="right", fontsize="small")
            axis.grid(alpha=0.3, which="both")
        return figure

    see = "Finding the regions brings most, refining the grown coefficients second; larger networks alone bring little."
    return Figure("What each idea brings", see, {"": table}, draw)


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
        "Left of the dashed line is faster than exact, which has no error: the networks buy independence of orifice areas, "
        "not speed. The errors of stiff and tlm are the oil between pump and valves, which exact leaves out."
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
        for name in table.names[1:]:
            axis.semilogx(table[name], 100.0 * share, label=name)
        axis.axhline(95.0, color="0.6", linestyle="--")
        axis.set_xlabel("largest end-effector error of a run [mm]")
        axis.set_ylabel("runs below it [%]")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize="small")
        return figure

    see = "Sixty seconds of an operator nobody knew in advance, two hundred times: the whole range of motion, stops included."
    return Figure("End-effector errors of random operators", see, {"": table}, draw)


def _bars(axis: "matplotlib.axes.Axes", table: Table, labels: list[str]) -> None:
    places, width = np.arange(len(labels)), 0.8 / len(table.names)
    for k, name in enumerate(table.names):
        axis.bar(places + (k - 0.5 * (len(table.names) - 1)) * width, table[name], width, label=name)
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
