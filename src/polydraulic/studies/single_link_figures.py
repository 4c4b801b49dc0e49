"""Figures of chapters 3 and 4, each a function of the study."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic import units
from polydraulic.networks import Variable
from polydraulic.networks.plot import draw_history, draw_network
from polydraulic.studies.catalog import Figure
from polydraulic.studies.draw import canvas, difference_panel, map_panel, run_table, time_panel
from polydraulic.studies.single_link import (
    FULL_TRAVEL_VOLTAGE,
    BoomStudy,
    boom_grid,
    field_table,
    map_error,
    pressure_flow_error,
)
from polydraulic.tables import Table

if TYPE_CHECKING:
    import matplotlib.figure

_STEP = 4  # figures show every fourth grid line of the map that the numbers are taken from


def _thin(study: BoomStudy, values: dict[str, tuple[np.ndarray, str]]) -> Table:
    """Columns over the thinned grid, in the field's units; spool and pressure first."""
    grid = field_table(study.grid, ("boom.spool", "boom.p_in"))
    n = len(np.unique(grid["boom.spool"]))
    rows = np.arange(len(grid)).reshape(-1, n)[::_STEP, ::_STEP].ravel()
    columns = {"spool": grid["boom.spool"][rows], "pressure": grid["boom.p_in"][rows]}
    for name, (v, unit) in values.items():
        columns[name] = units.from_si(v, unit)[rows]
    return Table(columns, {"spool": "in", "pressure": "psi", **{name: unit for name, (_, unit) in values.items()}})


def _maps(
    study: BoomStudy,
    number: str,
    title: str,
    see: str,
    panels: Sequence[tuple[str, str, np.ndarray, str]],
    *,
    error: bool,
) -> Figure:
    """Figure of one map a panel; a panel is (title, column, values in SI, unit)."""
    tables = [_thin(study, {column: (values, unit)}) for _, column, values, unit in panels]
    names = [""] if len(panels) == 1 else [chr(ord("a") + i) for i in range(len(panels))]

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, len(panels), width=4.8 * len(panels), height=3.4)
        for axis, table, (name, column, _, _) in zip(axes[0], tables, panels, strict=True):
            map_panel(axis, table, column, name, error=error)
        return figure

    return Figure(number, title, see, dict(zip(names, tables, strict=True)), draw)


def _times(
    number: str, title: str, see: str, runs: dict[str, Table], kinds: Sequence[str], columns: dict[str, str]
) -> Figure:
    """Figure of quantities over time, and below of their differences from exact; one column each."""
    chosen = {kind: runs[kind] for kind in kinds}

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(2, len(columns), width=4.8 * len(columns), height=2.4)
        for place, (column, name) in enumerate(columns.items()):
            time_panel(axes[0, place], chosen, column, name)
            difference_panel(axes[1, place], chosen, column)
        return figure

    return Figure(number, title, see, {"": run_table(chosen, list(columns))}, draw)


def chapter_3(study: BoomStudy) -> list[Figure]:
    """Figs 3-1 and 3-2: the network over the whole active box."""
    box = study.full_box
    history = box.estimator.history_
    steps = Table(
        {
            name: np.array([float(getattr(step, name)) for step in history])
            for name in ("layer", "n_candidates", "n_coefficients", "fse", "penalty", "pse")
        },
        {"fse": "(in3/s)^2", "penalty": "(in3/s)^2", "pse": "(in3/s)^2"},
    )

    def network() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=7.0, height=1.8)
        draw_network(axes[0, 0], box.estimator.network_, box.inputs, Variable("q_in", "in3/s"))
        return figure

    def pse() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=6.0, height=3.4)
        draw_history(axes[0, 0], history, "in3/s")
        return figure

    fitted = box.estimator.network_
    nodes = Table(
        {
            "mean": np.array([*fitted.x_mean, fitted.y_mean]),
            "scale": np.array([*fitted.x_scale, fitted.y_scale]),
        },
        {},
    )
    return [
        Figure("3-1", "Network for boom input flow over the whole active box",
               "The thesis printed a single and a double that feed a triple, which also reads the travel; numbers count coefficients.",
               {"": nodes}, network),
        Figure("3-2", "Predicted squared error while the network grows",
               "The penalty rises with K, the fitting error falls; growth stops where their sum is smallest.",
               {"": steps}, pse),
    ]  # fmt: skip


