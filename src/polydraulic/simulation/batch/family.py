"""What a batch has to know of machines that share a layout: their columns, and the loop over a block of them."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.machine.frames import AXES, vector
from polydraulic.machine.reach.tip import tip_links
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.lane_blocks import Tips
from polydraulic.simulation.layout.columns import circuit_keys, columns_of, cross_name, fed_functions, kept_quantities
from polydraulic.simulation.layout.module import layout_module

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
    outside : int or None
        Row of the steps outside the flow model's domain, where there can be any.
    beyond_log : int or None
        Row of the steps beyond the log that a machine was identified from, where there is one.
    run : driver
        Of the generated text: fills the rows of one machine.
    run_block : driver
        The same of a block of machines, or None where the flow model has no lanes.
    columns : function from the functions that move to what can be kept
    pump_rows : set of int
        Rows for which pump flows and pressures are needed.
    joints : tuple of str
        Columns of positions of all joints, from which tips follow.
    machine : LayoutMachine
        One of them.
    """

    functions: tuple[str, ...]
    n_state: int
    n_record: int
    n_row: int
    p_in: int
    p_out: int
    steps: int
    unsettled: int | None
    outside: int | None
    beyond_log: int | None
    run: Callable[..., int]
    run_block: Callable[..., None] | None
    columns: Callable[[Sequence[str]], Able]
    pump_rows: set[int]
    joints: tuple[str, ...]
    machine: LayoutMachine


def family_of(machine: LayoutMachine, flow: LayoutFlow, *, force: bool = False) -> Family:
    """Family of a machine and its flow model, with a force at the tip or without."""
    module = layout_module(machine, flow=flow.kernels, force=force)
    of = columns_of(machine, stores_oil=flow.stores_oil)
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
                for key in circuit_keys(c, p_pump=flow.gives_pump_pressure, stores_oil=flow.stores_oil):
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
        module.BEYOND_ROW // module.LANES if lanes and flow.networks is not None else None,
        module.BEYOND_LOG_ROW // module.LANES if lanes else None,
        module.run,
        lanes,
        columns,
        {of.place[key] for c in machine.circuits for key in circuit_keys(c, p_pump=True, stores_oil=flow.stores_oil)},
        tuple(of.columns[of.place[f"{f}.angle"]].name for f in machine.names),
        machine,
    )


def tips_of(family: Family, machines: Sequence[LayoutMachine], row: int) -> Tips:
    """Links from the tip to the ground, with the numbers of the machine of each lane; places go to three rows from `row` on."""
    links, joints = list(reversed(tip_links(family.machine))), [f.moves for f in family.machine.functions]
    columns = family.columns(family.functions)
    return Tips(
        row,
        np.array([columns[family.joints[joints.index(link.name)]][0] for link in links]),
        np.array([AXES[link.axis[-1]] for link in links]),
        np.array([-1.0 if link.axis[0] == "-" else 1.0 for link in links]),
        np.array([link.joint == "prismatic" for link in links]),
        np.array([[vector(machine.link(link.name).at) for machine in machines] for link in links])
        .transpose(0, 2, 1)
        .copy(),
        np.array([vector(machine.tip[1]) for machine in machines]).T.copy(),
    )
