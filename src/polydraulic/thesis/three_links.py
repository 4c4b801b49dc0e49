"""Chapters 5 and 6: all three links. Runs with every flow model on the machine, with and without its torque limit."""

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.dispatch import build_flow
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.table import Network
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import load_scenario
from polydraulic.simulation.runs import simulate
from polydraulic.tables import Table
from polydraulic.thesis.boom_models import HISTORICAL, SEED, fit_boom
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import LINKS, PRESSURE_HIGH, with_pumps
from polydraulic.thesis.historical import flows_at, grow_outlets, grow_series, sections, series_flows
from polydraulic.thesis.timing import Time, restored, time_runs

SCENARIOS = ("sine", "step", "pulse", "task")
EPS = (0.001, 0.05, 0.1)  # Table 4
STEPS = 2600  # of 5 ms in 13 s
N_JUDGE, JUDGE_SEED = 200_000, 7  # points that judge a map; no network was trained on them


class ThreeLinkStudy:
    """Everything that the chapters on three links show, each computed when first asked for.

    A *kind* of flow model is "polynomial" (networks in the thesis' setting), "ours" (those that come with the package) or
    any other name of `build_flow`. `limited` asks for the machine whose pumps have a torque limit; there "polynomial" and
    "ours" are networks that never saw one, "polynomial with limit" and "ours with limit" those that did.
    """

    def __init__(self, lab: Lab) -> None:
        self.lab = lab

    def machine(self, limited: bool = False) -> LayoutMachine:
        """The machine, with or without its torque limit."""
        return with_pumps(self.lab.machine, torque_limit_enabled=limited)

    def historical(self, limited: bool = False) -> list[Model]:
        """Networks in the thesis' setting: input flow of swing and stick, outlets, and those of the boom."""

        def grow() -> list[Model]:
            self.lab.say("grow networks by section of Table 3")
            machine = self.machine(limited)
            boom = fit_boom(machine, np.random.default_rng(SEED), **HISTORICAL)
            return [*grow_series(machine), *grow_outlets(machine), boom.q_in, boom.q_out]

        return self.lab.computed.models(f"historical {'limited' if limited else 'constant'}", grow)

    def flow(self, kind: str, limited: bool = False, **options: Any) -> Any:
        """Build a flow model of a kind."""
        machine = self.machine(limited)
        if kind == "fine":
            return build_flow("polynomial-fine", machine)
        if kind.startswith("polynomial"):
            return build_flow("polynomial", machine, models=self.historical(kind.endswith("with limit")))
        if kind == "ours":
            return build_flow("polynomial", machine, models=shipped_models())
        if kind == "direct":
            return build_flow("polynomial", machine, models=shipped_models("direct"))
        if kind == "ours with limit":
            return build_flow("polynomial", machine)
        return build_flow(kind, machine, **options)

    def run(self, scenario: str, kind: str, limited: bool = False, **options: Any) -> Table:
        """Trajectory of a scenario."""
        settings = "".join(f" {name} {value}" for name, value in options.items())
        name = f"three {scenario} {kind}{settings}{' limited' if limited else ''}"
        return self.lab.computed.table(
            name,
            lambda: simulate(
                self.machine(limited), self.flow(kind, limited, **options), load_scenario(scenario), dt=5e-3
            ),
        )

    def runs(self, scenario: str, *kinds: str, limited: bool = False) -> dict[str, Table]:
        """Trajectories by kind."""
        return {kind: self.run(scenario, kind, limited) for kind in kinds}

    @cached_property
    def run_times(self) -> dict[str, Time]:
        """Run times of the task, by flow model, and ratios to the iteration with eps 0.05; "none" has flows that cost nothing."""

        def measured() -> dict[str, Time]:
            self.lab.say("run times of the task")
            timed = {f"iterative {eps}": self.flow("iterative", eps=eps) for eps in EPS}
            timed |= {kind: self.flow(kind) for kind in ("exact", "polynomial", "ours")}
            timed["none"] = build_flow("polynomial", self.machine(), models=constant_models())
            return time_runs(self.machine(), timed, load_scenario("task"), base="iterative 0.05")

        return restored(self.lab.computed.data("seconds three", measured))


def three_link_study(lab: Lab) -> ThreeLinkStudy:
    """Return the one study of a lab."""
    found: ThreeLinkStudy = lab.computed.memory.setdefault("three-link study", ThreeLinkStudy(lab))
    return found


def constant_models() -> list[Model]:
    """Networks without nodes, which answer zero: what is left of a run time is that of everything but the flows."""

    def nothing(output: str, *inputs: str) -> Model:
        n = len(inputs)
        network = Network((), (0.0,) * n, (1.0,) * n, (0.0,) * n, (1e9,) * n, 0.0, 1.0)
        return Model(tuple(Variable(name) for name in inputs), Variable(output), (network,))

    both = ("swing.travel", "stick.travel", "swing.p_in", "stick.p_in")
    return [
        nothing("boom.q_in", "boom.travel", "boom.p_in"),
        nothing("swing.q_in", *both),
        nothing("stick.q_in", *both),
        *(nothing(f"{link}.k_out", f"{link}.spool") for link in LINKS),
    ]


class SectionErrors(NamedTuple):
    """Flow errors over a section of Table 3 at points (swing travel, stick travel, swing p_in, stick p_in)."""

    X: np.ndarray  # (n_point, 4) SI
    swing: np.ndarray  # (n_point,) m3/s, networks less exact
    stick: np.ndarray


def section_maps(study: ThreeLinkStudy, X: np.ndarray) -> dict[str, np.ndarray]:
    """Input flows of swing and stick at points (n_point, 4): networks in the thesis' setting; m3/s."""
    swing, stick = study.historical()[:2]
    return {"swing": swing.predict(X), "stick": stick.predict(X)}


def section_errors(machine: LayoutMachine, section: str, flow: Any, *, relief: bool) -> SectionErrors:
    """Errors of a flow model at random points of a section, as many again on its faces, and its corners.

    Parameters
    ----------
    machine : LayoutMachine
    section : {"A", "B", "C", "D", "E"}
    flow : flow model
    relief : bool
        Whether the judge is the whole circuit, to the setting of the swing's line relief, or that of Eqs (8)-(13), from
        which the networks in the thesis' setting are grown.
    """
    box = sections(machine)[section]
    swing_high = min(PRESSURE_HIGH, machine.function("swing").line.relief) if relief else PRESSURE_HIGH
    edges = np.array([box.swing, box.stick, (0.0, swing_high), (0.0, PRESSURE_HIGH)])
    edges[:2, 0] *= 1.0 + 1e-9  # a border belongs to the section below it
    X = points_with_faces(edges, N_JUDGE, np.random.default_rng(JUDGE_SEED))
    errors = flows_at(machine, flow, X) - series_flows(machine, X, relief=relief)
    return SectionErrors(X, errors[:, 0], errors[:, 1])


def points_with_faces(box: np.ndarray, n: int, rng: np.random.Generator) -> np.ndarray:
    """`n` random points in a box (n_input, 2), `n` more on its faces, and its corners."""
    low, high = box.T
    inside = rng.uniform(low, high, size=(n, len(box)))
    on_faces = rng.uniform(low, high, size=(n, len(box)))
    axis, side = rng.integers(len(box), size=n), rng.integers(2, size=n)
    on_faces[np.arange(n), axis] = box[axis, side]
    corners = np.array(np.meshgrid(*box)).reshape(len(box), -1).T
    return np.vstack([inside, on_faces, corners])