def orifices(study: BoomStudy) -> Figure:
    """Fig 4-1, inset: orifice conductances over spool travel."""
    valve, knots = study.machine.boom.valve, np.array(study.machine.spool.knots)
    unit = "in3/s/psi^0.5"
    columns = {"travel": units.from_si(knots, "in")}
    for name, values in valve._asdict().items():
        columns[name] = units.from_si(np.array(values), unit)
    table = Table(columns, {"travel": "in", **dict.fromkeys(valve._fields, unit)})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.2)
        for axis, top in zip(axes[0], (None, 10.0), strict=True):
            for name in valve._fields:
                axis.plot(table["travel"], table[name], ".-", label=name, linewidth=1.2)
            axis.set_xlabel("spool travel [in]")
            axis.set_ylabel(f"K a [{unit}]")
            axis.set_ylim(0.0, top)
            axis.grid(alpha=0.3)
        axes[0, 0].legend(fontsize="small")
        axes[0, 1].set_title("the same, enlarged", fontsize="medium")
        return figure

    see = "The bypass narrows while the actuator ports open; beyond 0.376 in the bypass is shut."
    return Figure("4-1", "Orifice conductances of the boom valve", see, {"": table}, draw)


def pressure_maps(study: BoomStudy) -> list[Figure]:
    """Figs 4-2 and 4-3: pump pressure, a slice of it, and the networks' error."""
    grid, model = study.grid, study.historical.p_pump
    low = units.to_si(100.0, "psi")
    travel = study.machine.spool.knots[-1]
    line = boom_grid(study.machine, 1201, 41)  # pressures 0, 100, 200, ... psi
    rows = np.isclose(line["boom.p_in"], low)
    predicted = model.predict(line.matrix(["boom.travel", "boom.p_in"])[rows])
    slice_ = Table(
        {
            "spool": units.from_si(np.linspace(-travel, travel, 1201), "in"),
            "exact": units.from_si(line["boom.p_pump"][rows], "psi"),
            "polynomial": units.from_si(predicted, "psi"),
        },
        {"spool": "in", "exact": "psi", "polynomial": "psi"},
    )
    full = _thin(study, {"p_pump": (grid["boom.p_pump"], "psi")})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.4)
        map_panel(axes[0, 0], full, "p_pump", "(a) pump pressure")
        for name, color in (("exact", "C0"), ("polynomial", "C3")):
            axes[0, 1].plot(slice_["spool"], slice_[name], color=color, label=name, linewidth=1.2)
        axes[0, 1].set_title("(b) at P_i = 100 psi", fontsize="medium")
        axes[0, 1].set_xlabel("spool [in]")
        axes[0, 1].set_ylabel("pump pressure [psi]")
        axes[0, 1].grid(alpha=0.3)
        axes[0, 1].legend(fontsize="small")
        return figure

    see = (
        "The pressure has a spike where the deadband ends and a kink where the bypass closes; the networks round both."
    )
    p_error = map_error(study.historical, grid, "boom.p_pump")
    q_error = pressure_flow_error(study)
    return [
        Figure("4-2", "Pump pressure: map, and exact against networks", see, {"a": full, "b": slice_}, draw),
        _maps(study, "4-3", "Pump-pressure networks: error of the pressure, and of the flow that follows from it",
              "Right: Eq. (1) multiplies a pressure error by (K a_i)²/(2 Q_i); with a wide inlet a few psi are the whole flow.",
              [("(a) pressure error", "p_pump error", p_error, "psi"),
               ("(b) input flow error", "q_in error", q_error, "in3/s")], error=True),
    ]  # fmt: skip


def pressure_runs(study: BoomStudy) -> list[Figure]:
    """Figs 4-4 to 4-7: simulation with the pump-pressure networks, and what happens at full travel."""
    runs, kinds = study.runs["single_08"], ("exact", "pressure")
    full = f"0.8 V replaced by {FULL_TRAVEL_VOLTAGE} V"
    return [
        _times("4-4", "Pump pressure in simulation, 0.8 sin(1.2566 t)",
               "The networks ripple around the exact pressure by up to a hundred psi.", runs, kinds, {"boom.p_pump": "pump pressure"}),
        _times("4-5", "Flows with pump-pressure networks", "Our spool reaches 0.33 in only, where the inlet is still narrow.",
               runs, kinds, {"boom.q_in": "(a) input flow", "boom.q_out": "(b) output flow"}),
        _times("4-6", "Line pressures with pump-pressure networks", "Input and output lines.",
               runs, kinds, {"boom.p_in": "(a) input line", "boom.p_out": "(b) output line"}),
        _times("4-7", "Joint motion with pump-pressure networks",
               "With the printed voltage the joint hardly notices in our circuit.",
               runs, kinds, {"boom.angle": "(a) joint displacement", "boom.rate": "(b) joint velocity"}),
        _times("4-P1", f"The same at full travel ({full}): input flow",
               "Here the pressure networks fail: the flow leaves what the pump can deliver; flow networks do not.",
               study.full_travel, ("exact", "pressure", "polynomial"), {"boom.q_in": "(a) input flow"}),
        _times("4-P2", f"The same at full travel ({full}): joint motion",
               "The flow error reaches the joint.", study.full_travel, ("exact", "pressure", "polynomial"),
               {"boom.angle": "(a) joint displacement", "boom.rate": "(b) joint velocity"}),
    ]  # fmt: skip


