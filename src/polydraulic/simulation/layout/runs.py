"""`simulate` for a machine of any layout."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.machine.reach.tip import tip_at_joints
from polydraulic.machine.stability.whole_body import chassis_of
from polydraulic.parameters.deviations import Fault, ScheduledFault, TimedFault
from polydraulic.parameters.fault_catalogue import as_list, timed_faults
from polydraulic.parameters.faults import faulty_parts, first_step
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.loads import Payload
from polydraulic.parameters.scenario import Scenario, as_scenario
from polydraulic.simulation.changed_flow import changed_flow
from polydraulic.simulation.input_check import fault_warnings, full_lever, input_warnings
from polydraulic.simulation.layout.columns import (
    EFFECTOR,
    AddedColumn,
    Columns,
    circuit_keys,
    columns_of,
    cross_name,
    fed_functions,
    kept_quantities,
)
from polydraulic.simulation.layout.energy import energy_columns
from polydraulic.simulation.layout.events import layout_events
from polydraulic.simulation.layout.forces import force_columns
from polydraulic.simulation.layout.methods.known import Integrate, run_known
from polydraulic.simulation.layout.methods.text import methods_module
from polydraulic.simulation.layout.prepare import ReadyMachine, prepare_layout
from polydraulic.simulation.layout.seen import beyond_seen
from polydraulic.simulation.layout.served_methods import check_flow, check_method
from polydraulic.simulation.layout.stability.columns import stability_columns, tips
from polydraulic.simulation.layout.step_check import step_warnings
from polydraulic.simulation.steps import FASTEST, n_steps
from polydraulic.tables import Table


class Segment(NamedTuple):
    """Part of a run in which the machine's numbers do not change."""

    plain: LayoutMachine  # with its faults, without what hangs at the tip
    machine: LayoutMachine
    first: int  # step
    end: int  # one past its last step


