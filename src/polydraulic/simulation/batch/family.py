"""What a batch has to know of machines that share a layout: their columns, and the loop over a block of them."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.flow.dispatch import FLOW_KINDS, flow_name
from polydraulic.flow.lanes import P_IN
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.flow.record import ANGLE, N_RECORD, N_STATE, PLACE, circuit_columns, link_columns, working_circuits
from polydraulic.machine.frames import link_frames, placed
from polydraulic.machine.linkage import end_effector
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import LINKS, Geometry, Machine
from polydraulic.simulation.batch.lanes import N_ROW, P_OUT, STEPS, run_block
from polydraulic.simulation.layout.columns import circuit_keys, columns_of, cross_name, fed_functions, kept_quantities
from polydraulic.simulation.layout.module import layout_module
from polydraulic.simulation.loop import run

Able = dict[str, tuple[int, str]]  # row in a block, and unit, of everything that can be kept


class Family(NamedTuple):
    """Machines of one layout.

    Attributes
    ----------
    functions : tuple of str
    n_state, n_record, n_row : int
        Numbers of a state, of a recorded step, rows of a block.
    p_in, p_out : int
        First rows of the pressures at pressurised ports and at outlets.
    steps : int
        Row of the steps made.
    unsettled : int or None
        Row of the steps that did not converge, where there can be any.
    run : driver
        As `simulation.loop.run`.
    run_block : driver
        As `simulation.batch.lanes.run_block`, or None where the flow model has no lanes.
    columns : function from the functions that move to what can be kept
    pump_rows : set of int
        Rows for which pump flows and pressures are needed.
    joints : tuple of str
        Columns of positions of all joints, from which tips follow.
    tips : function (machines, which of them (n,), (n, ..., n_function) positions) -> (n, ..., 3) array, m
    """

    functions: tuple[str, ...]
    n_state: int
    n_record: int
    n_row: int
    p_in: int
    p_out: int
    steps: int
    unsettled: int | None
    run: Callable[..., int]
    run_block: Callable[..., None] | None
    columns: Callable[[Sequence[str]], Able]
    pump_rows: set[int]
    joints: tuple[str, ...]
    tips: Callable[[Sequence[Any], np.ndarray, np.ndarray], np.ndarray]


def family_of(machine: Machine | LayoutMachine, model: Any, *, force: bool = False) -> Family:
    """Family of a machine and its flow model, with a force at the tip or without."""
    if isinstance(machine, LayoutMachine):
        return _of_layout(machine, model, force)
    return _of_excavator(flow_name(model))


def _of_layout(machine: LayoutMachine, flow: LayoutFlow, force: bool) -> Family:
    module, of = layout_module(machine, flow=flow.kernels, force=force), columns_of(machine)
    n, p_in = len(machine.names), len(of.columns)
    lanes = getattr(module, "run_block", None)

    def columns(free: Sequence[str]) -> Able:
        found: Able = {}

        def add(key: str) -> None:
            column = of.columns[of.place[key]]
            found[column.name] = (of.place[key], column.unit)

        for place, f in enumerate(machine.names):
            if f not in free:
                add(f"{f}.angle")
                continue
            for quantity in kept_quantities(machine.function(f)):
                add(f"{f}.{quantity}")
            found[f"{f}.p_in"], found[f"{f}.p_out"] = (p_in + place, "Pa"), (p_in + n + place, "Pa")
        for c in machine.circuits:
            if fed_functions(machine, c.name) & set(free):
                for key in circuit_keys(c, p_pump=flow.gives_pump_pressure):
                    add(key)
        for x in machine.crossovers:
            if fed_functions(machine, x.giving) & set(free):
                add(cross_name(x.giving))
        return found

    return Family(
        machine.names,
        of.n_state,
        p_in,
        module.N_ROW if lanes else p_in + 2 * n,
        p_in,
        p_in + n,
        module.STEPS_ROW // module.LANES if lanes else 0,
        module.UNSETTLED_ROW // module.LANES if lanes else None,
        module.run,
        lanes,
        columns,
        set(),  # they are always found
        tuple(of.columns[of.place[f"{f}.angle"]].name for f in machine.names),
        _layout_tips,
    )


def _layout_tips(machines: Sequence[LayoutMachine], which: np.ndarray, positions: np.ndarray) -> np.ndarray:
    found = np.empty((*positions.shape[:-1], 3))
    for number, machine in enumerate(machines):
        mine = np.flatnonzero(which == number)
        found[mine] = placed(link_frames(machine, positions[mine]), *machine.tip)
    return found


def _excavator_tips(machines: Sequence[Machine], which: np.ndarray, positions: np.ndarray) -> np.ndarray:
    geometry = np.array([machine.geometry for machine in machines])[which].T
    return end_effector(positions, Geometry(*geometry.reshape(len(geometry), -1, *[1] * (positions.ndim - 2))))


def _of_excavator(flow: str) -> Family:
    kind = FLOW_KINDS[flow]

    def columns(free: Sequence[str]) -> Able:
        found: Able = {}
        for place, link in enumerate(LINKS):
            if link not in free:
                found[f"{link}.angle"] = (ANGLE + place, "rad")
                continue
            found |= {name: (PLACE[name], unit) for name, unit in link_columns(link)}
            found[f"{link}.p_in"], found[f"{link}.p_out"] = (P_IN + place, "Pa"), (P_OUT + place, "Pa")
        for circuit in working_circuits(set(LINKS) - set(free)):
            given = circuit_columns(circuit, p_pump=kind.gives_pump_pressure, q_stored=kind.has_state)
            found |= {name: (PLACE[name], unit) for name, unit in given}
        return found

    return Family(
        LINKS,
        N_STATE,
        N_RECORD,
        N_ROW,
        P_IN,
        P_OUT,
        STEPS,
        None,
        run,
        run_block if kind.lanes else None,
        columns,
        {
            row
            for name, row in PLACE.items()
            if name.split(".")[0] in ("boom", "series") and row >= PLACE["boom.q_pump"]
        },
        tuple(f"{link}.angle" for link in LINKS),
        _excavator_tips,
    )
