"""Networks of all circuits, learnt from the exact flow model: outlets, and inlets that know all modes of the pump at once.

These input flows include the pumps' relief valves, up to just below their setting, where a wide open inlet loses its flow
within a few psi; `mode_models` has the networks of single modes. Borders that a user knows, deadband and closing of the
bypass, are given; all others are found.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.flow.exact import ExactFlow, exact_flow
from polydraulic.flow.network_slots import BOOM_IN, BOTH, PASSED, k_out, q_in
from polydraulic.flow.sample import sample_fed, sample_flow
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.perceptron.perceptron_regressor import PerceptronRegressor
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.schema import CIRCUITS, LINKS, Machine
from polydraulic.progress import Progress, quiet

TOLERANCE = units.to_si(1.0, "in3/s")
BELOW_RELIEF = units.to_si(30.0, "psi")
ROWS = 4000  # from which a region learns
REGIONS = 64  # at most: where the relief valve opens, kinks are curved and would take hundreds
NEURAL_ROWS = 10_000  # as many as the thesis used
HIDDEN_UNITS = 15  # thesis 4.3.1
SEED = 215


def pressure_boxes(machine: Machine, highest: float) -> dict[str, tuple[float, float]]:
    """Pressures of each line, up to its own relief setting or the `highest`."""
    return {link: (0.0, min(getattr(machine, link).line.relief, highest)) for link in LINKS}


class Target(NamedTuple):
    """What a network has to learn: a function of points (n_point, n_input) in a box, with borders that are known."""

    output: Variable
    inputs: tuple[Variable, ...]
    function: Callable[[np.ndarray], np.ndarray]
    box: list[tuple[float, float]]
    edges: dict[Any, list[float]]
    high: float  # largest output


def circuit_targets(machine: Machine) -> dict[str, Target]:
    """Input flows of a machine: ``boom``, ``swing``, ``stick`` (of what the swing leaves), ``stick direct``."""
    exact = exact_flow(machine)
    travel, cuts = machine.spool.knots[-1], [machine.spool.deadband, machine.spool.bypass_closed]
    pressure = pressure_boxes(machine, machine.pumps.relief - BELOW_RELIEF)
    boom, series = machine.pumps.boom_flow, machine.pumps.series_flow
    both = [(0.0, travel), (0.0, travel), pressure["swing"], pressure["stick"]]
    edges = {"swing.travel": cuts, "stick.travel": cuts}
    stick_valve, pump = exact.valves.stick, exact.series_pump
    return {
        "boom": Target(
            *BOOM_IN, lambda X: input_flow(exact, X, ("boom",), "boom"), [(0.0, travel), pressure["boom"]],
            {"boom.travel": cuts}, boom,
        ),
        "swing": Target(
            q_in("swing"), BOTH, lambda X: input_flow(exact, X, CIRCUITS["series"], "swing"), both, edges, series
        ),
        "stick": Target(
            q_in("stick"), PASSED, lambda X: sample_fed(stick_valve, pump, X),
            [(0.0, series), (0.0, travel), pressure["stick"]], {"stick.travel": cuts}, series,
        ),
        "stick direct": Target(
            q_in("stick"), BOTH, lambda X: input_flow(exact, X, CIRCUITS["series"], "stick"), both, edges, series
        ),
    }  # fmt: skip


def learn_direct(machine: Machine, progress: Progress = quiet) -> list[Model]:
    """Network of the stick's input flow in the direct arrangement: all modes of the pump at once.

    Parameters
    ----------
    machine : Machine
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


def learn_outlets(machine: Machine) -> list[Model]:
    """Conductance of each outlet from the spool (Eq. 7)."""
    exact, spool = exact_flow(machine), machine.spool
    cuts = [-spool.bypass_closed, -spool.deadband, spool.deadband, spool.bypass_closed]
    models = []
    for place, link in enumerate(LINKS):
        valve = getattr(machine, link).valve
        high = max(valve.outlet_positive + valve.outlet_negative)

        def conductance(X: np.ndarray, place: int = place) -> np.ndarray:
            spools = np.zeros((len(X), 3))
            spools[:, place] = X[:, 0]
            return sample_flow(exact, spools, np.zeros((len(X), 3)), np.zeros((len(X), 3))).k_out[:, place]

        found = learn_from(
            conductance, [(-spool.knots[-1], spool.knots[-1])], tolerance=1e-3 * high, edges={0: cuts}, rows=300,
            estimator=AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, high)),
            inputs=(Variable(f"{link}.spool", "m"),), output=k_out(link), random_state=SEED,
        )  # fmt: skip
        models.append(found.model)
    return models


def train_perceptrons(machine: Machine) -> list[Model]:
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


def input_flow(exact: ExactFlow, X: np.ndarray, links: tuple[str, ...], which: str) -> np.ndarray:
    """Input flow of one link where `X` has the travels of `links` and then their pressures, and the rest stands still."""
    places = [LINKS.index(link) for link in links]
    spool, pressure = np.zeros((len(X), 3)), np.zeros((len(X), 3))
    spool[:, places], pressure[:, places] = X[:, : len(links)], X[:, len(links) :]
    return sample_flow(exact, spool, pressure, np.zeros((len(X), 3))).q_in[:, LINKS.index(which)]