def simulate_layout(
    machine: LayoutMachine,
    flow: str | FlowModel,
    scenario: Scenario | str | Path,
    *,
    dt: float,
    t_end: float | None,
    every: int,
    method: str,
    rtol: float | None = None,
    energy: bool = False,
    forces: bool = False,
    stability: bool = False,
    faults: Sequence[str | Fault | ScheduledFault | TimedFault] = (),
    piece: int = 20_000,
) -> Table:
    """Simulate a scenario; arguments and result are those of `simulate`, with the machine's own functions and circuits.

    Of a method with fixed steps all rows of `piece` steps are held at a time; of these the recorded ones are kept.

    Raises
    ------
    InputError
        As `simulate`.
    SimulationError
        If the run diverges, or a solver fails.
    """
    model = layout_flow(flow, machine)
    check_flow(model, method)
    check_method(machine, method)
    if energy and not model.gives_pump_pressure:
        raise InputError(
            f"the energy account needs pressures of pumps, which flow {model.name!r} does not give; use 'exact'"
        )
    scenario = as_scenario(scenario, machine.names)
    machine = adapted(machine, scenario)
    timed = timed_faults(machine, (*scenario.faults, *as_list(faults)))
    if set(scenario.locked) >= set(machine.names):
        raise InputError(f"scenario {scenario.name!r} locks {', '.join(machine.names)}; nothing is left to move")
    check_served(scenario, model, machine)
    if stability:
        chassis_of(machine)
    added = _added(scenario, model, energy, forces, stability, dt)
    n_step = n_steps(scenario, dt, t_end, every)
    time = np.arange(n_step // every + 1) * every * dt
    info: dict[str, object] = {"scenario": scenario.name, "flow": model.name, "method": method, "dt": dt}
    doubts = input_warnings(scenario, {f.name: full_lever(f) for f in machine.functions}, t_end)
    if method == "semi-implicit":
        doubts += step_warnings(machine, prepare_layout(machine, dt, scenario.locked, flow=model), dt)
    doubts += fault_warnings(timed, n_step * dt)
    if doubts:
        info["doubtful_inputs"] = doubts
    if timed:
        info["faults"] = [str(one) for one in timed]
    info["functions"] = list(machine.names)
    info["circuits"] = {c.name: list(c.functions) for c in machine.circuits}
    if rtol is None:
        parts = segments(machine, scenario.loads.payload, timed, dt, n_step)
        changed = [changed_flow(flow, model, machine, part.plain) for part in parts]  # before anything runs
        made = _stepped(list(zip(parts, changed, strict=True)), scenario, time, method, dt, every, added, piece)
    else:
        made = _integrated(machine, flow, model, scenario, timed, time, method, rtol, added)
    more = [
        AddedColumn(parts[0].name, parts[0].unit, np.concatenate([part.values for part in parts]))
        for parts in zip(*made.account, strict=True)
    ]
    info |= made.info
    if machine.chassis is not None and stability:
        info |= tips(machine.chassis, time, more, info["events"])  # type: ignore[arg-type]
    return _table(machine, scenario, model, time, made.rows, info, more)


class _Made(NamedTuple):
    """Rows of a run, what is said of it, and its account of energy, part by part."""

    rows: np.ndarray
    info: dict[str, object]
    account: list[list[AddedColumn]]


# from a machine, its kernels and numbers, rows and their times to columns that follow from them
Added = Callable[[LayoutMachine, Any, Any, np.ndarray, np.ndarray], list[AddedColumn]]


def _added(
    scenario: Scenario, model: LayoutFlow, energy: bool, forces: bool, stability: bool, dt: float
) -> Added | None:
    """What a run is to have besides, None where nothing is asked for."""

    def columns(
        machine: LayoutMachine, module: Any, plant: Any, rows: np.ndarray, time: np.ndarray
    ) -> list[AddedColumn]:
        push, of = scenario.loads.forces(time), columns_of(machine, stores_oil=model.stores_oil)
        account = energy_columns(machine, module, plant, rows, of, push, model.compliances) if energy else ()
        begun = plant._replace(dt=dt)  # methods that choose their own steps have none
        pins = force_columns(machine, module, begun, rows, of, push, scenario.locked) if forces else ()
        stands = stability_columns(machine, module, begun, rows, of, push) if stability else ()
        return [*account, *pins, *stands]

    return columns if energy or forces or stability else None


def _stepped(
    parts: Sequence[tuple[Segment, LayoutFlow]], scenario: Scenario, time: np.ndarray, method: str, dt: float, every: int,
    added: Added | None, piece: int,
) -> _Made:  # fmt: skip
    """Run a method with fixed steps."""
    machine, model = parts[0][0].plain, parts[0][1]
    columns, n_step = columns_of(machine, stores_oil=model.stores_oil), parts[-1][0].end
    # columns in one piece each: they are what is read from here on
    rows, counts = np.empty((len(time), len(columns.columns)), order="F"), np.zeros(2, dtype=np.int64)
    account: list[list[AddedColumn]] = []
    state: np.ndarray | None = None
    beyond_log: int | None = None  # steps, of an identified machine
    memory = np.zeros(model.n_memory)
    for part, flow in parts:
        ready = prepare_layout(part.machine, dt, scenario.locked, force=bool(scenario.loads.force), flow=flow)
        advance = _STEPPERS[method](part.machine, scenario, flow, ready, dt, memory)
        for first in range(part.first, part.end, piece):
            end = min(first + piece, part.end)
            own = np.empty((end - first + 1, len(columns.columns)))
            done = advance(ready.start if state is None else state, first, end, own, counts)
            if done < end - first:
                raise _diverged(scenario, flow.name, machine, own[0], columns, (first + done) * dt)
            state = own[-1, : columns.n_state].copy()
            beyond = beyond_seen(part.machine, columns, own[1:])
            if beyond is not None:
                beyond_log = (beyond_log or 0) + int(beyond.sum())
            steps = np.arange(first, end + 1)
            new = (steps % every == 0) & ((steps > first) | (first == 0))
            rows[steps[new] // every] = own[new]
            if added is not None and new.any():
                account.append(added(part.machine, ready.module, ready.plant, own[new], steps[new] * dt))
    info: dict[str, object] = {"steps": n_step}
    info |= {"steps_not_converged": int(counts[0]), "steps_out_of_domain": int(counts[1])}
    if beyond_log is not None:
        info |= {"steps_beyond_log": beyond_log, "steps_out_of_domain": max(int(counts[1]), beyond_log)}
    seen = [(part.plain, part.first // every + 1 if part.first else 0) for part, _ in parts]
    info |= layout_events(seen, scenario.locked, time, lambda name: rows[:, columns.place[name]])
    return _Made(rows, info, account)


def _integrated(
    machine: LayoutMachine, flow: str | FlowModel, model: LayoutFlow, scenario: Scenario, faults: Sequence[TimedFault],
    time: np.ndarray, method: str, rtol: float, added: Added | None,
) -> _Made:  # fmt: skip
    """Run a method that chooses its own steps."""
    flow_of = partial(changed_flow, flow, model, machine)
    run = run_known(machine, scenario, faults, time, rtol, method, _solver(method), flow_of)
    account: list[list[AddedColumn]] = []
    for part, first, end in run.parts if added is not None else ():
        if added is not None and end > first:
            account.append(added(part.machine, part.step, part.plant, run.rows[first:end], time[first:end]))
    info: dict[str, object] = {"rtol": rtol, **run.info}
    beyond = beyond_seen(machine, columns_of(machine), run.rows)
    if beyond is not None:
        info["rows_beyond_log"] = int(beyond.sum())
    return _Made(run.rows, info, account)


def _solver(method: str) -> Integrate:
    # SciPy's solvers take long to import, and the loops do without
    if method == "rosenbrock":
        from polydraulic.simulation.layout.methods.rosenbrock import integrate
    else:
        from polydraulic.simulation.layout.methods.lsoda import integrate
    return integrate


# from state and numbers of the first and one past the last step to rows, of which the counts are added; how many steps were made
Advance = Callable[[np.ndarray, int, int, np.ndarray, np.ndarray], int]


def _semi_implicit(
    machine: LayoutMachine, scenario: Scenario, flow: LayoutFlow, ready: ReadyMachine, dt: float, memory: np.ndarray
) -> Advance:
    def advance(state: np.ndarray, first: int, end: int, rows: np.ndarray, counts: np.ndarray) -> int:
        inputs = step_inputs(machine, scenario, np.arange(first, end) * dt)
        return int(ready.module.run(ready.valves, memory, ready.plant, state, inputs, 1, rows, counts))

    return advance


def _runge_kutta(
    machine: LayoutMachine, scenario: Scenario, flow: LayoutFlow, ready: ReadyMachine, dt: float, memory: np.ndarray
) -> Advance:
    force = bool(scenario.loads.force)
    module = methods_module(machine, flow=flow.kernels, force=force)
    plant = prepare_layout(machine, 1.0, scenario.locked, force=force, flow=flow, continuous=True).plant
    valves = ready.valves if flow.kernels == "exact" else module.Valves(ready.valves, memory)
    tau = ready.module.Functions(*(f.pilot.time_constant for f in machine.functions))

    def advance(state: np.ndarray, first: int, end: int, rows: np.ndarray, counts: np.ndarray) -> int:
        inputs = step_inputs(machine, scenario, np.arange(2 * first, 2 * end + 1) * (0.5 * dt))
        return int(module.run_runge_kutta(valves, plant, tau, dt, state, inputs, 1, rows, counts))

    return advance


_STEPPERS = {"semi-implicit": _semi_implicit, "rk4": _runge_kutta}


def prepared_run(
    machine: LayoutMachine, flow: str | FlowModel, scenario: Scenario, *, dt: float = 5e-3
) -> Callable[[], int]:
    """The compiled loop over a whole scenario as a call without arguments, for those who time it; it gives the steps made."""
    model, machine = layout_flow(flow, machine), adapted(machine, scenario)
    ready, n_step = prepare_layout(machine, dt, scenario.locked, flow=model), n_steps(scenario, dt, None)
    inputs = step_inputs(machine, scenario, np.arange(n_step) * dt)
    columns = columns_of(machine, stores_oil=model.stores_oil)
    rows, counts = np.empty((n_step + 1, len(columns.columns))), np.zeros(2, dtype=np.int64)
    memory = np.zeros(model.n_memory)
    return partial(ready.module.run, ready.valves, memory, ready.plant, ready.start, inputs, 1, rows, counts)


def segments(
    machine: LayoutMachine, payload: Payload | None, faults: Sequence[TimedFault], dt: float, n_step: int
) -> list[Segment]:
    """Parts of a run between changes of the payload and of what faults leave of the machine, which happen at the next whole step."""
    parts = faulty_parts(machine, faults, n_step * dt)
    if payload is None and len(parts) == 1 and not parts[0].payload:
        return [Segment(parts[0].machine, parts[0].machine, 0, n_step)]
    known = [(0.0, 0.0), *zip(payload.time, payload.mass, strict=True)] if payload else [(0.0, 0.0)]
    masses = {first_step(t, dt, n_step): mass for t, mass in known}
    machines = {first_step(part.begin, dt, n_step): part for part in parts}
    loaded = payload is not None or any(part.payload for part in parts)
    found: list[Segment] = []
    mass, part, begins = 0.0, parts[0], sorted({*masses, *machines} - {n_step})
    for first, end in zip(begins, [*begins[1:], n_step], strict=True):
        mass, part = masses.get(first, mass), machines.get(first, part)
        whole = with_payload(part.machine, mass + part.payload) if loaded else part.machine
        found.append(Segment(part.machine, whole, first, end))
    return found


def _diverged(
    scenario: Scenario, flow: str, machine: LayoutMachine, row: np.ndarray, columns: Columns, t: float
) -> SimulationError:
    rates = {name: row[columns.place[f"{name}.rate"]] for name in machine.names}
    fastest = next(name for name, rate in rates.items() if not abs(rate) < FASTEST)
    return SimulationError(
        f"{scenario.name} with flow {flow!r}: diverged, the rate of {fastest} grew without bound at t = {t:g} s; "
        "try a smaller dt or check the parameter set"
    )


def check_served(scenario: Scenario, model: LayoutFlow, machine: LayoutMachine) -> None:
    """Refuse a scenario that moves functions which the flow model does not serve."""
    missing = [f for f in machine.names if f not in (*scenario.locked, *model.served)]
    if missing:
        raise InputError(
            f"scenario {scenario.name!r} moves {', '.join(missing)}, for which flow {model.name!r} has no networks; lock them in the "
            "scenario, or train networks of their circuits, too"
        )


def step_inputs(machine: LayoutMachine, scenario: Scenario, t: np.ndarray) -> np.ndarray:
    """Inputs of steps that begin at the times `t`: a voltage per function, then the force at the tip if the scenario has one.

    Voltages are the joystick's after each pilot's dead time, 0 V before that and where locked; shape (n_time, n_input).
    """
    columns = []
    for place, f in enumerate(machine.functions):
        delayed = t - f.pilot.dead_time
        alive = delayed >= 0.0 if f.name not in scenario.locked else np.zeros(len(t), dtype=bool)
        columns.append(np.where(alive, scenario.voltages(delayed, machine.names)[:, place], 0.0))
    if scenario.loads.force:
        columns += [*scenario.loads.forces(t).T]
    return np.ascontiguousarray(np.column_stack(columns))


def _table(
    machine: LayoutMachine,
    scenario: Scenario,
    model: LayoutFlow,
    time: np.ndarray,
    rows: np.ndarray,
    info: dict[str, object],
    more: Sequence[AddedColumn],
) -> Table:
    """Name the columns of recorded rows, and add what follows from them, and `more`."""
    columns = columns_of(machine, stores_oil=model.stores_oil)
    found: dict[str, np.ndarray] = {"time": time}
    units = {"time": "s"}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        found[name], units[name] = np.ascontiguousarray(values), unit

    def recorded(key: str) -> np.ndarray:
        column = columns.columns[columns.place[key]]
        add(column.name, column.unit, rows[:, columns.place[key]])
        return found[column.name]

    voltages = scenario.voltages(time, machine.names)
    for place, f in enumerate(machine.names):
        if f in scenario.locked:
            continue
        add(f"{f}.voltage", "V", voltages[:, place])
        of = {quantity: recorded(f"{f}.{quantity}") for quantity in kept_quantities(machine.function(f))}
        forward = of["spool"] >= 0.0
        add(f"{f}.p_in", "Pa", np.where(forward, of["p_a"], of["p_b"]))
        add(f"{f}.p_out", "Pa", np.where(forward, of["p_b"], of["p_a"]))
    for c in machine.circuits:
        if not fed_functions(machine, c.name) <= set(scenario.locked):
            for key in circuit_keys(c, p_pump=model.gives_pump_pressure, stores_oil=model.stores_oil):
                recorded(key)
    for x in machine.crossovers:
        if not fed_functions(machine, x.giving) <= set(scenario.locked):
            recorded(cross_name(x.giving))
    for f in scenario.locked:
        recorded(f"{f}.angle")
    positions = np.column_stack([rows[:, columns.place[f"{f}.angle"]] for f in machine.names])
    for name, values in zip(EFFECTOR, tip_at_joints(machine, positions).T, strict=True):
        add(name, "m", values)
    for column in more:
        add(*column)
    return Table(found, units, info)
