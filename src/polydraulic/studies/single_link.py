"""Chapters 3 and 4: the boom alone. Computes everything that their figures and numbers need.

The polynomial networks of the thesis are grown here with its own setting (`HISTORICAL`), the ones of this package with
its default setting; both are judged on a dense grid that includes faces and corners, and on the two printed voltages, for which
nothing was trained or chosen.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from polydraulic import units
from polydraulic.flow import build_flow
from polydraulic.networks import AbductiveRegressor, Variable
from polydraulic.parameters import Machine, Scenario, Signal, Sine, load_scenario
from polydraulic.simulation import reference, simulate
from polydraulic.studies.boom_models import HISTORICAL, SEED, BoomModels, fit_boom
from polydraulic.studies.database import PRESSURE_HIGH, boom_flow, boom_table, sample_boom
from polydraulic.studies.timing import time_runs
from polydraulic.tables import Table

SCENARIOS = ("single_08", "single_05")
N_FULL_BOX = 4000  # KP = 25.0 with K = 26 and CPM = 1 means N = 3985
N_STATISTICS = 1_000_000  # so many that the database's statistics are those of the map
N_GRID = 401
FULL_TRAVEL_VOLTAGE = 1.3
STEP_SIZES = (0.02, 0.01, 0.005, 0.0025, 0.00125)

Progress = Callable[[str], None]


@dataclass(frozen=True)
class FullBoxNetwork:
    """The network of Fig 3-1, input flow over the whole active box without regions, and a large database of that box."""

    statistics: Table
    estimator: AbductiveRegressor
    inputs: tuple[Variable, ...]


@dataclass(frozen=True)
class BoomStudy:
    """Everything the chapters show.

    Attributes
    ----------
    machine : Machine
    full_box : FullBoxNetwork
    historical, ours : BoomModels
    grid : Table
        The exact circuit without relief valve on a dense grid: both signs of the spool, p_in = p_out.
    runs : dict from scenario to dict from flow model to trajectory
        Flow models "exact", "iterative", "polynomial", "pressure" (historical networks), "ours".
    full_travel : the same for one scenario that opens the valve fully
    convergence : Table
        Largest joint error of the loop against the tight solution, by step size.
    seconds : dict from flow model to median seconds for single_08
    """

    machine: Machine
    full_box: FullBoxNetwork
    historical: BoomModels
    ours: BoomModels
    grid: Table
    runs: dict[str, dict[str, Table]]
    full_travel: dict[str, Table]
    convergence: Table
    seconds: dict[str, float]


STAGES = ("grow networks", "evaluate maps", "simulate", "converge", "measure run times")


def boom_study(machine: Machine, progress: Progress = lambda stage: None) -> BoomStudy:
    """Compute the study; `progress` is called with each of `STAGES` as it begins."""
    progress(STAGES[0])
    full_box = fit_full_box(machine)
    historical = fit_boom(machine, np.random.default_rng(SEED), **HISTORICAL)
    ours = fit_boom(machine, np.random.default_rng(SEED))

    progress(STAGES[1])
    grid = boom_grid(machine, N_GRID, N_GRID)

    progress(STAGES[2])
    models = {
        "exact": build_flow("exact", machine),
        "iterative": build_flow("iterative", machine),
        "polynomial": build_flow("polynomial", machine, models=list(historical)),
        "ours": build_flow("polynomial", machine, models=list(ours)),
        "pressure": build_flow("pressure", machine, models=list(historical)),
    }
    scenarios = {name: load_scenario(name) for name in SCENARIOS}
    runs = {
        name: {kind: simulate(machine, model, scenario) for kind, model in models.items()}
        for name, scenario in scenarios.items()
    }
    fully = full_travel(scenarios["single_08"])
    full = {kind: simulate(machine, models[kind], fully) for kind in ("exact", "pressure", "polynomial")}

    progress(STAGES[3])
    convergence = converge(machine, scenarios)

    progress(STAGES[4])
    timed = {kind: models[kind] for kind in ("iterative", "exact", "polynomial", "ours")}
    timed["iterative 0.001"] = build_flow("iterative", machine, eps=0.001)
    seconds = time_runs(machine, timed, scenarios["single_08"])
    return BoomStudy(machine, full_box, historical, ours, grid, runs, full, convergence, seconds)


def fit_full_box(machine: Machine) -> FullBoxNetwork:
    """Grow the network of Fig 3-1 in the thesis' units, with its setting."""
    spool = machine.spool
    active = (spool.deadband, spool.knots[-1])
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


def boom_grid(machine: Machine, n_spool: int, n_pressure: int) -> Table:
    """Evaluate the exact circuit on a grid that includes the faces; pressures vary slowest."""
    travel = machine.spool.knots[-1]
    spool, pressure = np.meshgrid(np.linspace(-travel, travel, n_spool), np.linspace(0.0, PRESSURE_HIGH, n_pressure))
    return boom_table(machine, spool.ravel(), pressure.ravel(), pressure.ravel(), relief=False)


def full_travel(scenario: Scenario) -> Scenario:
    """Return the same sine with a voltage that takes the spool to 0.54 in."""
    signal = scenario.voltage["boom"]
    assert isinstance(signal, Sine)
    voltage: dict[str, Signal] = {"boom": replace(signal, amplitude=FULL_TRAVEL_VOLTAGE)}
    return replace(scenario, name="full travel", voltage=voltage, duration=5.0)


def map_error(models: BoomModels, grid: Table, output: str) -> np.ndarray:
    """Network minus exact at every grid point, in SI."""
    model = getattr(models, output.removeprefix("boom."))
    return model.predict(grid.matrix([variable.name for variable in model.inputs])) - grid[output]


def pressure_flow_error(study: BoomStudy) -> np.ndarray:
    """Input flow from the pump-pressure networks through Eq. (1), minus exact, at every grid point, in SI."""
    model = build_flow("pressure", study.machine, models=[study.historical.p_pump])
    grid = study.grid
    return boom_flow(model, grid["boom.spool"], grid["boom.p_in"], grid["boom.p_out"]).q_in - grid["boom.q_in"]


def converge(machine: Machine, scenarios: dict[str, Scenario]) -> Table:
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
