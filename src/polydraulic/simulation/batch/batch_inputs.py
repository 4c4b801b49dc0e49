"""The cases of a batch: which machine meets which inputs from which state, checked and prepared."""

from collections.abc import Iterable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.parameters.deviations import TimedFault
from polydraulic.parameters.fault_catalogue import as_list, timed_faults
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import load_machine
from polydraulic.parameters.loads import Loads
from polydraulic.parameters.scenario import Scenario, as_scenario, load_scenario
from polydraulic.simulation.batch.family import Family, family_of
from polydraulic.simulation.changed_flow import changed_flow
from polydraulic.simulation.input_check import full_lever, voltage_warnings
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import check_served, segments, step_inputs
from polydraulic.simulation.layout.text import layout_of
from polydraulic.simulation.steps import n_steps


class Kind(NamedTuple):
    """A machine as a scenario wants it, ready to run."""

    machine: LayoutMachine
    plant: Any
    model: Any
    start: np.ndarray
    flow: LayoutFlow  # of which `model` is what the kernels read


class Cases(NamedTuple):
    """All cases of a batch.

    Attributes
    ----------
    family : Family
        What they have in common.
    flow : str
        Name of the flow model.
    kinds : list of Kind
        The machines that differ.
    kind : (n,) array of int
        Kind of each case at its start.
    later : dict from kind to dict from step to kind
        What the cases that begin as a kind become, for kinds that do not stay.
    x0 : (n, n_state) array
    voltage : (n_signal, n_step, n_input) array, V
    signal : (n,) array of int
        Which voltages each case gets.
    free : tuple of str
        Functions that move in one case at least.
    n_memory : int
        Floats that a step keeps or uses as scratch.
    doubts : list of str
        What is doubtful in the voltages, though it can be run.
    """

    family: Family
    flow: str
    kinds: list[Kind]
    kind: np.ndarray
    later: dict[int, dict[int, int]]
    x0: np.ndarray
    voltage: np.ndarray
    signal: np.ndarray
    free: tuple[str, ...]
    n_memory: int
    doubts: list[str]


def arrange_cases(
    machines: LayoutMachine | str | Path | Sequence[LayoutMachine | str | Path],
    flow: str | FlowModel,
    inputs: Scenario | str | Path | Sequence[Scenario | str | Path] | np.ndarray,
    *,
    dt: float,
    t_end: float | None,
    x0: np.ndarray | None,
    every: int,
    faults: Sequence[Any] = (),
) -> Cases:
    """Check and prepare the arguments of `simulate_batch`."""
    named = cache(load_machine)  # machines of one name are one kind
    items: Sequence[Any] = [machines] if isinstance(machines, LayoutMachine | str | Path) else machines
    if not isinstance(items, Iterable):
        raise InputError(f"machines = {briefly(items)}: must be a machine, its name or path, or a list of these")
    given: list[LayoutMachine] = []
    for item in items:
        given.append(item if isinstance(item, LayoutMachine) else named(item))
    if not given:
        raise InputError("0 machines: give one for all, or as many as there are inputs")
    functions = _functions(given)
    scenarios = _scenarios(inputs, functions)
    voltage = None if scenarios else _voltages(inputs, functions)
    starts = None if x0 is None else _starts(x0, columns_of(given[0]).n_state)
    broken = _faults(faults)
    lengths = {"machines": len(given), "inputs": len(voltage) if voltage is not None else len(scenarios)}
    lengths |= {"lists of faults": len(broken)} if len(broken) > 1 else {}
    if starts is not None:
        lengths["initial states"] = len(starts)
    n = max(lengths.values())
    if any(length not in (1, n) for length in lengths.values()) or min(lengths.values()) < 1:
        found = ", ".join(f"{length} {name}" for name, length in lengths.items())
        raise InputError(f"{found}: each must be one for all machines, or as many as there are machines")
    if starts is not None:
        _check_angles(starts, given)

    pairs = [
        (given[i % len(given)], scenarios[i % len(scenarios)] if scenarios else None, broken[i % len(broken)])
        for i in range(n)
    ]
    if voltage is None:
        n_step = _scenario_steps(scenarios, dt, t_end, every)
    else:
        n_step = _array_steps(voltage.shape[1], dt, t_end, every)
    numbers: dict[tuple[int, int, tuple[Any, ...]], int] = {}
    kind = np.array([numbers.setdefault((id(m), id(s), f), len(numbers)) for m, s, f in pairs])
    first = np.unique(kind, return_index=True)[1]
    all_of = [
        _kinds(machine, scenario, flow, dt, wrong, n_step) for machine, scenario, wrong in (pairs[i] for i in first)
    ]
    kinds = [found[0] for found in all_of]
    later: dict[int, dict[int, int]] = {}
    every_kind = list(kinds)
    for number, of in enumerate(all_of):
        for step, changed in list(of.items())[1:]:
            later.setdefault(number, {})[step] = len(every_kind)
            every_kind.append(changed)

    if voltage is None:
        voltage, signal_of_kind = _scenario_voltages(kinds, [pairs[i][1] for i in first], np.arange(n_step) * dt)
        signal = signal_of_kind[kind]
    else:
        voltage = voltage[:, :n_step]
        signal = np.arange(n) % len(voltage)
    if starts is None:
        starts = np.array([k.start for k in kinds])[kind]
    free = tuple(name for place, name in enumerate(functions) if not all(k.plant.locked[place] for k in kinds))
    forced = {bool(scenario.loads.force) for _, scenario, _ in pairs if scenario}
    if len(forced) > 1:
        raise InputError(
            "some of the scenarios have a force at the tip and some have none; give all of them one, of 0 N if need be"
        )
    family = family_of(kinds[0].machine, kinds[0].flow, force=forced == {True})
    model = kinds[0].flow
    driven = voltage[..., : len(functions)]  # behind them stand forces at the tip
    full = np.array([_full_levers(*pairs[i][:2]) for i in first])[kind]
    return Cases(
        family,
        model.name,
        every_kind,
        kind,
        later,
        starts[np.arange(n) % len(starts)],
        voltage,
        signal,
        free,
        model.n_memory,
        voltage_warnings(functions, driven, signal, full),
    )


