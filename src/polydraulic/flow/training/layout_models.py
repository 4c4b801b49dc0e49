"""Networks of the circuits of any machine, learnt from their exact equations, by the mode of the pump.

As `mode_models`, for any number of valves: what enters the first valve, and what passes it, at constant flow, with the relief valve open
and at the torque limit; then each valve behind it, from the flow that reaches it. Where the orifices of a valve open and its bypass
closes is known; all other borders are found.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from sklearn.base import clone

from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.database import chosen_circuits, outlet_at
from polydraulic.flow.layout.slots import inlet, inlet_limited, outlet, passed_at_relief, passed_limited
from polydraulic.flow.network_slots import Place, k_in
from polydraulic.machine.pump import NEVER, Pump, limited_pump
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model
from polydraulic.networks.regions.learn_from import learn_from
from polydraulic.parameters.layout.parts import MachineFunction, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.progress import Progress, quiet

SEED = 215
_SINGLE = AbductiveRegressor(max_layers=1, kinds=("single",))
_ALWAYS_OPEN = 1e3  # times its flow, a pump's relief valve is open at any spool travel
_UP_TO = 16.0  # times its flow, the law of the torque limit goes on below its start: no flow of interest meets that end
_LEAST = 1e-9  # of a pump's flow: what reaches a valve behind others, at least, so that pressures are known


class TrainingEffort(NamedTuple):
    """How well networks of inlets are learnt.

    Attributes
    ----------
    tolerance : float
        Largest error that is looked for, as a share of the pump's flow.
    regions : int
        Maximum number of regions of a network.
    rows : int
        Points from which a region learns.
    """

    tolerance: float = 1e-3
    regions: int = 64
    rows: int = 1500


class NetworkTarget(NamedTuple):
    """What a network has to learn: a function of points (n_point, n_input) in a box, with borders that are known."""

    place: Place
    function: Callable[[np.ndarray], np.ndarray]
    box: list[tuple[float, float]]
    edges: dict[int, list[float]]


def train_layout(
    machine: LayoutMachine | str | Path,
    *,
    circuits: Sequence[str] | None = None,
    effort: TrainingEffort | None = None,
    progress: Progress = quiet,
) -> list[Model]:
    """Networks for the flow model ``"polynomial"`` of a machine, learnt from its exact circuits.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    circuits : sequence of str, optional
        Which of them; all if not given.
    effort : TrainingEffort, optional
        How well they are learnt.
    progress : Progress, optional
        Told the output and its largest error so far in m3/s, and how many networks are done.

    Returns
    -------
    list of Model
        The largest error that was found of each stands in its ``training``.

    Raises
    ------
    InputError
        If there is no such circuit, or it is not one of valves in series.
    """
    machine = as_machine(machine)
    effort = TrainingEffort() if effort is None else effort
    chosen = chosen_circuits(machine, circuits)
    work: list[TargetTask] = []
    for c in chosen:
        work += [outlet_task(machine.function(name)) for name in c.functions]
        first = machine.function(c.functions[0])
        high = max(first.valve.inlet)
        work.append(TargetTask(_first_conductance(first), 1e-5 * high, high, _SINGLE, 300, 64))
        for target in _inlets(machine, c):
            tolerance = effort.tolerance * c.pump.flow
            estimator = AbductiveRegressor(max_layers=3)
            work.append(TargetTask(target, tolerance, c.pump.flow, estimator, effort.rows, effort.regions))
    models = []
    for done, task in enumerate(work):

        def told(what: str, asked: int, most: int, name: str = task.target.place[0].name, done: int = done) -> None:
            progress(f"{name}: {what}, {asked} points", done, len(work))

        told("begins", 0, 0)
        models.append(learn_target(task, told))
    return models


class TargetTask(NamedTuple):
    """A target, how well it is to be learnt, and its largest value."""

    target: NetworkTarget
    tolerance: float
    high: float
    estimator: AbductiveRegressor
    rows: int
    regions: int


def learn_target(task: TargetTask, progress: Progress = quiet) -> Model:
    """Learn a network."""
    output, inputs = task.target.place
    return learn_from(
        task.target.function,
        task.target.box,
        tolerance=task.tolerance,
        edges=affordable(task.target.edges, task.regions),
        budget=10_000_000,
        max_regions=task.regions,
        rows=task.rows,
        estimator=clone(task.estimator).set_params(output_bounds=(0.0, task.high)),
        inputs=inputs,
        output=output,
        random_state=SEED,
        progress=progress,
    ).model


def affordable(edges: dict[int, list[float]], regions: int) -> dict[int, list[float]]:
    """Known borders of so many inputs, counted from the pump, that their cells are at most `regions`."""
    found: dict[int, list[float]] = {}
    cells = 1
    for axis, cuts in edges.items():
        cells *= len(cuts) + 1
        if cuts and cells <= regions:
            found[axis] = cuts
    return found


def cuts_of(f: MachineFunction, *, closing: bool = True) -> list[float]:
    """Travels inside the range of a spool at which its valve opens, and at which its bypass closes."""
    opens, closes = spool_edges(f.valve)
    return [x for x in (opens, *([closes] if closing else [])) if 0.0 < x < f.valve.knots[-1]]


def outlet_task(f: MachineFunction) -> TargetTask:
    """The conductance of an outlet, of the spool."""
    full, cuts = f.valve.knots[-1], cuts_of(f)
    edges = sorted([*(-x for x in cuts), *cuts])
    target = NetworkTarget(outlet(f.name)[0], lambda X: outlet_at(f.valve, X[:, 0]), [(-full, full)], {0: edges})
    high = max(f.valve.outlet_positive + f.valve.outlet_negative)
    return TargetTask(target, 1e-3 * high, high, _SINGLE, 300, 64)


def _first_conductance(f: MachineFunction) -> NetworkTarget:
    full = f.valve.knots[-1]
    return NetworkTarget(
        k_in(f.name), lambda X: np.interp(X[:, 0], f.valve.knots, f.valve.inlet), [(0.0, full)], {0: cuts_of(f)}
    )


def _inlets(machine: LayoutMachine, c: SupplyCircuit) -> list[NetworkTarget]:
    functions = [machine.function(name) for name in c.functions]
    valves, n, flow = [f.valve for f in functions], len(functions), c.pump.flow
    free, relief, at_limit = _modes(machine, c)
    travel = [(0.0, f.valve.knots[-1]) for f in functions]
    pressure = [(0.0, min(f.line.relief, c.pump.relief)) for f in functions]
    edges = {k: cuts_of(f) for k, f in enumerate(functions)}
    # past the closing of the first bypass nothing is passed on
    open_travel = [(0.0, min(spool_edges(valves[0])[1], travel[0][1])), *travel[1:]]
    open_edges = {**edges, 0: cuts_of(functions[0], closing=False)}

    def entering(pump: Pump) -> Callable[[np.ndarray], np.ndarray]:
        return lambda X: np.minimum(sample_valves(valves, pump, X[:, :n], X[:, n:]).q_in[:, 0], flow)

    def passing(pump: Pump) -> Callable[[np.ndarray], np.ndarray]:
        return lambda X: np.minimum(sample_valves(valves, pump, X[:, :n], X[:, n:]).q_passed[:, 0], flow)

    def behind(X: np.ndarray) -> np.ndarray:
        """The pressure behind the first valve does not matter while the relief valve is open."""
        return passing(relief)(np.insert(X, n, 0.0, axis=1))

    found = [NetworkTarget(inlet(c, c.functions[0])[-1], entering(free), [*travel, *pressure], edges)]
    if c.pump.torque_limit_enabled:
        found.append(NetworkTarget(inlet_limited(c, c.functions[0]), entering(at_limit), [*travel, *pressure], edges))
    if n > 1:
        found.append(NetworkTarget(passed_at_relief(c), behind, [*open_travel, *pressure[1:]], open_edges))
        if c.pump.torque_limit_enabled:
            found.append(NetworkTarget(passed_limited(c), passing(at_limit), [*open_travel, *pressure], open_edges))
    found += [fed_target(machine, c, place, c.pump.relief) for place in range(1, n)]
    return found


def fed_target(
    machine: LayoutMachine, c: SupplyCircuit, place: int, highest: float, relief: float = NEVER
) -> NetworkTarget:
    """An inlet behind others, counted from 0, from the flow that reaches its valve; pressures up to the `highest` in Pa.

    A `relief` setting in Pa takes of that flow where what passes the valves before it knows nothing of the pump's.
    """
    functions = [machine.function(name) for name in c.functions[place:]]
    valves, rest, flow = [f.valve for f in functions], len(functions), c.pump.flow
    free = limited_pump(flow, relief, machine.tank.return_pressure, c.pump._replace(torque_limit_enabled=False))

    def fed(X: np.ndarray) -> np.ndarray:
        arriving = np.maximum(X[:, 0], _LEAST * flow)
        sampled = sample_valves(valves, free, X[:, 1 : 1 + rest], X[:, 1 + rest :], arriving)
        return np.minimum(sampled.q_in[:, 0], X[:, 0])

    travel = [(0.0, f.valve.knots[-1]) for f in functions]
    pressure = [(0.0, min(f.line.relief, highest)) for f in functions]
    edges = {1 + k: cuts_of(f) for k, f in enumerate(functions)}
    return NetworkTarget(inlet(c, c.functions[place])[0], fed, [(0.0, flow), *travel, *pressure], edges)


def _modes(machine: LayoutMachine, c: SupplyCircuit) -> tuple[Pump, Pump, Pump]:
    """A pump that knows constant flow alone, one whose relief valve is always open, and one that is always at its torque limit."""
    pump, p_return = c.pump, machine.tank.return_pressure
    constant = pump._replace(torque_limit_enabled=False)
    start = pump.torque_limit_start / _UP_TO ** (1.0 / pump.torque_limit_exponent)
    law = pump._replace(torque_limit_enabled=True, torque_limit_start=start)
    return (
        limited_pump(pump.flow, NEVER, p_return, constant),
        limited_pump(_ALWAYS_OPEN * pump.flow, pump.relief, p_return, constant),
        limited_pump(_UP_TO * pump.flow, NEVER, p_return, law),
    )
