"""Figures of chapter 4, each a function of the lab."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic import units
from polydraulic.networks.plot import draw_network
from polydraulic.tables import Table
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import spool_of
from polydraulic.thesis.report.catalog import Figure
from polydraulic.thesis.report.chapters.chapter_3 import perceptron
from polydraulic.thesis.report.figures.draw import canvas, map_panel, over_time
from polydraulic.thesis.single_link import (
    FULL_TRAVEL_VOLTAGE,
    BoomStudy,
    boom_grid,
    boom_study,
    field_table,
    map_error,
    outlet_conductance,
    output_map_error,
    pressure_flow_error,
)

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
    title: str,
    see: str,
    panels: Sequence[tuple[str, str, np.ndarray, str]],
    *,
    error: bool,
) -> Figure:
    """Figure of one map per panel; a panel is (title, column, values in SI, unit)."""
    tables = [_thin(study, {column: (values, unit)}) for _, column, values, unit in panels]
    names = [""] if len(panels) == 1 else [chr(ord("a") + i) for i in range(len(panels))]

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, len(panels), width=4.8 * len(panels), height=3.4)
        for axis, table, (name, column, _, _) in zip(axes[0], tables, panels, strict=True):
            map_panel(axis, table, column, name, error=error)
        return figure

    return Figure(title, see, dict(zip(names, tables, strict=True)), draw)


def orifice_conductances(lab: Lab) -> Figure:
    """Fig 4-1, inset: orifice conductances over spool travel."""
    valve = lab.machine.function("boom").valve
    unit = "in3/s/psi^0.5"
    columns = {"travel": units.from_si(np.array(valve.knots), "in")}
    curves = {name: values for name, values in valve._asdict().items() if name != "knots"}
    for name, values in curves.items():
        columns[name] = units.from_si(np.array(values), unit)
    table = Table(columns, {"travel": "in", **dict.fromkeys(curves, unit)})

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.2)
        for axis, top in zip(axes[0], (None, 10.0), strict=True):
            for name in curves:
                axis.plot(table["travel"], table[name], ".-", label=name, linewidth=1.2)
            axis.set_xlabel("spool travel [in]")
            axis.set_ylabel(f"conductance K a [{unit}]")
            axis.set_ylim(0.0, top)
            axis.grid(alpha=0.3)
        axes[0, 0].legend(fontsize="small")
        axes[0, 1].set_title("the same, enlarged", fontsize="medium")
        return figure

    see = "The bypass closes while the actuator ports open; beyond 0.376 in it is shut."
    return Figure("Orifice conductances of the boom valve", see, {"": table}, draw)


def pressure_map(lab: Lab) -> Figure:
    """Fig 4-2: pump pressure, and a slice of it."""
    study = boom_study(lab)
    grid, model = study.grid, study.historical.p_pump
    low = units.to_si(100.0, "psi")
    travel = spool_of(study.machine).end
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

    see = "The pressure has a spike at the end of the deadband and a kink where the bypass closes; the networks smooth both."
    return Figure("Pump pressure: map, and exact against networks", see, {"a": full, "b": slice_}, draw)


def pressure_errors(lab: Lab) -> Figure:
    """Fig 4-3: error of the pressure networks, and of the flow that follows from them."""
    study = boom_study(lab)
    return _maps(
        study,
        "Pump-pressure networks: error of the pressure, and of the flow that follows from it",
        "Right: Eq. (1) multiplies a pressure error by (K a_i)²/(2 Q_i). With the inlet wide open, an error of a few psi is an error as large as the flow.",
        [
            ("(a) pressure error", "p_pump error", map_error(study.historical, study.grid, "boom.p_pump"), "psi"),
            ("(b) input flow error", "q_in error", pressure_flow_error(study), "in3/s"),
        ],
        error=True,
    )


def input_flow_map(lab: Lab) -> Figure:
    """Fig 4-8: input flow."""
    study = boom_study(lab)
    see = "Zero in the deadband, the whole pump flow once the bypass is shut."
    return _maps(study, "Input flow", see, [("input flow", "q_in", study.grid["boom.q_in"], "in3/s")], error=False)


def output_flow(lab: Lab) -> Figure:
    """Fig 4-9: output flow."""
    study = boom_study(lab)
    see = "Not symmetric: the outlet is throttled when the boom is lowered."
    return _maps(study, "Output flow", see, [("output flow", "q_out", study.grid["boom.q_out"], "in3/s")], error=False)


def _flow_errors(title: str, see: str, which: str) -> Callable[[Lab], Figure]:
    """Error maps of input and output flow of one kind of networks."""

    def make(lab: Lab) -> Figure:
        study = boom_study(lab)
        models = getattr(study, which)
        return _maps(
            study,
            title,
            see,
            [
                ("(a) input flow error", "q_in error", map_error(models, study.grid, "boom.q_in"), "in3/s"),
                ("(b) output flow error", "q_out error", output_map_error(models, study), "in3/s"),
            ],
            error=True,
        )

    return make


def _runs(
    scenario: str, kinds: Sequence[str], title: str, see: str, columns: Mapping[str, str]
) -> Callable[[Lab], Figure]:
    """Quantities of a run over time; `full travel` stands for the scenario that opens the valve fully."""

    def make(lab: Lab) -> Figure:
        study = boom_study(lab)
        runs = study.full_travel if scenario == "full travel" else study.runs(scenario, *kinds)
        return over_time(title, see, {kind: runs[kind] for kind in kinds}, columns)

    return make


def sweep(lab: Lab) -> Figure:
    """Fig 4-18: error over the number of hidden units."""
    found = boom_study(lab).sweep
    table = Table(
        {name: found[name] if name == "hidden_units" else units.from_si(found[name], "in3/s") for name in found.names},
        {name: "in3/s" for name in found.names if name != "hidden_units"},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=6.0, height=3.4)
        for name in table.names[1:]:
            axes[0, 0].semilogy(table["hidden_units"], table[name], "o-", label=name.replace("_", " "))
        axes[0, 0].set_xlabel("hidden units")
        axes[0, 0].set_ylabel("error [in3/s]")
        axes[0, 0].grid(alpha=0.3, which="both")
        axes[0, 0].legend(fontsize="small")
        return figure

    see = "More units reduce the error, on training and held-out rows alike. The instability that the thesis saw at 20 units does not occur with this training method."
    return Figure("Perceptron: error over the number of hidden units", see, {"": table}, draw)


def outlet_curve(lab: Lab) -> Figure:
    """Fig 4-20: Q_pop over the spool, and the perceptrons' error."""
    study = boom_study(lab)
    travel = spool_of(lab.machine).end
    spool = np.linspace(-travel, travel, 1201)
    exact = outlet_conductance(lab.machine, spool)
    learnt = study.perceptrons.k_out.predict(spool[:, None])
    unit = "in3/s/psi^0.5"
    table = Table(
        {
            "spool": units.from_si(spool, "in"),
            "exact": units.from_si(exact, unit),
            "neural": units.from_si(learnt, unit),
        },
        {"spool": "in", "exact": unit, "neural": unit},
    )

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 2, width=9.6, height=3.0)
        axes[0, 0].plot(table["spool"], table["exact"], color="#9ec5e8", linewidth=3.5, label="exact")
        axes[0, 0].plot(table["spool"], table["neural"], color="C4", linewidth=1.2, label="perceptrons")
        axes[0, 0].legend(fontsize="small")
        axes[0, 1].plot(table["spool"], table["neural"] - table["exact"], color="C4")
        for axis, label in zip(axes[0], ("Q_pop", "perceptrons minus exact"), strict=True):
            axis.set_xlabel("spool [in]")
            axis.set_ylabel(f"{label} [{unit}]")
            axis.grid(alpha=0.3)
        return figure

    see = "Divided by sqrt(P_o - P_e), the output flow depends on the spool position only. One curve is learnt in each region."
    return Figure("Output flow as a curve, Q_pop(x)", see, {"": table}, draw)