def _functions(machines: Sequence[LayoutMachine]) -> tuple[str, ...]:
    """Functions of machines, which must share a layout: they run side by side."""
    layouts = {layout_of(m) for m in machines}
    if len(layouts) > 1:
        raise InputError(
            f"the machines have {len(layouts)} layouts; a batch holds machines of one layout, which differ in numbers alone"
        )
    return machines[0].names


def _full_levers(machine: LayoutMachine, scenario: Scenario | None) -> list[float]:
    """Voltages in V that give the spools of a machine without faults full travel; infinite for what a scenario locks."""
    plain, locked = (adapted(machine, scenario), scenario.locked) if scenario else (machine, ())
    return [np.inf if f.name in locked else full_lever(f) for f in plain.functions]


def _faults(faults: Any) -> list[tuple[Any, ...]]:
    """Lists of faults: one for all, or one for each machine."""
    given: list[Any] = as_list(faults)
    each = [isinstance(one, Sequence) and not isinstance(one, str | TimedFault) for one in given]
    if any(each) and not all(each):
        raise InputError("faults must be one list for all machines, or a list of lists, one for each")
    return [tuple(as_list(one)) for one in given] if any(each) else [tuple(given)]


def _kinds(
    machine: LayoutMachine,
    scenario: Scenario | None,
    flow: str | FlowModel,
    dt: float,
    faults: tuple[Any, ...],
    n_step: int,
) -> dict[int, Kind]:
    """What a machine is from which step on, the first being 0."""
    model = layout_flow(flow, machine)
    loads = scenario.loads if scenario else Loads()
    if scenario:
        check_served(scenario, model, machine)
    elif model.served != machine.names:
        raise InputError(
            f"an array of voltages moves all functions, and flow {model.name!r} serves {', '.join(model.served)}; give scenarios that lock the "
            "others"
        )
    machine = adapted(machine, scenario) if scenario else machine
    timed = timed_faults(machine, (*(scenario.faults if scenario else ()), *faults))
    locked, found = scenario.locked if scenario else (), dict[int, Kind]()
    for part in segments(machine, loads.payload, timed, dt, n_step):
        late = [
            f.name
            for f, g in zip(part.plain.functions, machine.functions, strict=True)
            if f.pilot.dead_time != g.pilot.dead_time
        ]
        if late:
            raise InputError(
                f"functions.{late[0]}.pilot.dead_time: in a batch dead times stay; `simulate` lets them change"
            )
        now = changed_flow(flow, model, machine, part.plain)
        ready = prepare_layout(part.machine, dt, locked, force=bool(loads.force), flow=now)
        found[part.first] = Kind(part.machine, ready.plant, ready.valves, ready.start, now)
    return found


