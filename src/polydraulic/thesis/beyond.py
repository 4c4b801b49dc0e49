"""Beyond the thesis: what each idea brings, every flow model side by side, and random operators."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.flow.dispatch import build_flow
from polydraulic.flow.lookup import table_bytes
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model.model import Model
from polydraulic.networks.proof.bounds import check_range
from polydraulic.parameters.scenario import load_scenario, random_operator
from polydraulic.simulation.batch.batch import simulate_batch
from polydraulic.simulation.layout.columns import EFFECTOR
from polydraulic.simulation.runs import simulate
from polydraulic.simulation.trajectory import effector_distance
from polydraulic.thesis.boom_models import HISTORICAL, SEED, fit_boom
from polydraulic.thesis.excavator import PRESSURE_HIGH, boom_flow, spool_of
from polydraulic.thesis.historical import grow_outlets, grow_series
from polydraulic.thesis.three_links import (
    JUDGE_SEED,
    N_JUDGE,
    SCENARIOS,
    ThreeLinkStudy,
    points_with_faces,
    section_errors,
)
from polydraulic.thesis.timing import Ratio, time_runs

N_OPERATORS, OPERATOR_SECONDS = 200, 60.0
FLOWS = ("exact", "iterative", "stiff", "tlm", "lookup", "polynomial", "ours", "fine", "direct", "neural")
BY_OPERATORS = ("iterative", "lookup", "polynomial", "ours", "fine", "neural")
# The thesis' setting, and what is added to it, one by one; the last is the learner's own setting.
IDEAS: dict[str, dict[str, Any]] = {
    "thesis' setting": HISTORICAL,
    "+ adaptive prior": HISTORICAL | {"prior_variance": "adaptive"},
    "+ carving": HISTORICAL | {"prior_variance": "adaptive", "carve": True},
    "+ refinement": HISTORICAL | {"prior_variance": "adaptive", "carve": True, "refine": True},
    "+ leave-one-out": {},
}


class Rung(NamedTuple):
    """What networks of one setting reach: errors in section D (rms, largest) in in3/s, end-effector errors in m."""

    coefficients: int
    swing: list[float]
    stick: list[float]
    tip: dict[str, float]


def ablation(study: ThreeLinkStudy) -> dict[str, Rung]:
    """Networks by the sections of Table 3 with one more idea each, then the package's with regions that were found."""

    def made() -> dict[str, Any]:
        found = {}
        for idea, settings in IDEAS.items():
            study.lab.say(f"ablation: {idea}")
            found[idea] = _climb(study, _by_section(study, settings), relief=False)
        shipped = {
            "+ regions found, pump modes": "direct",
            "+ cascade": "cascade",
            "+ borders at all knots, more regions": "fine",
        }
        for idea, networks in shipped.items():
            found[idea] = _climb(study, shipped_models(networks), relief=True)
        return found

    return {idea: Rung(*values) for idea, values in study.lab.computed.data("ablation", made).items()}


def _by_section(study: ThreeLinkStudy, settings: dict[str, Any]) -> list[Model]:
    machine = study.machine()
    boom = fit_boom(machine, np.random.default_rng(SEED), **settings)
    return [*grow_series(machine, settings), *grow_outlets(machine, settings), boom.q_in, boom.q_out]


def _climb(study: ThreeLinkStudy, models: list[Model], *, relief: bool) -> Rung:
    machine = study.machine()
    flow = build_flow("polynomial", machine, models=models)
    errors = section_errors(machine, "D", flow, relief=relief)
    swing, stick = (
        [units.from_si(float(size), "in3/s") for size in (np.sqrt(np.mean(error**2)), np.abs(error).max())]
        for error in (errors.swing, errors.stick)
    )
    tip = {
        name: float(
            effector_distance(study.run(name, "exact"), simulate(machine, flow, load_scenario(name), dt=5e-3)).max()
        )
        for name in SCENARIOS
    }
    return Rung(sum(model.n_coefficients for model in models), swing, stick, tip)


class Cost(NamedTuple):
    """A flow model's time per step as a share of that of exact, and the bytes of its arrays."""

    time: Ratio
    memory: int


def costs(study: ThreeLinkStudy) -> dict[str, Cost]:
    """Time and memory of every flow model, measured on the task."""

    def measured() -> dict[str, Any]:
        study.lab.say("run times of every flow model")
        models = {kind: study.flow(kind) for kind in FLOWS}
        times = time_runs(study.machine(), models, load_scenario("task"), base="exact")
        return {kind: [times[kind].ratio, table_bytes(models[kind].parts)] for kind in FLOWS}

    found = study.lab.computed.data("costs", measured)
    return {kind: Cost(Ratio(*time), memory) for kind, (time, memory) in found.items()}


