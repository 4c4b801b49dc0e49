"""Networks of all circuits of cat215b, learnt from the exact flow model: outlets, and inlets that know all modes of the pump at once.

These input flows include the pumps' relief valves, up to just below their setting, where a wide open inlet loses its flow
within a few psi; `mode_models` has the networks of single modes. Borders that a user knows, deadband and closing of the
bypass, are given; all others are found.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.database import outlet_at
from polydraulic.flow.layout.slots import everything, inlet, outlet
from polydraulic.flow.network_slots import Place, q_in
from polydraulic.machine.pump import Pump, limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.perceptron.perceptron_regressor import PerceptronRegressor
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.parts import ValveCurves
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

TOLERANCE = units.to_si(1.0, "in3/s")
BELOW_RELIEF = units.to_si(30.0, "psi")
ROWS = 4000  # from which a region learns
REGIONS = 64  # at most: where the relief valve opens, kinks are curved and would take hundreds
NEURAL_ROWS = 10_000  # as many as the thesis used
HIDDEN_UNITS = 15  # thesis 4.3.1
SEED = 215


BOOM_IN: Place = (q_in("boom"), everything(("boom",)))
SERIES = ("swing", "stick")  # that share a pump, from it on
BOTH = everything(SERIES)


class Travels(NamedTuple):
    """At which all valves open, at which all bypasses are shut, and at which spools end, m."""

    deadband: float
    bypass_closed: float
    end: float


def travels(machine: LayoutMachine) -> Travels:
    """Marks of the spools, which are alike."""
    valve = machine.functions[0].valve
    return Travels(*spool_edges(valve), valve.knots[-1])


def pressure_boxes(machine: LayoutMachine, below: float = 0.0) -> dict[str, tuple[float, float]]:
    """Pressures of each line, up to its own relief setting or that of its pump less `below` Pa."""
    return {
        name: (0.0, min(machine.function(name).line.relief, c.pump.relief - below))
        for c in machine.circuits
        for name in c.functions
    }


def exact_pump(machine: LayoutMachine, circuit: str) -> Pump:
    """The pump of a circuit with its relief valve and torque limit."""
    pump = machine.circuit(circuit).pump
    return limited_pump(pump.flow, pump.relief, machine.tank.return_pressure, pump)


class Target(NamedTuple):
    """What a network has to learn: a function of points (n_point, n_input) in a box, with borders that are known."""

    output: Variable
    inputs: tuple[Variable, ...]
    function: Callable[[np.ndarray], np.ndarray]
    box: list[tuple[float, float]]
    edges: dict[Any, list[float]]
    high: float  # largest output


def circuit_targets(machine: LayoutMachine) -> dict[str, Target]:
    """Input flows of a machine: ``boom``, ``swing``, ``stick`` (of what the swing leaves), ``stick direct``."""
    series, (*cuts, travel) = machine.circuit("series"), travels(machine)
    boom_pump, pump = exact_pump(machine, "boom"), exact_pump(machine, "series")
    fed = pump._replace(log_least=0.0)  # what reaches a valve knows of no torque limit
    pressure = pressure_boxes(machine, BELOW_RELIEF)
    both = [(0.0, travel), (0.0, travel), pressure["swing"], pressure["stick"]]
    edges = {"swing.travel": cuts, "stick.travel": cuts}
    stick = machine.function("stick").valve
    return {
        "boom": Target(
            *BOOM_IN, lambda X: input_flow(machine, boom_pump, X, ("boom",), "boom"), [(0.0, travel), pressure["boom"]],
            {"boom.travel": cuts}, boom_pump.flow,
        ),
        "swing": Target(
            q_in("swing"), BOTH, lambda X: input_flow(machine, pump, X, SERIES, "swing"), both, edges, pump.flow
        ),
        "stick": Target(
            *inlet(series, "stick")[0], lambda X: sample_valves([stick], fed, X[:, 1:2], X[:, 2:], X[:, 0]).q_in[:, 0],
            [(0.0, pump.flow), (0.0, travel), pressure["stick"]], {"stick.travel": cuts}, pump.flow,
        ),
        "stick direct": Target(
            q_in("stick"), BOTH, lambda X: input_flow(machine, pump, X, SERIES, "stick"), both, edges, pump.flow
        ),
    }  # fmt: skip


def learn_direct(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Network of the stick's input flow in the direct arrangement: all modes of the pump at once.

    Parameters
    ----------
    machine : LayoutMachine
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many points have been asked.
    """
    target = circuit_targets(machine)["stick direct"]
    found = learn_from(
        target.function, target.box, tolerance=TOLERANCE, edges=target.edges, budget=10_000_000,
        max_regions=REGIONS, rows=ROWS, estimator=AbductiveRegressor(max_layers=3, output_bounds=(0.0, target.high)),
        inputs=target.inputs, output=target.output, random_state=SEED,
        progress=lambda what, asked, most: progress(f"{target.output.name}: {what}", asked, most),
    )  # fmt: skip
    return [found.model]


def learn_outlets(machine: LayoutMachine) -> list[Model]:
    """Conductance of each outlet from the spool (Eq. 7)."""
    opens, shut, end = travels(machine)
    models = []
    for f in machine.functions:
        output, inputs = outlet(f.name)[0]
        high = max(f.valve.outlet_positive + f.valve.outlet_negative)

        def conductance(X: np.ndarray, valve: ValveCurves = f.valve) -> np.ndarray:
            return outlet_at(valve, X[:, 0])

        found = learn_from(
            conductance, [(-end, end)], tolerance=1e-3 * high, edges={0: [-shut, -opens, opens, shut]}, rows=300,
            estimator=AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, high)),
            inputs=inputs, output=output, random_state=SEED,
        )  # fmt: skip
        models.append(found.model)
    return models


def train_perceptrons(machine: LayoutMachine) -> list[Model]:
    """Perceptrons of the input flows, by the known regions, from random points; the stick's reads what the swing leaves."""
    targets, rng = circuit_targets(machine), np.random.default_rng(SEED)
    models = []
    for target in (targets[name] for name in ("boom", "swing", "stick")):
        low, high = np.transpose(target.box)
        X = rng.uniform(low, high, size=(NEURAL_ROWS, len(low)))
        names = [variable.name for variable in target.inputs]
        edges = {names.index(name): cuts for name, cuts in target.edges.items()}
        learner = PerceptronRegressor(
            hidden_units=HIDDEN_UNITS, domain=target.box, output_bounds=(0.0, target.high), random_state=SEED
        )
        fitted = RegionRegressor(learner, edges=edges).fit(X, target.function(X))
        models.append(fitted.to_model(target.inputs, target.output))
    return models


def input_flow(machine: LayoutMachine, pump: Pump, X: np.ndarray, functions: Sequence[str], which: str) -> np.ndarray:
    """Input flow of one function where `X` has the travels of all `functions` of a circuit, then their pressures."""
    n, valves = len(functions), [machine.function(name).valve for name in functions]
    return sample_valves(valves, pump, X[:, :n], X[:, n:]).q_in[:, functions.index(which)]
