"""Networks of a whole machine from a log of its work: of each function an inlet by region, and an outlet."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.flow.layout.slots import inlet, outlet
from polydraulic.identification.machine.machine_log import BELOW_RELIEF, ROOT_LEAST, Known
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.growth.workers import in_processes, one_after_the_other
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.tables import Table

ROWS, REGIONS = 30_000, 16  # that a network learns from, and regions it may find
_SEED = 1000  # of the choice of rows
_SMALL = 0.03  # opening, as a share of the active travel, below which errors count alike
CELL = 60  # rows that a part of an outlet's curve needs
_LONG = 100_000  # rows times regions: with fewer, processes take longer to start than the fits take


class NetworkToLearn(NamedTuple):
    """A network that is to be learnt, and all that it is learnt from."""

    learner: RegionRegressor
    inputs: Sequence[Variable]
    output: Variable
    X: np.ndarray
    y: np.ndarray
    weight: np.ndarray | None


def tasks_of(
    machine: LayoutMachine, known: Known, log: Table, *, max_regions: int = REGIONS, max_rows: int = ROWS
) -> list[NetworkToLearn]:
    """Networks of circuits, to be learnt from measurements; what must be known is each pump's flow and relief setting, and where valves open.

    Parameters
    ----------
    machine : LayoutMachine
    known : Known
        Of the circuits.
    log : Table
        From `by_port`.
    max_regions : int
        That the network of an inlet may find.
    max_rows : int
        That a network learns from.
    """
    rng = np.random.default_rng(_SEED)
    tasks: list[NetworkToLearn] = []
    circuits = [machine.circuit(name) for name in known.circuits]
    for circuit, f in ((c, machine.function(name)) for c in circuits for name in c.functions):
        # what reaches a valve follows from measured flows where the pump's is constant, and is not known where torque limits it
        output, inputs = inlet(circuit, f.name)[-1 if circuit.pump.torque_limit_enabled else 0]
        # a flow model lets nothing in at relief, whatever a network says
        below = np.flatnonzero(log[f"{f.name}.p_in"] < BELOW_RELIEF * circuit.pump.relief)
        rows = below[_chosen(log[f"{f.name}.travel"][below] > spool_edges(f.valve)[0], max_rows, rng)]
        # holds where it has seen rows
        settings = AbductiveRegressor(max_layers=3, output_bounds=(0.0, circuit.pump.flow))
        learner = RegionRegressor(settings, max_regions=max_regions, min_rows=min(150, max(20, len(rows) // 40)))
        X = log.matrix([variable.name for variable in inputs])[rows]
        tasks.append(NetworkToLearn(learner, inputs, output, X, log[output.name][rows], None))
    return tasks + [_outlet_task(machine.function(name), log, max_rows, rng) for name in known.functions]


def learn(
    tasks: Sequence[tuple[NetworkToLearn, ...]], told: Callable[[int], object] = lambda done: None
) -> list[tuple[Model, ...]]:
    """Networks of tasks, side by side where they are long.

    Parameters
    ----------
    tasks : sequence of tuple of NetworkToLearn
        The same network from several sets of rows; regions that are found in the first are those of the others.
    told : function of int
        Told how many are done.
    """
    work = sum(len(task.y) * task.learner.max_regions for task, *_ in tasks)
    return (in_processes if work >= _LONG else one_after_the_other)(_learn, tasks, told)


def _learn(tasks: tuple[NetworkToLearn, ...]) -> tuple[Model, ...]:
    first, found = tasks[0].learner, list[Model]()
    for task in tasks:
        again = task is not tasks[0] and first.edges is None
        fitted = (first.refitted if again else task.learner.fit)(task.X, task.y, task.weight)
        found.append(fitted.to_model(task.inputs, task.output))
    return tuple(found)


def _outlet_task(f: MachineFunction, log: Table, max_rows: int, rng: np.random.Generator) -> NetworkToLearn:
    """Conductance of an outlet over the spool: a cubic in each part of its travel that was visited."""
    rows = rng.permutation(np.flatnonzero(log[f"{f.name}.root_p_out"] > ROOT_LEAST))[:max_rows]
    spool, y = log[f"{f.name}.spool"][rows], log[f"{f.name}.k_out"][rows]
    (opens, shut), end = spool_edges(f.valve), f.valve.knots[-1]
    shut = shut if shut < end else 0.5 * (opens + end)  # of a bypass that never shuts
    borders = [opens, 0.5 * (opens + shut), shut, 0.5 * (shut + end)]
    # beyond the travel that was seen, the last value holds
    settings = AbductiveRegressor(max_layers=1, kinds=("single",), output_bounds=(0.0, float(np.quantile(y, 0.9999))))
    edges = visited([-border for border in reversed(borders)] + borders, spool)
    # a conductance spans three decades, and near the deadband a small one decides as much as a large one does elsewhere
    opening = np.maximum(np.abs(spool) - opens, 0.0) / (end - opens)
    learner = RegionRegressor(settings, edges={0: edges} if edges else None, max_regions=1)
    output, inputs = outlet(f.name)[0]
    return NetworkToLearn(learner, inputs, output, spool[:, None], y, 1.0 / (_SMALL + opening) ** 2)


def visited(borders: Sequence[float], values: np.ndarray) -> list[float]:
    """Those of rising borders that leave at least `CELL` values on either side, up to the next one that is kept."""
    kept: list[float] = []
    low = -np.inf
    for border in borders:
        if np.sum((values > low) & (values <= border)) >= CELL:
            kept.append(border)
            low = border
    while kept and np.sum(values > kept[-1]) < CELL:
        kept.pop()
    return kept


def _chosen(active: np.ndarray, max_rows: int, rng: np.random.Generator) -> np.ndarray:
    """Rows to learn from: those with an open valve say most."""
    on, off = np.flatnonzero(active), np.flatnonzero(~active)
    return np.concatenate([rng.permutation(on)[:max_rows], rng.permutation(off)[: max_rows // 5]])
