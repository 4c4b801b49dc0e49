"""What a machine must be to be moved step by step: its kernels, numbers and columns, checked before the first step."""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, briefly
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.loads import Loads
from polydraulic.simulation.batch.family import family_of
from polydraulic.simulation.changed_flow import changed_flow, valves_and_pumps
from polydraulic.simulation.layout.columns import EFFECTOR, columns_of
from polydraulic.simulation.layout.prepare import ReadyMachine, prepare_layout
from polydraulic.simulation.stepping.per_machine import as_many
from polydraulic.simulation.steps import check_time_step


class Setup(NamedTuple):
    """A machine that is to be moved step by step.

    Attributes
    ----------
    machine : LayoutMachine
        Without what hangs at its tip.
    flow : LayoutFlow
    dt : float, s
    locked : tuple of str
    loads : Loads
        At the start; whether there is a force, and a payload, stays.
    """

    machine: LayoutMachine
    flow: LayoutFlow
    dt: float
    locked: tuple[str, ...]
    loads: Loads


def set_up(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    dt: float,
    locked: Collection[str],
    loads: Loads,
) -> Setup:
    """Check what a machine is to be moved with.

    Raises
    ------
    InputError
        A flow model that does not fit, a time step that is none, functions that are unknown, all locked,
        or not served by the flow model.
    """
    found = as_machine(machine)
    check_time_step(dt)
    if isinstance(locked, str):
        raise InputError(f"locked = {locked!r}: must be a list of names, for example [{locked!r}]")
    unknown = [name for name in locked if name not in found.names]
    if unknown:
        raise InputError(
            f"locked names {briefly(unknown[0])}, which the machine does not have; it has {list(found.names)}"
        )
    if set(locked) >= set(found.names):
        raise InputError(f"locked = {list(locked)}: nothing is left to move")
    model = layout_flow(flow, found)
    missing = [f for f in found.names if f not in (*locked, *model.served)]
    if missing:
        raise InputError(
            f"flow {model.name!r} has no networks for {', '.join(missing)}; lock them, or train networks of their circuits, too"
        )
    return Setup(found, model, dt, tuple(locked), loads)


def changed_setup(
    setup: Setup, flow: str | FlowModel, values: Mapping[str, float | Sequence[float]] | LayoutMachine
) -> Setup:
    """The same machine with other numbers, by their paths or as a whole.

    Raises
    ------
    InputError
        Values that cannot be, or a flow model that does not know them.
    """
    machine = values if isinstance(values, LayoutMachine) else setup.machine.with_values(values)
    if machine == setup.machine:
        return setup
    return setup._replace(machine=machine, flow=changed_flow(flow, setup.flow, setup.machine, machine))


def setup_beside(setup: Setup, flow: str | FlowModel, machine: LayoutMachine) -> Setup:
    """Another machine beside the first one; a flow model by name is built for it, one that is given serves all."""
    if isinstance(flow, str) and valves_and_pumps(machine) != valves_and_pumps(setup.machine):
        return setup._replace(machine=machine, flow=layout_flow(flow, machine))
    return setup._replace(machine=machine)


def loaded_machine(setup: Setup, mass: float) -> LayoutMachine:
    """The machine with what hangs at its tip; without a payload it is left as it is."""
    return setup.machine if setup.loads.payload is None else with_payload(setup.machine, mass)


def readied(setup: Setup, machine: LayoutMachine) -> ReadyMachine:
    """Kernels and numbers of a machine as it is set up."""
    return prepare_layout(machine, setup.dt, setup.locked, force=bool(setup.loads.force), flow=setup.flow)


def flow_key(flow: LayoutFlow) -> tuple[Any, ...]:
    """Tells flow models from others, by their name, what they serve, and all numbers of their parts."""
    return (flow.name, flow.served, *(np.asarray(part).tobytes() for part in _numbers(flow.parts)))


def _numbers(part: object) -> list[object]:
    """All numbers and arrays of a flow model's parts, one after the other."""
    if isinstance(part, dict):
        return [leaf for name in sorted(part) for leaf in _numbers(part[name])]
    return [leaf for inner in part for leaf in _numbers(inner)] if isinstance(part, tuple) else [part]