def _scenarios(inputs: Any, functions: Sequence[str]) -> list[Scenario]:
    if isinstance(inputs, Scenario | str | Path):
        return [as_scenario(inputs, functions)]
    if isinstance(inputs, Sequence) and inputs and all(isinstance(item, Scenario | str | Path) for item in inputs):
        named = cache(partial(load_scenario, functions=functions))
        return [as_scenario(item, functions) if isinstance(item, Scenario) else named(item) for item in inputs]
    return []


def _voltages(inputs: Any, functions: Sequence[str]) -> np.ndarray:
    n = len(functions)
    wanted = f"inputs must be a scenario (or its name), a list of scenarios, or voltages of shape (n_step, {n}) or (n_machine, n_step, {n})"
    if not isinstance(inputs, np.ndarray):
        raise InputError(f"{wanted}, not {type(inputs).__name__}")
    if inputs.ndim not in (2, 3) or inputs.shape[-1] != n or not inputs.size:
        raise InputError(f"{wanted}; the array has shape {inputs.shape}")
    if inputs.dtype.kind not in "iuf" or np.ma.is_masked(inputs):
        what = "masked values" if np.ma.is_masked(inputs) else f"values of type {inputs.dtype}"
        raise InputError(f"{wanted}; the array holds {what}, and every voltage must be a real number")
    voltage = np.ascontiguousarray(inputs if inputs.ndim == 3 else inputs[None], dtype=np.float64)
    if not np.isfinite(voltage).all():
        machine, step, link = np.argwhere(~np.isfinite(voltage))[0]
        value = voltage[machine, step, link]
        raise InputError(
            f"the {functions[link]} voltage in step {step} of machine {machine} is {value}; it must be finite"
        )
    return voltage


def _starts(x0: np.ndarray, n_state: int) -> np.ndarray:
    try:
        starts = np.atleast_2d(np.asarray(x0, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise InputError(f"x0 = {briefly(x0)}: must hold numbers, as many for each machine") from error
    if starts.ndim != 2 or starts.shape[1] != n_state or not np.all(np.isfinite(starts)):
        raise InputError(
            f"x0 has shape {np.shape(x0)}: it must hold finite numbers in the shape ({n_state},) or (n_machine, {n_state})"
        )
    return starts


def _check_angles(starts: np.ndarray, machines: Sequence[LayoutMachine]) -> None:
    """Refuse joints so far beyond their stops that their unit is another one; what is measured may lie a little beyond."""
    columns = columns_of(machines[0])
    for place, f in enumerate(machines[0].functions):
        at = columns.place[f"{f.name}.angle"]
        low, high = np.array([machine.functions[place].stops for machine in machines]).T
        apart = 2.0 * np.pi if columns.columns[at].unit == "rad" else high - low
        beyond = np.flatnonzero((starts[:, at] < low - apart) | (starts[:, at] > high + apart))
        if beyond.size:
            row, unit = beyond[0], columns.columns[at].unit
            first, last = low[row % len(low)], high[row % len(high)]
            raise InputError(
                f"x0: {f.name}.angle = {starts[row % len(starts), at]:g} {unit} of machine {row}: is far beyond the stops, {first:g} and {last:g} {unit}"
            )


def _scenario_steps(scenarios: Sequence[Scenario], dt: float, t_end: float | None, every: int) -> int:
    durations = {scenario.duration: scenario.name for scenario in scenarios}
    if t_end is None and len(durations) > 1:
        found = ", ".join(f"{name} {duration:g} s" for duration, name in durations.items())
        raise InputError(f"the scenarios end at different times ({found}); give t_end")
    return n_steps(scenarios[0], dt, t_end, every)


def _scenario_voltages(kinds: Sequence[Kind], scenarios: Sequence[Any], t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Voltages that differ, of steps that begin at the times `t`, and which of them each kind gets."""
    numbers: dict[tuple[object, ...], int] = {}
    voltages: list[np.ndarray] = []
    which: list[int] = []
    for kind, scenario in zip(kinds, scenarios, strict=True):
        key = (id(scenario), *(f.pilot.dead_time for f in kind.machine.functions))
        if key not in numbers:
            numbers[key] = len(voltages)
            voltages.append(step_inputs(kind.machine, scenario, t))
        which.append(numbers[key])
    return np.array(voltages), np.array(which)


def _array_steps(n_step: int, dt: float, t_end: float | None, every: int) -> int:
    asked = n_steps(Scenario("voltages", n_step * dt, {}), dt, t_end, every)
    if asked > n_step:
        raise InputError(f"t_end = {t_end} s: the voltages last {n_step} steps of {dt} s")
    return asked