def flow_maps(study: BoomStudy) -> list[Figure]:
    """Figs 4-8, 4-9 and 4-11: flow maps and the errors of the networks."""
    grid = study.grid
    q_in, q_out = grid["boom.q_in"], grid["boom.q_out"]
    errors = {
        (kind, output): map_error(models, grid, output)
        for kind, models in (("historical", study.historical), ("ours", study.ours))
        for output in ("boom.q_in", "boom.q_out")
    }

    def panels(kind: str) -> list[tuple[str, str, np.ndarray, str]]:
        return [
            ("(a) input flow error", "q_in error", errors[kind, "boom.q_in"], "in3/s"),
            ("(b) output flow error", "q_out error", errors[kind, "boom.q_out"], "in3/s"),
        ]

    return [
        _maps(study, "4-8", "Input flow", "Nothing in the deadband, all of the pump's flow once the bypass is shut.",
              [("input flow", "q_in", q_in, "in3/s")], error=False),
        _maps(study, "4-9", "Output flow", "Not symmetric: the lowering side is throttled.",
              [("output flow", "q_out", q_out, "in3/s")], error=False),
        _maps(study, "4-11", "Flow networks, historical setting: map errors",
              "The input flow errs between 0.188 and 0.376 in, the output flow near -0.376 in, where its slope changes.",
              panels("historical"), error=True),
        _maps(study, "4-N1", "Flow networks of this package: map errors",
              "Same data, regions and kinds of node; the prior follows the residuals, terms are carved, coefficients refined.",
              panels("ours"), error=True),
    ]  # fmt: skip


def networks(study: BoomStudy) -> Figure:
    """Fig 4-10: the networks and their inputs, in the regions where the valve is opening."""
    q_in, q_out = study.historical.q_in, study.historical.q_out
    shown = ((q_in, 1, "(a) input flow, 0.188 to 0.376 in"), (q_out, 3, "(b) output flow, 0.188 to 0.376 in"))
    table = Table(
        {
            "coefficients": np.array([float(m.networks[k].n_coefficients) for m, k, _ in shown]),
            "nodes": np.array([float(len(m.networks[k].nodes)) for m, k, _ in shown]),
        },
        {},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=1.9)
        for axis, (model, k, title) in zip(axes[0], shown, strict=True):
            draw_network(axis, model.networks[k], model.inputs, model.output)
            axis.set_title(title, fontsize="medium")
        return figure

    see = "Input flow from spool travel and P_i; output flow from spool displacement and sqrt(P_o - P_e)."
    return Figure("4-10", "Flow networks and what they read", see, {"": table}, draw)


def flow_runs(study: BoomStudy) -> list[Figure]:
    """Figs 4-12 to 4-17: both voltages, flow networks against iterative and exact."""
    found = []
    for first, name, voltage in (
        (12, "single_08", "0.8 sin(1.2566 t)"),
        (15, "single_05", "0.5 sin(0.6283 t)"),
    ):
        runs, kinds = study.runs[name], ("exact", "iterative", "polynomial")
        found += [
            _times(f"4-{first}", f"Flows, {voltage}", "Above they lie on each other; below, the iteration shows its eps and the networks their map error.", runs, kinds,
                   {"boom.q_in": "(a) input flow", "boom.q_out": "(b) output flow"}),
            _times(f"4-{first + 1}", f"Line pressures, {voltage}", "Pressures follow although only flows are learnt.",
                   runs, kinds, {"boom.p_in": "(a) input line", "boom.p_out": "(b) output line"}),
            _times(f"4-{first + 2}", f"Joint motion, {voltage}", "Most of the flow error averages out before it reaches the joint.", runs, kinds,
                   {"boom.angle": "(a) joint displacement", "boom.rate": "(b) joint velocity"}),
        ]  # fmt: skip
    return found


def convergence(study: BoomStudy) -> Figure:
    """Our own: the loop against the tight solution."""
    table = study.convergence

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=6.0, height=3.6)
        axis = axes[0, 0]
        for name in table.names[1:]:
            axis.loglog(table["dt"], table[name], "o-", label=name)
        axis.loglog(table["dt"], table["dt"] * table[table.names[1]][0] / table["dt"][0], "k:", label="first order")
        axis.set_xlabel("time step [s]")
        axis.set_ylabel("largest joint error [deg]")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize="small")
        return figure

    see = "The error halves with the step: first order, as the semi-implicit step promises."
    return Figure("4-C1", "The loop against a tight solution of the same equations", see, {"": table}, draw)