def networks(lab: Lab) -> Figure:
    """Fig 4-10: the networks and their inputs, in the regions where the valve is opening."""
    models = boom_study(lab).historical
    q_in, q_out = models.q_in, models.q_out
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

    see = "Inputs: spool travel and P_i for the input flow; spool displacement and sqrt(P_o - P_e) for the output flow."
    return Figure("Flow networks and their inputs", see, {"": table}, draw)


def convergence(lab: Lab) -> Figure:
    """Not in the thesis: the loop against a solution with tight tolerances."""
    table = boom_study(lab).convergence

    def draw() -> "matplotlib.figure.Figure":
        figure, axes = canvas(1, 1, width=6.0, height=3.6)
        axis = axes[0, 0]
        for name in table.names[1:]:
            axis.loglog(table["dt"], table[name], "o-", label=_SCENARIOS[name])
        axis.loglog(table["dt"], table["dt"] * table[table.names[1]][0] / table["dt"][0], "k:", label="first order")
        axis.set_xlabel("time step [s]")
        axis.set_ylabel("largest joint error [deg]")
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize="small")
        return figure

    see = "The error halves with the step: first order, as expected of the semi-implicit method."
    return Figure(
        "Time-step error of the simulation loop, against a solution with tight tolerances", see, {"": table}, draw
    )


