"""The parts of an exported machine with the layout of cat215b, whatever its flow model."""

from collections.abc import Collection
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.errors import InputError
from polydraulic.export.machine_parts import MachineParts
from polydraulic.flow.dispatch import FLOW_KINDS, FlowModel, as_flow, flow_name, served_links
from polydraulic.flow.record import COLUMNS, EFFECTOR, N_RECORD, Column, from_vector
from polydraulic.machine.linkage import tip
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, State, initial_state
from polydraulic.parameters.schema import LINKS, Geometry, Machine
from polydraulic.simulation.loop import DIVERGED, at_rest, reasonable, record
from polydraulic.simulation.step import machine_step


class Prepared(NamedTuple):
    """All numbers that a step reads."""

    model: Any
    plant: Plant
    geometry: Geometry
    start: State


@kernel
def _record_tip(angle: Links, g: Geometry, row: np.ndarray) -> None:
    point = tip(sincos(angle.swing), sincos(angle.boom), sincos(angle.boom + angle.stick), g)
    row[N_RECORD], row[N_RECORD + 1], row[N_RECORD + 2] = point.x, point.y, point.z


@kernel
def machine_start(machine: Prepared, memory: np.ndarray, row: np.ndarray) -> int:
    """Outputs at the start, with centred spools; returns the flow model's status."""
    step = at_rest(machine.model, memory, machine.plant, machine.start)
    record(step, row)
    _record_tip(step.state.angle, machine.geometry, row)
    return step.flows.status


@kernel
def machine_advance(machine: Prepared, memory: np.ndarray, row: np.ndarray, inputs: np.ndarray) -> int:
    """One step from the state in a row to that after it; the row stays as it is where a rate diverges."""
    x = from_vector(row)
    step = machine_step(machine.model, memory, machine.plant, x, Links(inputs[0], inputs[1], inputs[2]))
    if not reasonable(step.state.rate):
        return DIVERGED
    record(step, row)
    _record_tip(step.state.angle, machine.geometry, row)
    return step.flows.status


def outputs() -> list[Column]:
    """What the exported machine gives after each step, in its order: a recorded row, and the tip."""
    return [*COLUMNS, *(Column(name, "m") for name in EFFECTOR)]


def prepared(
    machine: Machine,
    flow: str | FlowModel,
    *,
    dt: float = 5e-3,
    locked: Collection[str] = (),
    most_numbers: int = 200_000,
) -> Prepared:
    """Collect the numbers of a step, from the same preparation as `simulate`.

    Parameters
    ----------
    machine : Machine
    flow : str or flow model
    dt : float, s
    locked : collection of str
        Links whose joints are held.
    most_numbers : int
        That tables of the flow model may hold.

    Raises
    ------
    InputError
        If the flow model does not serve a link that is free, or its tables are too large for a C file.
    """
    unknown = set(locked) - set(LINKS)
    if unknown or set(locked) == set(LINKS):
        raise InputError(f"locked = {sorted(locked)}: must be some of {list(LINKS)}, and leave one free")
    model = as_flow(flow, machine)
    missing = [link for link in LINKS if link not in locked and link not in served_links(model)]
    if missing:
        raise InputError(f"flow {flow_name(model)!r} does not serve {', '.join(missing)}; give locked={missing}")
    numbers = _count(model)
    if numbers > most_numbers:
        raise InputError(
            f"flow {flow_name(model)!r} holds {numbers} numbers; a C file takes up to {most_numbers}: make it smaller"
        )
    return Prepared(model, prepare(machine, dt, locked), machine.geometry, initial_state(machine))


def excavator_parts(
    machine: Machine, flow: str | FlowModel, *, dt: float, locked: Collection[str], most_numbers: int
) -> MachineParts:
    """Parts of an excavator; see `machine_parts.MachineParts` and `prepared`."""
    numbers = prepared(machine, flow, dt=dt, locked=locked, most_numbers=most_numbers)
    kind = flow_name(numbers.model)
    return MachineParts(
        kind,
        LINKS,
        tuple(f"{link}.voltage" for link in LINKS),
        tuple((column.name, column.unit) for column in outputs()),
        numbers,
        machine_start,
        machine_advance,
        FLOW_KINDS[kind].n_memory(numbers.model),
        tuple(ceil(getattr(machine, link).pilot.dead_time / dt - 1e-9) for link in LINKS),
    )


def _count(value: Any) -> int:
    """Numbers in a model."""
    if isinstance(value, np.ndarray):
        return value.size
    return sum(map(_count, value)) if isinstance(value, tuple) else 1
