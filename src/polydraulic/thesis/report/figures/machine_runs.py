"""Figures of runs of the whole machine, which chapters 5 and 6 share: flows, pressures, joints, end-effector."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.figures.draw import canvas, columns_of_runs, finish, name_of, over_time, time_panel
from polydraulic.thesis.three_links import three_link_study

if TYPE_CHECKING:
    import matplotlib.figure

MakeFigure = Callable[[Lab], Figure]

_PAIR = ("swing", "stick")
_ALL = ("boom", "swing", "stick")
_ALIKE = 5.0  # ratio of the largest errors up to which panels side by side share one scale


def quantity_figure(
    scenario: str,
    name: str,
    title: str,
    see: str,
    kinds: Sequence[str],
    *,
    links: Sequence[str] = _PAIR,
    limited: bool = False,
) -> MakeFigure:
    """One quantity of several links over time, and below its difference from exact."""
    columns = {f"{link}.{name}": f"({letter}) {link}" for letter, link in zip("abc", links, strict=False)}

    def make(lab: Lab) -> Figure:
        runs = three_link_study(lab).runs(scenario, *kinds, limited=limited)
        return over_time(title, see, runs, columns)

    return make


def effector(scenario: str, title: str, see: str, kinds: Sequence[str], *, limited: bool = False) -> MakeFigure:
    """Where the end-effector is."""

    def make(lab: Lab) -> Figure:
        runs = three_link_study(lab).runs(scenario, *kinds, limited=limited)

        def draw() -> "matplotlib.figure.Figure":
            figure, axes = canvas(1, 3, width=12.6, height=2.8)
            for axis, column in zip(axes[0], EFFECTOR, strict=True):
                time_panel(axis, runs, column, column[-1].upper())
                axis.set_xlabel("time [s]")
            return figure

        return Figure(title, see, {"": columns_of_runs(runs, EFFECTOR)}, draw)

    return make


def effector_error(scenario: str, title: str, see: str, kinds: Sequence[str], *, limited: bool = False) -> MakeFigure:
    """How far the end-effector is from that of the exact run: along each axis, and the distance."""

    def make(lab: Lab) -> Figure:
        runs = three_link_study(lab).runs(scenario, "exact", *kinds, limited=limited)
        table = error_table(runs)

        def draw() -> "matplotlib.figure.Figure":
            figure, axes = canvas(1, len(kinds), width=5.4 * len(kinds), height=3.0)
            sizes = [float(table[f"{name_of(kind)} distance"].max()) for kind in kinds]
            alike = max(sizes) < _ALIKE * min(sizes)
            for axis, kind in zip(axes[0], kinds, strict=True):
                for name in ("X", "Y", "Z", "distance"):
                    wide = name == "distance"
                    axis.plot(table["time"], table[f"{name_of(kind)} {name}"], "k-" if wide else "-", label=name, linewidth=1.6 if wide else 1.0)  # fmt: skip
                finish(
                    axis, "end-effector error [m]", f"{name_of(kind)} minus exact{'' if alike else '; scales differ'}"
                )
                axis.set_xlabel("time [s]")
            if alike:
                for axis in axes[0, 1:]:
                    axis.sharey(axes[0, 0])
            return figure

        return Figure(title, see, {"": table}, draw)

    return make


def error_table(runs: Mapping[str, Table]) -> Table:
    """Differences of the end-effector from the exact run, by kind and axis, in m."""
    exact = runs["exact"]
    columns = {"time": exact["time"]}
    for kind, run in runs.items():
        if kind != "exact":
            columns |= {f"{name_of(kind)} {axis[-1].upper()}": run[axis] - exact[axis] for axis in EFFECTOR}
            columns[f"{name_of(kind)} distance"] = effector_distance(exact, run)
    return Table(columns, {"time": "s", **dict.fromkeys(list(columns)[1:], "m")})


def voltages(scenario: str, title: str, see: str) -> MakeFigure:
    """What the operator does."""

    def make(lab: Lab) -> Figure:
        run = three_link_study(lab).run(scenario, "exact")
        columns = [f"{link}.voltage" for link in LINKS]
        table = Table({name: run[name] for name in ("time", *columns)}, {"time": "s", **dict.fromkeys(columns, "V")})

        def draw() -> "matplotlib.figure.Figure":
            figure, axes = canvas(1, 1, width=8.0, height=2.8)
            for name in columns:
                axes[0, 0].plot(table["time"], table[name], label=name.split(".")[0])
            finish(axes[0, 0], "lever voltage [V]", "")
            axes[0, 0].set_xlabel("time [s]")
            return figure

        return Figure(title, see, {"": table}, draw)

    return make


def eps_study(lab: Lab) -> Figure:
    """Fig 5-45: swing flow of the task for three convergence bounds of the iteration."""
    study = three_link_study(lab)
    bounds = (0.1, 0.05, 0.001)
    runs = {"exact": study.run("task", "exact"), "polynomial": study.run("task", "polynomial")}
    swept = {eps: study.run("task", "iterative", eps=eps) for eps in bounds}
    named = runs | {f"iterative {eps}": run for eps, run in swept.items()}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, 3, width=12.6, height=2.4)
        for place, eps in enumerate(bounds):
            shown = {"exact": runs["exact"], "iterative": swept[eps], "polynomial": runs["polynomial"]}
            time_panel(axes[0, place], shown, "swing.q_in", f"({'abc'[place]}) eps = {eps}")
            late = {kind: _since(run, 10.0) for kind, run in shown.items()}
            time_panel(axes[1, place], late, "swing.q_in", "")
            axes[1, place].set_xlabel("time [s]")
        return figure

    return Figure(
        "Task: swing input flow with three convergence bounds",
        "The larger the convergence bound eps, the wider the band in which the iterative flow jumps; the flow of the networks is smooth, with an offset.",
        {"": columns_of_runs(named, ["swing.q_in"])},
        draw,
    )


def _since(run: Table, start: float) -> Table:
    """The end of a run."""
    rows = np.flatnonzero(run["time"] >= start)
    return Table({name: run[name][rows] for name in run.names}, run.units, run.info)


def scenario_figures(
    first: int, scenario: str, name: str, see: Mapping[str, str], kinds: Sequence[str]
) -> dict[str, MakeFigure]:
    """The eight figures of a run in chapter 5, numbered from `first` on, with what to see in each."""
    makers = [
        quantity_figure(scenario, "q_in", f"{name}: input flows", see["q_in"], kinds),
        quantity_figure(scenario, "q_out", f"{name}: output flows", see["q_out"], kinds),
        quantity_figure(scenario, "p_in", f"{name}: input line pressures", see["p_in"], kinds),
        quantity_figure(scenario, "p_out", f"{name}: output line pressures", see["p_out"], kinds),
        quantity_figure(scenario, "angle", f"{name}: joint displacements", see["angle"], kinds, links=_ALL),
        quantity_figure(scenario, "rate", f"{name}: joint velocities", see["rate"], kinds, links=_ALL),
        effector(scenario, f"{name}: end-effector", see["effector"], kinds),
        effector_error(scenario, f"{name}: end-effector error", see["error"], ("polynomial", "ours")),
    ]
    return {f"5-{first + place}": maker for place, maker in enumerate(makers)}