_FLOWS = {"boom.q_in": "(a) input flow", "boom.q_out": "(b) output flow"}
_LINES = {"boom.p_in": "(a) input line", "boom.p_out": "(b) output line"}
_JOINT = {"boom.angle": "(a) joint displacement", "boom.rate": "(b) joint velocity"}
_PRESSURE = ("exact", "pressure")
_FULL = ("exact", "pressure", "polynomial")
_ALL = ("exact", "iterative", "polynomial")
_NEURAL = ("exact", "iterative", "neural")
_08, _05 = "0.8 sin(1.2566 t)", "0.5 sin(0.6283 t)"  # V
_SCENARIOS = {"single_08": f"{_08} V", "single_05": f"{_05} V"}
_WIDE = f"at full travel (0.8 V replaced by {FULL_TRAVEL_VOLTAGE} V)"
_TOGETHER = "At the scale of the flows (above) the curves coincide; below, the iteration differs by its convergence bound eps and the networks by their map error."
_FOLLOW = "Line pressures follow from the flows; only the flows are learnt."
_AVERAGE = "Most of the flow error averages out in the joint motion."

FIGURES: dict[str, Callable[[Lab], Figure]] = {
    "4-1": orifice_conductances,
    "4-2": pressure_map,
    "4-3": pressure_errors,
    "4-4": _runs("single_08", _PRESSURE, f"Pump pressure in simulation, {_08}",
                 "The networks' pressure oscillates around the exact one by some tens of psi.", {"boom.p_pump": "pump pressure"}),
    "4-5": _runs("single_08", _PRESSURE, "Flows with pump-pressure networks",
                 "The spool reaches only 0.33 in here, where the inlet is still narrow and a pressure error has little effect on the flow.", _FLOWS),
    "4-6": _runs("single_08", _PRESSURE, "Line pressures with pump-pressure networks", "Input and output lines.", _LINES),
    "4-7": _runs("single_08", _PRESSURE, "Joint motion with pump-pressure networks",
                 "With the printed voltage the effect on the joint is small in this circuit.", _JOINT),
    "4-P1": _runs("full travel", _FULL, f"Input flow with pump-pressure networks {_WIDE}",
                  "Here the pressure networks fail: the flow exceeds what the pump can deliver. Networks of the flow itself do not.",
                  {"boom.q_in": "input flow"}),
    "4-P2": _runs("full travel", _FULL, f"Joint motion with pump-pressure networks {_WIDE}",
                  "Here the flow error is visible in the joint motion.", _JOINT),
    "4-8": input_flow_map,
    "4-9": output_flow,
    "4-10": networks,
    "4-11": _flow_errors(
        "Flow networks, thesis' setting: map errors",
        "Input flow: errors between 0.188 and 0.376 in. Output flow: errors near -0.376 in, where its slope changes.",
        "historical"),
    "4-N1": _flow_errors(
        "Flow networks, polydraulic: map errors",
        "Same data, regions and kinds of node as Fig 4-11; in addition the error prior is estimated from the residuals, unnecessary terms are removed and all coefficients are refined together.",
        "ours"),
    "4-12": _runs("single_08", _ALL, f"Flows, {_08}", _TOGETHER, _FLOWS),
    "4-13": _runs("single_08", _ALL, f"Line pressures, {_08}", _FOLLOW, _LINES),
    "4-14": _runs("single_08", _ALL, f"Joint motion, {_08}", _AVERAGE, _JOINT),
    "4-15": _runs("single_05", _ALL, f"Flows, {_05}", _TOGETHER, _FLOWS),
    "4-16": _runs("single_05", _ALL, f"Line pressures, {_05}", _FOLLOW, _LINES),
    "4-17": _runs("single_05", _ALL, f"Joint motion, {_05}", _AVERAGE, _JOINT),
    "4-18": sweep,
    "4-19": perceptron,
    "4-20": outlet_curve,
    "4-21": _flow_errors(
        "Perceptrons: map errors",
        "One perceptron over the whole travel smooths both kinks of the input flow: at the end of the deadband and where the bypass closes.",
        "perceptrons"),
    "4-22": _runs("single_05", _NEURAL, f"Flows with perceptrons, {_05}",
                  "The smoothed kink causes an error as the valve opens at 2 s and as it closes.", _FLOWS),
    "4-23": _runs("single_05", _NEURAL, f"Line pressures with perceptrons, {_05}", _FOLLOW, _LINES),
    "4-24": _runs("single_05", _NEURAL, f"Joint motion with perceptrons, {_05}",
                  "The errors at opening and closing add up in the joint angle.", _JOINT),
    "4-C1": convergence,
}  # fmt: skip
