"""Chapters 3 and 4: the boom alone. Computes everything that their figures and numbers need.

The polynomial networks of the thesis are grown here with its own setting (`HISTORICAL`), the ones of this package with
its default setting; both are judged on a dense grid that includes faces and corners, and on the two printed voltages, for which
nothing was trained or chosen.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.flow.dispatch import build_flow
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Variable
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario, load_scenario
from polydraulic.parameters.signals import Signal, Sine
from polydraulic.simulation.runs import reference, simulate
from polydraulic.tables import Table
from polydraulic.thesis.boom_models import HISTORICAL, SEED, BoomModels, fit_boom
from polydraulic.thesis.boom_perceptrons import PerceptronModels, fit_perceptrons, sweep_hidden_units
from polydraulic.thesis.cache import Lab
from polydraulic.thesis.excavator import PRESSURE_HIGH, boom_flow, boom_table, sample_boom, spool_of
from polydraulic.thesis.timing import Time, restored, time_runs

SCENARIOS = ("single_08", "single_05")
N_FULL_BOX = 4000  # KP = 25.0 with K = 26 and CPM = 1 means N = 3985
N_STATISTICS = 1_000_000  # so many that the database's statistics are those of the map
N_GRID = 401
FULL_TRAVEL_VOLTAGE = 1.3
STEP_SIZES = (0.02, 0.01, 0.005, 0.0025, 0.00125)

# "polynomial" and "pressure" are networks in the thesis' setting, "ours" in this package's.
KINDS = ("exact", "iterative", "polynomial", "ours", "neural", "pressure")


@dataclass(frozen=True)
class FullBoxNetwork:
    """The network of Fig 3-1, input flow over the whole active box without regions, and a large database of that box."""

    statistics: Table
    estimator: AbductiveRegressor
    inputs: tuple[Variable, ...]


class BoomStudy:
    """Everything that chapters 3 and 4 show, each computed when first asked for."""

    def __init__(self, lab: Lab) -> None:
        self.lab, self.machine = lab, lab.machine

    @cached_property
    def full_box(self) -> FullBoxNetwork:
        """Network and database of Fig 3-1."""
        self.lab.say("network over the whole box")
        return fit_full_box(self.machine)

    @cached_property
    def historical(self) -> BoomModels:
        """Networks in the thesis' setting."""
        return self._boom_models("boom historical", **HISTORICAL)

    @cached_property
    def ours(self) -> BoomModels:
        """Networks in this package's setting."""
        return self._boom_models("boom ours")

    def _boom_models(self, name: str, **settings: Any) -> BoomModels:
        def grow() -> BoomModels:
            self.lab.say("grow networks of the boom")
            return fit_boom(self.machine, np.random.default_rng(SEED), **settings)

        return BoomModels(*self.lab.computed.models(name, grow))

    @cached_property
    def perceptrons(self) -> PerceptronModels:
        """Perceptrons of section 4.3."""

        def train() -> PerceptronModels:
            self.lab.say("train perceptrons")
            return fit_perceptrons(self.machine, np.random.default_rng(SEED))

        return PerceptronModels(*self.lab.computed.models("boom perceptrons", train))

    @cached_property
    def sweep(self) -> Table:
        """Training error over the number of hidden units."""

        def train() -> Table:
            self.lab.say("hidden-unit sweep")
            return sweep_hidden_units(self.machine, np.random.default_rng(SEED))

        return self.lab.computed.table("hidden units", train)

    @cached_property
    def grid(self) -> Table:
        """The exact circuit on a dense grid."""
        return boom_grid(self.machine, N_GRID, N_GRID)

    def run(self, scenario: str, kind: str) -> Table:
        """Trajectory of a printed voltage with a flow model: one of `KINDS`."""
        return self.lab.computed.table(
            f"run {scenario} {kind}", lambda: simulate(self.machine, self._flow(kind), load_scenario(scenario))
        )

    def runs(self, scenario: str, *kinds: str) -> dict[str, Table]:
        """Trajectories by flow model."""
        return {kind: self.run(scenario, kind) for kind in kinds}

    @cached_property
    def full_travel(self) -> dict[str, Table]:
        """Trajectories that open the valve fully, by flow model."""
        scenario = full_travel(load_scenario("single_08"))
        return {
            kind: simulate(self.machine, self._flow(kind), scenario) for kind in ("exact", "pressure", "polynomial")
        }

    @cached_property
    def convergence(self) -> Table:
        """Largest joint errors by step size."""

        def made() -> Table:
            self.lab.say("convergence of the loop")
            return converge(self.machine, {name: load_scenario(name) for name in SCENARIOS})

        return self.lab.computed.table("convergence", made)

    @cached_property
    def run_times(self) -> dict[str, Time]:
        """Run times of single_08, by flow model, and ratios to the iteration."""

        def measured() -> dict[str, Time]:
            self.lab.say("run times")
            timed = {kind: self._flow(kind) for kind in KINDS if kind != "pressure"}
            timed["iterative 0.001"] = build_flow("iterative", self.machine, eps=0.001)
            return time_runs(self.machine, timed, load_scenario("single_08"), base="iterative")

        return restored(self.lab.computed.data("seconds boom", measured))

    def _flow(self, kind: str) -> Any:
        if kind == "polynomial":
            return build_flow("polynomial", self.machine, models=list(self.historical))
        if kind == "ours":
            return build_flow("polynomial", self.machine, models=list(self.ours))
        if kind == "pressure":
            return build_flow("pressure", self.machine, models=list(self.historical))
        if kind == "neural":
            return build_flow("neural", self.machine, models=list(self.perceptrons))
        return build_flow(kind, self.machine)


