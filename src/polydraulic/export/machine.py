"""The whole machine as C99: the kernels of a step, translated, around parameters that are data.

Five files: ``NAME.h`` and ``NAME.c``, which a program uses; ``NAME_kernels.h`` and ``NAME_kernels.c``, the physics as
`simulation.step` writes it; ``NAME_parameters.c``, the numbers of the machine and its flow model.
"""

from collections.abc import Collection
from math import ceil
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import sincos
from polydraulic.errors import InputError
from polydraulic.export.exported import Exported
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program
from polydraulic.files import write_texts
from polydraulic.flow.dispatch import FLOW_KINDS, FlowModel, as_flow, flow_name, served_links
from polydraulic.flow.record import COLUMNS, EFFECTOR, N_RECORD, Column, from_vector
from polydraulic.machine.linkage import tip
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, State, initial_state
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.schema import LINKS, Geometry, Machine
from polydraulic.simulation.loop import at_rest, reasonable, record
from polydraulic.simulation.step import machine_step

DIVERGED = 4  # beside the flow model's OK, NOT_CONVERGED and OUT_OF_DOMAIN
MOST_NUMBERS = 200_000  # in tables of a flow model: 4 MB of text
_TEMPLATES = Path(__file__).parent / "templates"


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
def machine_advance(
    machine: Prepared, memory: np.ndarray, row: np.ndarray, v_sw: float, v_bo: float, v_st: float
) -> int:
    """One step from the state in a row to that after it; the row stays as it is where a rate leaves all reason."""
    x = from_vector(row)
    step = machine_step(machine.model, memory, machine.plant, x, Links(v_sw, v_bo, v_st))
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
    most_numbers: int = MOST_NUMBERS,
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


def machine_c(
    machine: Machine | str | Path,
    flow: str | FlowModel,
    *,
    name: str = "machine",
    dt: float = 5e-3,
    locked: Collection[str] = (),
    most_numbers: int = MOST_NUMBERS,
) -> dict[str, str]:
    """Texts of the C files by file name.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    flow : str or flow model
        Any whose kernel translates: ``"exact"``, ``"polynomial"``, ``"neural"``, ``"iterative"``, ``"stiff"``, ``"tlm"``.
    name : str
        Of the machine, before all names that the linker sees.
    dt : float, s
        Time step; part of the numbers, so that it cannot change later.
    locked : collection of str
        Links whose joints are held, and whose voltages are ignored.
    most_numbers : int
        That tables of the flow model may hold: 4 MB of text.

    Raises
    ------
    InputError
        As `prepared`; if `name` is no C identifier; with file and line where a kernel does not translate.
    """
    machine = as_machine(machine)
    if c_name(name) != name:
        raise InputError(f"name = {name!r}: must be a C identifier, for example {c_name(name)!r}")
    parts = prepared(machine, flow, dt=dt, locked=locked, most_numbers=most_numbers)
    kind = flow_name(parts.model)
    memory, row = np.zeros(FLOW_KINDS[kind].n_memory(parts.model)), np.zeros(len(outputs()))
    own = ("machine", "init", "step", "advance", "init_with", "step_with", "parameters")
    program = Program([f"{name}_{word}" for word in own])
    start = program.entry(f"{name}_kernel_start", machine_start, [parts, memory, row])
    advance = program.entry(f"{name}_kernel_advance", machine_advance, [parts, memory, row, 0.0, 0.0, 0.0])
    delays = _delays(machine, dt)
    fill = {
        "name": name,
        "NAME": name.upper(),
        "flow": kind,
        "dt": repr(float(dt)),
        "outputs": _enumerators(name),
        "n_memory": str(len(memory)),
        "n_waiting": str(max(1, *delays)),
        "delays": ", ".join(map(str, delays)),
        "free": ", ".join("false" if link in locked else "true" for link in LINKS),
        "structs": program.scope.structs(),
        "prototypes": f"{start.prototype};\n{advance.prototype};",
        "code": program.code(),
        "data": program.scope.data(parts, f"{name}_parameters"),
    }
    files = {
        file: Template((_TEMPLATES / f"machine{file}.txt").read_text(encoding="utf-8")).substitute(fill)
        for file in (".h", ".c", "_kernels.h", "_kernels.c", "_parameters.c")
    }
    return {f"{name}{file}": text for file, text in files.items()}


def machine_size(machine: Machine, flow: str | FlowModel, *, dt: float = 5e-3) -> int:
    """Numbers of 8 bytes in the struct of a machine.

    Parameters
    ----------
    machine, flow, dt
        As for `machine_c`.
    """
    model = as_flow(flow, machine)
    n_memory = FLOW_KINDS[flow_name(model)].n_memory(model)
    return len(outputs()) + n_memory + len(LINKS) * max(1, *_delays(machine, dt)) + 2


def export_machine(
    machine: Machine | str | Path,
    flow: str | FlowModel,
    folder: str | Path,
    *,
    name: str = "machine",
    dt: float = 5e-3,
    locked: Collection[str] = (),
) -> Exported:
    """Write the files of `machine_c` into a folder.

    Parameters
    ----------
    machine, flow, name, dt, locked
        As for `machine_c`.
    folder : str or Path

    Returns
    -------
    Exported
        The header that a program includes, and the other files.

    Raises
    ------
    InputError
        As `machine_c`, or if the folder cannot be written.
    """
    texts = machine_c(machine, flow, name=name, dt=dt, locked=locked)
    files = {Path(folder) / file: text for file, text in texts.items()}
    write_texts(files)
    return Exported(tuple(files))


def _delays(machine: Machine, dt: float) -> list[int]:
    """Steps of the pilots' dead times, rounded up."""
    return [ceil(getattr(machine, link).pilot.dead_time / dt - 1e-9) for link in LINKS]


def _enumerators(name: str) -> str:
    lines = []
    for number, output in enumerate(outputs()):
        lines.append(f"    {name}_{output.name.replace('.', '_')}".upper() + f" = {number}, /* {output.unit} */")
    return "\n".join([*lines, f"    {name.upper()}_N_OUTPUTS = {len(lines)}"])


def _count(value: Any) -> int:
    """Numbers in a model."""
    if isinstance(value, np.ndarray):
        return value.size
    return sum(map(_count, value)) if isinstance(value, tuple) else 1