def tip_errors(study: ThreeLinkStudy) -> dict[str, dict[str, float]]:
    """Largest end-effector error in m by flow model and scenario."""
    return {
        kind: {
            name: float(effector_distance(study.run(name, "exact"), study.run(name, kind)).max()) for name in SCENARIOS
        }
        for kind in FLOWS
    }


def operator_errors(study: ThreeLinkStudy) -> dict[str, list[float]]:
    """Largest end-effector errors in m of random operators, rising, by flow model."""

    def made() -> dict[str, list[float]]:
        operators = [random_operator(seed, OPERATOR_SECONDS) for seed in range(N_OPERATORS)]
        found: dict[str, list[float]] = {}
        exact = _tips(study, "exact", operators)
        for kind in BY_OPERATORS:
            study.lab.say(f"random operators: {kind}")
            away = np.linalg.norm(_tips(study, kind, operators) - exact, axis=2)
            found[kind] = sorted(float(value) for value in away.max(axis=1))
        return found

    errors: dict[str, list[float]] = study.lab.computed.data("operators", made)
    return errors


def _tips(study: ThreeLinkStudy, kind: str, operators: list[Any]) -> np.ndarray:
    """End-effectors (n_operator, n_time, 3) in m, every tenth of a second."""
    batch = simulate_batch(
        study.machine(), study.flow(kind), operators, keep=["rows"], columns=list(EFFECTOR), every=20
    )
    return np.stack([batch[name] for name in EFFECTOR], axis=2)


class Range(NamedTuple):
    """Outputs of a network over its whole domain, in in3/s: proved, and found at random points without the final clamp."""

    proved: list[float]
    unclamped: list[float]


def output_ranges(study: ThreeLinkStudy) -> dict[str, Range]:
    """Ranges of all input-flow networks: in the thesis' setting, of the package in both arrangements, perceptrons."""
    sets = {
        "polynomial": study.historical(),
        "ours": shipped_models(limited=True),
        "fine": shipped_models("fine"),
        "direct": [
            model for model in shipped_models("direct") if model.output.name == "stick.q_in"
        ],  # all else is shared
        "neural": shipped_models("neural"),
    }

    def found() -> dict[str, Any]:
        ranges = {}
        for kind, models in sets.items():
            for model in (model for model in models if ".q_in" in model.output.name):
                study.lab.say(f"ranges: {kind} {model.output.name}")
                ranges[f"{kind} {model.output.name}"] = [_proved(model), _at_random(_unclamped(model))]
        return ranges

    return {name: Range(*values) for name, values in study.lab.computed.data("ranges", found).items()}


def _proved(model: Model) -> list[float]:
    low, high = (
        float(pick([getattr(n, end) for n in model.networks])) for pick, end in ((min, "y_low"), (max, "y_high"))
    )
    check = check_range(model, low, high, max_boxes=200)
    return [units.from_si(end, "in3/s") for end in (check.low, check.high)]


def _at_random(model: Model) -> list[float]:
    X = points_with_faces(model.domain(), N_JUDGE, np.random.default_rng(JUDGE_SEED))
    y = units.from_si(model.predict(X), "in3/s")
    return [float(y.min()), float(y.max())]


def _unclamped(model: Model) -> Model:
    return replace(model, networks=tuple(replace(n, y_low=-np.inf, y_high=np.inf) for n in model.networks))


class MapError(NamedTuple):
    """Errors over a map in in3/s."""

    largest: float
    rms: float


def map_errors(study: ThreeLinkStudy, kind: str = "ours") -> dict[str, MapError]:
    """Errors of networks of the package: the boom's input flow, swing and stick in section D; relief valves included."""

    def found() -> dict[str, Any]:
        machine, flow = study.machine(), study.flow(kind)
        series = section_errors(machine, "D", flow, relief=True)
        box = np.array([(0.0, spool_of(machine).end), (0.0, PRESSURE_HIGH)])
        X = points_with_faces(box, N_JUDGE, np.random.default_rng(JUDGE_SEED))
        exact, ours = (boom_flow(machine, model, X[:, 0], X[:, 1], X[:, 1]).q_in for model in ("exact", flow))
        errors = {"boom": ours - exact, "swing in D": series.swing, "stick in D": series.stick}
        return {name: [units.from_si(float(size), "in3/s") for size in (np.abs(e).max(), np.sqrt(np.mean(e**2)))] for name, e in errors.items()}  # fmt: skip

    return {name: MapError(*values) for name, values in study.lab.computed.data(f"map errors {kind}", found).items()}
