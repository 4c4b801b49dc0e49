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
from polydraulic.flow.layout.slots import everything, outlet
from polydraulic.flow.network_slots import Place, q_in
from polydraulic.machine.pump import Pump, limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.parameters.layout.parts import ValveCurves
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.progress import Progress, quiet

TOLERANCE = units.to_si(1.0, "in3/s")
BELOW_RELIEF = units.to_si(30.0, "psi")
ROWS = 4000  # from which a region learns
REGIONS = 64  # at most: where the relief valve opens, kinks are curved and would take hundreds
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


Borders = Callable[[str], list[float]]  # travels, rising, at which the networks of a function are parted


def known_borders(machine: LayoutMachine) -> Borders:
    """Where the orifices of all valves open and their bypasses close."""
    deadband, bypass_closed, _ = travels(machine)
    return lambda name: [deadband, bypass_closed]


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


def direct_target(machine: LayoutMachine) -> Target:
    """Input flow of the stick, of everything in its circuit: all modes of the pump at once."""
    pump, (*cuts, travel) = exact_pump(machine, "series"), travels(machine)
    pressure = pressure_boxes(machine, BELOW_RELIEF)
    return Target(
        q_in("stick"), BOTH, lambda X: input_flow(machine, pump, X, SERIES, "stick"),
        [(0.0, travel), (0.0, travel), pressure["swing"], pressure["stick"]],
        {"swing.travel": cuts, "stick.travel": cuts}, pump.flow,
    )  # fmt: skip


def learn_direct(machine: LayoutMachine, progress: Progress = quiet) -> list[Model]:
    """Network of the stick's input flow in the direct arrangement: all modes of the pump at once.

    Parameters
    ----------
    machine : LayoutMachine
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many points have been asked.
    """
    target = direct_target(machine)
    found = learn_from(
        target.function, target.box, tolerance=TOLERANCE, edges=target.edges, budget=10_000_000,
        max_regions=REGIONS, rows=ROWS, estimator=AbductiveRegressor(max_layers=3, output_bounds=(0.0, target.high)),
        inputs=target.inputs, output=target.output, random_state=SEED,
        progress=lambda what, asked, most: progress(f"{target.output.name}: {what}", asked, most),
    )  # fmt: skip
    return [found.model]


def learn_outlets(machine: LayoutMachine, borders: Borders | None = None) -> list[Model]:
    """Conductance of each outlet from the spool (Eq. 7), parted at `known_borders` if no others are given."""
    at, end = borders or known_borders(machine), travels(machine).end
    models = []
    for f in machine.functions:
        cuts = at(f.name)
        output, inputs = outlet(f.name)[0]
        high = max(f.valve.outlet_positive + f.valve.outlet_negative)

        def conductance(X: np.ndarray, valve: ValveCurves = f.valve) -> np.ndarray:
            return outlet_at(valve, X[:, 0])

        found = learn_from(
            conductance, [(-end, end)], tolerance=1e-3 * high, rows=300, edges={0: [*(-x for x in reversed(cuts)), *cuts]},
            estimator=AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, high)),
            inputs=inputs, output=output, random_state=SEED,
        )  # fmt: skip
        models.append(found.model)
    return models


def input_flow(machine: LayoutMachine, pump: Pump, X: np.ndarray, functions: Sequence[str], which: str) -> np.ndarray:
    """Input flow of one function where `X` has the travels of all `functions` of a circuit, then their pressures."""
    n, valves = len(functions), [machine.function(name).valve for name in functions]
    return sample_valves(valves, pump, X[:, :n], X[:, n:]).q_in[:, functions.index(which)]