def boom_study(lab: Lab) -> BoomStudy:
    """Return the one study of a lab."""
    found: BoomStudy = lab.computed.memory.setdefault("boom study", BoomStudy(lab))
    return found


def fit_full_box(machine: LayoutMachine) -> FullBoxNetwork:
    """Grow the network of Fig 3-1 in the thesis' units, with its setting."""
    spool = spool_of(machine)
    active = (spool.deadband, spool.end)
    names = ("boom.travel", "boom.p_in", "boom.q_in")
    many, few = (
        field_table(sample_boom(machine, n, rng=np.random.default_rng(SEED), travel=active, relief=False), names)
        for n in (N_STATISTICS, N_FULL_BOX)
    )
    inputs = tuple(Variable(name, few.unit(name)) for name in names[:2])
    estimator = AbductiveRegressor(**HISTORICAL).fit(few.matrix(names[:2]), few["boom.q_in"])
    return FullBoxNetwork(many, estimator, inputs)


def field_table(table: Table, names: tuple[str, ...]) -> Table:
    """Columns of a boom table in inch, psi and in3/s."""
    field = {"m": "in", "Pa": "psi", "m3/s": "in3/s", "Pa^0.5": "psi^0.5"}
    chosen = {name: field[table.unit(name)] for name in names}
    return Table({name: units.from_si(table[name], unit) for name, unit in chosen.items()}, chosen)


def boom_grid(machine: LayoutMachine, n_spool: int, n_pressure: int) -> Table:
    """Evaluate the exact circuit on a grid that includes the faces; pressures vary slowest."""
    travel = spool_of(machine).end
    spool, pressure = np.meshgrid(np.linspace(-travel, travel, n_spool), np.linspace(0.0, PRESSURE_HIGH, n_pressure))
    return boom_table(machine, spool.ravel(), pressure.ravel(), pressure.ravel(), relief=False)


def full_travel(scenario: Scenario) -> Scenario:
    """Return the same sine with a voltage that takes the spool to 0.54 in."""
    signal = scenario.voltage["boom"]
    assert isinstance(signal, Sine)
    voltage: dict[str, Signal] = {"boom": replace(signal, amplitude=FULL_TRAVEL_VOLTAGE)}
    return replace(scenario, name="full travel", voltage=voltage, duration=5.0)


def map_error(models: BoomModels | PerceptronModels, grid: Table, output: str) -> np.ndarray:
    """Network minus exact at every grid point, in SI."""
    model = getattr(models, output.removeprefix("boom."))
    return model.predict(grid.matrix([variable.name for variable in model.inputs])) - grid[output]


def output_map_error(models: BoomModels | PerceptronModels, study: BoomStudy) -> np.ndarray:
    """Output flow minus exact at every grid point, in SI, of networks that give it or the conductance it follows from."""
    if isinstance(models, BoomModels):
        return map_error(models, study.grid, "boom.q_out")
    conductance = models.k_out.predict(study.grid.matrix(["boom.spool"]))
    return np.maximum(conductance, 0.0) * study.grid["boom.root_p_out"] - study.grid["boom.q_out"]


def outlet_conductance(machine: LayoutMachine, spool: np.ndarray) -> np.ndarray:
    """Q_pop(x) = Q_o / sqrt(P_o - P_e) of the boom's valve, in m3/s/Pa^0.5 (Eq. 7)."""
    table = boom_table(machine, spool, np.zeros(len(spool)), np.full(len(spool), PRESSURE_HIGH), relief=False)
    return np.asarray(table["boom.q_out"] / table["boom.root_p_out"])


def pressure_flow_error(study: BoomStudy) -> np.ndarray:
    """Input flow from the pump-pressure networks through Eq. (1), minus exact, at every grid point, in SI."""
    model = build_flow("pressure", study.machine, models=[study.historical.p_pump])
    grid = study.grid
    return (
        boom_flow(study.machine, model, grid["boom.spool"], grid["boom.p_in"], grid["boom.p_out"]).q_in
        - grid["boom.q_in"]
    )


def converge(machine: LayoutMachine, scenarios: dict[str, Scenario]) -> Table:
    """Largest joint angle error of the loop against the tight solution, for falling step sizes."""
    errors: dict[str, np.ndarray] = {}
    raster = STEP_SIZES[0]
    for name, scenario in scenarios.items():
        tight = reference(machine, "exact", scenario, dt=raster)["boom.angle"]
        angles = [
            simulate(machine, "exact", scenario, dt=dt, every=round(raster / dt))["boom.angle"] for dt in STEP_SIZES
        ]
        errors[name] = np.degrees([np.max(np.abs(angle - tight)) for angle in angles])
    return Table({"dt": np.array(STEP_SIZES), **errors}, {"dt": "s", **dict.fromkeys(errors, "deg")})