class Output(NamedTuple):
    """A column of a machine's outputs."""

    name: str
    place: int
    unit: str


def outputs_of(setup: Setup) -> list[Output]:
    """Columns as in the table of `simulate`, the tip behind them; places count recorded columns, the tip, then pressures at ports."""
    n_record = len(columns_of(setup.machine, stores_oil=setup.flow.stores_oil).columns)
    free = [name for name in setup.machine.names if name not in setup.locked]
    able = family_of(setup.machine, setup.flow, force=bool(setup.loads.force)).columns(free)
    found = [Output(name, row + (3 if row >= n_record else 0), unit) for name, (row, unit) in able.items()]
    return found + [Output(name, n_record + k, "m") for k, name in enumerate(EFFECTOR)]


def state_from(setup: Setup, state: np.ndarray | Mapping[str, float] | None, start: np.ndarray) -> np.ndarray:
    """A state to start from.

    Parameters
    ----------
    setup : Setup
    state : (n_state,) array, or mapping from column to value, or None
        In the order of the columns of a run: spools, pressures at A and B, positions and rates of all functions, then what declared effects
        keep. A mapping changes single values of the machine's own start.
    start : (n_state,) array
        The machine's own.

    Raises
    ------
    InputError
        Other names or shapes, values that are no numbers, a joint beyond its stops.
    """
    if isinstance(state, Mapping):
        state = {name: _float(value, f"state: {name}") for name, value in state.items()}
    elif state is not None and np.ndim(state) != 1:
        raise InputError(f"state has the shape {np.shape(state)}: must be {start.shape}")
    return states_from(setup, [setup.machine], start[None], state, np.array([True]))[0]


def states_from(
    setup: Setup,
    machines: Sequence[LayoutMachine],
    starts: np.ndarray,
    state: np.ndarray | Mapping[str, Any] | None,
    chosen: np.ndarray,
) -> np.ndarray:
    """States to start from of some of many machines.

    Parameters
    ----------
    setup : Setup
    machines : sequence of n LayoutMachine
    starts : (n, n_state) array
        Their own.
    state : (n_state,) or (n, n_state) array, or mapping from column to a value or (n,) values, or None
    chosen : (n,) array of bool

    Returns
    -------
    (n_chosen, n_state) array

    Raises
    ------
    InputError
        As `state_from`.
    """
    found = starts[chosen]
    if state is None or not len(found):
        return found
    columns = columns_of(setup.machine)
    names = [column.name for column in columns.columns[: columns.n_state]]
    if isinstance(state, Mapping):
        unknown = [name for name in state if name not in names]
        if unknown:
            raise InputError(f"state names {briefly(unknown[0])}; a state has {names}")
        for name, value in state.items():
            found[:, names.index(name)] = as_many(value, f"state: {name}", len(starts))[chosen]
    else:
        whole = np.array(state, dtype=np.float64)
        if whole.shape not in (starts.shape[1:], starts.shape):
            raise InputError(
                f"state has the shape {whole.shape}: must be {starts.shape[1:]} or {starts.shape}, in the order {names}"
            )
        found[:] = np.broadcast_to(whole, starts.shape)[chosen]
    of, several = np.flatnonzero(chosen), len(starts) > 1
    bad = np.argwhere(~np.isfinite(found))
    if len(bad):
        row, place = bad[0]
        where = f" of machine {of[row]}" if several else ""
        raise InputError(f"state: {names[place]} = {found[row, place]}{where}: must be a finite number")
    for place, f in enumerate(setup.machine.functions):
        at = columns.place[f"{f.name}.angle"]
        low, high = np.array([machines[i].functions[place].stops for i in of.tolist()]).T
        beyond = np.flatnonzero((found[:, at] < low - 1e-9) | (found[:, at] > high + 1e-9))
        if beyond.size:
            row, unit = beyond[0], columns.columns[at].unit
            where = f" of machine {of[row]}" if several else ""
            raise InputError(
                f"state: {names[at]} = {found[row, at]:g} {unit}{where}: must lie between the stops, {low[row]:g} and {high[row]:g} {unit}"
            )
    return found


def _float(value: Any, what: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} = {briefly(value)}: must be a number") from error
