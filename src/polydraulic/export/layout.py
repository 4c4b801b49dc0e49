"""The parts of an exported machine of any layout: the kernels that are written out for it."""

from collections.abc import Collection
from math import ceil

from polydraulic.errors import InputError
from polydraulic.export.machine_parts import MachineParts, check_size
from polydraulic.flow.dispatch import FlowModel, layout_flow
from polydraulic.flow.lookup import table_bytes
from polydraulic.machine.stability.whole_body import chassis_of
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import EFFECTOR, columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.stability.columns import margin_columns
from polydraulic.simulation.layout.stability.text import SLOPE, n_room, watched_module, watched_numbers

FORCE = ("tip.force_x", "tip.force_y", "tip.force_z")  # N, along the axes of the ground


def layout_parts(
    machine: LayoutMachine,
    flow: str | FlowModel,
    *,
    dt: float,
    locked: Collection[str],
    force: bool = False,
    stability: bool = False,
    most_numbers: int = 200_000,
) -> MachineParts:
    """Parts of a machine of any layout.

    Parameters
    ----------
    machine : LayoutMachine
    flow : str or flow model
        ``"exact"``, or networks of this machine.
    dt : float, s
    locked : collection of str
        Functions whose joints are held.
    force : bool
        Whether a force at the tip is among the inputs.
    stability : bool
        Whether margins against tipping are among the outputs, and the slope of the ground among the inputs.
    most_numbers : int
        That tables of the flow model may hold.

    Raises
    ------
    InputError
        A flow model that does not serve a function that is free, or is too large for a C file; unknown functions, or none left to move; margins
        of a machine without a chassis.
    """
    model = layout_flow(flow, machine)
    if set(locked) >= set(machine.names):
        raise InputError(f"locked = {sorted(locked)}: leave one of {list(machine.names)} free")
    missing = [f for f in machine.names if f not in (*locked, *model.served)]
    if missing:
        raise InputError(f"flow {model.name!r} does not serve {', '.join(missing)}; give locked={missing}")
    numbers_held = table_bytes(model.parts) // 8
    check_size(model.name, numbers_held, most_numbers)
    ready = prepare_layout(machine, dt, locked, force=force, flow=model, in_tables=True)
    module = ready.module
    start = getattr(module.from_vector, "py_func", module.from_vector)(ready.start.tolist())
    if stability:
        watched = watched_module(machine, ready, force=force)
        numbers, kernels = (
            watched_numbers(machine, ready, watched, start),
            (watched.watched_start, watched.watched_advance),
        )
    else:
        numbers, kernels = (
            module.Prepared(ready.valves, ready.plant, start),
            (module.machine_start, module.machine_advance),
        )
    columns = columns_of(machine, stores_oil=model.stores_oil).columns
    margins = margin_columns(chassis_of(machine)) if stability else []
    return MachineParts(
        model.name,
        machine.names,
        (*(f"{f}.voltage" for f in machine.names), *(FORCE if force else ()), *(SLOPE if stability else ())),
        (*((column.name, column.unit) for column in columns), *((name, "m") for name in EFFECTOR), *margins),
        numbers,
        *kernels,
        ready.n_memory + (n_room(machine) if stability else 0),
        tuple(ceil(f.pilot.dead_time / dt - 1e-9) for f in machine.functions),
    )
