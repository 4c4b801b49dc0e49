"""The cases of a batch: which machine meets which inputs from which state, checked and prepared."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel, as_flow, flow_name, served_links
from polydraulic.flow.record import N_STATE, to_vector
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import initial_state
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.scenario import Scenario, as_scenario, load_scenario
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.simulation.runs import check_links, n_steps, step_voltages


class Kind(NamedTuple):
    """A machine as a scenario wants it, ready to run."""

    machine: Machine
    plant: Plant
    model: Any


class Cases(NamedTuple):
    """All cases of a batch.

    Attributes
    ----------
    kinds : list of Kind
        The machines that differ.
    kind : (n,) array of int
        Kind of each case.
    x0 : (n, 15) array
    voltage : (n_signal, n_step, 3) array, V
    signal : (n,) array of int
        Which voltages each case gets.
    free : tuple of str
        Links that move in one case at least.
    """

    kinds: list[Kind]
    kind: np.ndarray
    x0: np.ndarray
    voltage: np.ndarray
    signal: np.ndarray
    free: tuple[str, ...]


def arrange_cases(
    machines: Machine | str | Path | Sequence[Machine | str | Path],
    flow: str | FlowModel,
    inputs: Scenario | str | Path | Sequence[Scenario | str | Path] | np.ndarray,
    *,
    dt: float,
    t_end: float | None,
    x0: np.ndarray | None,
    every: int,
) -> Cases:
    """Check and prepare the arguments of `simulate_batch`."""
    named = cache(as_excavator)  # machines of one name are one kind
    items = [machines] if isinstance(machines, Machine | str | Path) else machines
    given = [item if isinstance(item, Machine) else named(item) for item in items]
    scenarios = _scenarios(inputs)
    voltage = None if scenarios else _voltages(inputs)
    starts = None if x0 is None else _starts(x0)
    lengths = {"machines": len(given), "inputs": len(voltage) if voltage is not None else len(scenarios)}
    if starts is not None:
        lengths["initial states"] = len(starts)
    n = max(lengths.values())
    if any(length not in (1, n) for length in lengths.values()) or min(lengths.values()) < 1:
        found = ", ".join(f"{length} {name}" for name, length in lengths.items())
        raise InputError(f"{found}: each must be one for all machines, or as many as there are machines")

    pairs = [(given[i % len(given)], scenarios[i % len(scenarios)] if scenarios else None) for i in range(n)]
    numbers: dict[tuple[int, int], int] = {}
    kind = np.array([numbers.setdefault((id(m), id(s)), len(numbers)) for m, s in pairs])
    first = np.unique(kind, return_index=True)[1]
    kinds = [_kind(machine, scenario, flow, dt) for machine, scenario in (pairs[i] for i in first)]

    if voltage is None:
        voltage, signal_of_kind = _scenario_voltages(kinds, [pairs[i][1] for i in first], dt, t_end, every)
        signal = signal_of_kind[kind]
    else:
        voltage = voltage[:, : _array_steps(voltage.shape[1], dt, t_end, every)]
        signal = np.arange(n) % len(voltage)
    if starts is None:
        starts = np.array([to_vector(initial_state(k.machine)) for k in kinds])[kind]
    free = tuple(link for place, link in enumerate(LINKS) if not all(k.plant.locked[place] for k in kinds))
    return Cases(kinds, kind, starts[np.arange(n) % len(starts)], voltage, signal, free)


def _kind(machine: Machine, scenario: Scenario | None, flow: str | FlowModel, dt: float) -> Kind:
    adapted = scenario.adapt(machine) if scenario else machine
    plant = prepare(adapted, dt, scenario.locked if scenario else ())
    model = as_flow(flow, adapted)
    if scenario:
        check_links(scenario, model)
    elif served_links(model) != LINKS:
        raise InputError(
            f"an array of voltages moves all links, and flow {flow_name(model)!r} serves {', '.join(served_links(model))}; "
            "give scenarios that lock the others"
        )
    return Kind(adapted, plant, model)


def _scenarios(inputs: Any) -> list[Scenario]:
    if isinstance(inputs, Scenario | str | Path):
        return [as_scenario(inputs)]
    if isinstance(inputs, Sequence) and inputs and all(isinstance(item, Scenario | str | Path) for item in inputs):
        named = cache(load_scenario)
        return [item if isinstance(item, Scenario) else named(item) for item in inputs]
    return []


def _voltages(inputs: Any) -> np.ndarray:
    wanted = "inputs must be a scenario (or its name), a list of scenarios, or voltages of shape (n_step, 3) or (n_machine, n_step, 3)"
    if not isinstance(inputs, np.ndarray):
        raise InputError(f"{wanted}, not {type(inputs).__name__}")
    if inputs.ndim not in (2, 3) or inputs.shape[-1] != len(LINKS) or not inputs.size:
        raise InputError(f"{wanted}; the array has shape {inputs.shape}")
    voltage = np.ascontiguousarray(inputs if inputs.ndim == 3 else inputs[None], dtype=np.float64)
    if not np.isfinite(voltage).all():
        machine, step, link = np.argwhere(~np.isfinite(voltage))[0]
        value = voltage[machine, step, link]
        raise InputError(f"the {LINKS[link]} voltage in step {step} of machine {machine} is {value}; it must be finite")
    return voltage


def _starts(x0: np.ndarray) -> np.ndarray:
    starts = np.atleast_2d(np.asarray(x0, dtype=np.float64))
    if starts.ndim != 2 or starts.shape[1] != N_STATE or not np.all(np.isfinite(starts)):
        raise InputError(
            f"x0 has shape {np.shape(x0)}: it must hold finite numbers in the shape ({N_STATE},) or (n_machine, {N_STATE})"
        )
    return starts


def _scenario_voltages(
    kinds: Sequence[Kind], scenarios: Sequence[Any], dt: float, t_end: float | None, every: int
) -> tuple[np.ndarray, np.ndarray]:
    """Voltages that differ, and which of them each kind gets."""
    durations = {scenario.duration: scenario.name for scenario in scenarios}
    if t_end is None and len(durations) > 1:
        found = ", ".join(f"{name} {duration:g} s" for duration, name in durations.items())
        raise InputError(f"the scenarios end at different times ({found}); give t_end")
    t = np.arange(n_steps(scenarios[0], dt, t_end, every)) * dt
    numbers: dict[tuple[object, ...], int] = {}
    voltages: list[np.ndarray] = []
    which: list[int] = []
    for kind, scenario in zip(kinds, scenarios, strict=True):
        key = (id(scenario), *(getattr(kind.machine, link).pilot.dead_time for link in LINKS))
        if key not in numbers:
            numbers[key] = len(voltages)
            voltages.append(step_voltages(kind.machine, scenario, t))
        which.append(numbers[key])
    return np.array(voltages), np.array(which)


def _array_steps(n_step: int, dt: float, t_end: float | None, every: int) -> int:
    asked = n_steps(Scenario("voltages", n_step * dt, {}), dt, t_end, every)
    if asked > n_step:
        raise InputError(f"t_end = {t_end} s: the voltages last {n_step} steps of {dt} s")
    return asked
