"""The whole machine as C99: the kernels of a step, translated, around parameters that are data.

Five files: ``NAME.h`` and ``NAME.c``, which a program uses; ``NAME_kernels.h`` and ``NAME_kernels.c``, the physics of
a step (`polydraulic machine show`); ``NAME_parameters.c``, the numbers of the machine and its flow model.
"""

from collections.abc import Collection
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.exported import Exported, filled, write_exported
from polydraulic.export.layout import FORCE, layout_parts
from polydraulic.export.machine_parts import MachineParts
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program
from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.stability.text import SLOPE

MOST_NUMBERS = 200_000  # in tables of a flow model: 4 MB of text


def machine_parts(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    *,
    dt: float = 5e-3,
    locked: Collection[str] = (),
    force: bool = False,
    stability: bool = False,
    most_numbers: int = MOST_NUMBERS,
) -> MachineParts:
    """Kernels and numbers of a machine, from the same preparation as `simulate`; arguments as for `machine_c`."""
    return layout_parts(
        as_machine(machine), flow, dt=dt, locked=locked, force=force, stability=stability, most_numbers=most_numbers
    )


def machine_c(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    *,
    name: str | None = None,
    dt: float = 5e-3,
    locked: Collection[str] = (),
    force: bool = False,
    stability: bool = False,
    most_numbers: int = MOST_NUMBERS,
) -> dict[str, str]:
    """Texts of the C files by file name.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str or flow model
        ``"exact"``, ``"iterative"``, ``"stiff"``, ``"tlm"``, or networks: those of the package for cat215b, others from `build_flow`.
    name : str, optional
        Of the machine, before all names that the linker sees; that of its file or parameter set if not given, ``"machine"`` where
        it comes without one.
    dt : float, s
        Time step; part of the numbers, so that it cannot change later.
    locked : collection of str
        Functions whose joints are held, and whose voltages are ignored.
    force : bool
        Whether three more inputs are a force in N at the tip, along the ground's axes.
    stability : bool
        Whether the columns of ``simulate(..., stability=True)`` are outputs too, and two more inputs how the ground rises along the machine's x
        and y, in rad: weight turns with it in the margins, and not in the motion. They are those of the state after a step, with the inputs of the step.
    most_numbers : int
        That tables of the flow model may hold: 4 MB of text.

    Raises
    ------
    InputError
        If the flow model does not serve a function that is free, or its tables are too large for a C file; if `name` is not a C
        identifier; with file and line where a kernel does not translate.
    """
    name = export_name(machine) if name is None else name
    if c_name(name) != name:
        raise InputError(
            f"name = {name!r}: must be a C identifier, for example {c_name(name)!r}, that no library has taken"
        )
    return c_files(
        machine_parts(machine, flow, dt=dt, locked=locked, force=force, stability=stability, most_numbers=most_numbers),
        name,
        dt,
        locked,
    )


def export_name(machine: LayoutMachine | str | Path) -> str:
    """Identifier of an export: the name of a machine's file or parameter set, ``"machine"`` for one that comes without."""
    return c_name(Path(machine).stem) if isinstance(machine, (str, Path)) else "machine"


def c_files(parts: MachineParts, name: str, dt: float, locked: Collection[str]) -> dict[str, str]:
    """Texts of the C files of a machine's parts, by file name; `name`, `dt` and `locked` as for `machine_c`."""
    memory, row, inputs = np.zeros(parts.n_memory), np.zeros(len(parts.outputs)), np.zeros(len(parts.inputs))
    own = ("machine", "init", "step", "advance", "init_with", "step_with", "parameters")
    program = Program([f"{name}_{word}" for word in own])
    start = program.entry(f"{name}_kernel_start", parts.start, [parts.numbers, memory, row])
    advance = program.entry(f"{name}_kernel_advance", parts.advance, [parts.numbers, memory, row, inputs])
    fill = {
        "name": name,
        "NAME": name.upper(),
        "flow": parts.flow,
        "dt": repr(float(dt)),
        "functions": ", ".join(parts.functions),
        "forces": _more_inputs(parts),
        "n_functions": str(len(parts.functions)),
        "n_inputs": str(len(parts.inputs)),
        "outputs": _enumerators(name, parts),
        "an_output": f"{name}_{_joint(parts)}".upper(),
        "n_memory": str(len(memory)),
        "n_waiting": str(max(1, *parts.delays)),
        "delays": ", ".join(map(str, parts.delays)),
        "free": ", ".join("false" if f in locked else "true" for f in parts.functions),
        "structs": program.scope.structs(),
        "prototypes": f"{start.prototype};\n{advance.prototype};",
        "code": program.code(),
        "data": program.scope.data(parts.numbers, f"{name}_parameters"),
    }
    return filled("machine", name, fill, (".h", ".c", "_kernels.h", "_kernels.c", "_parameters.c"))


def export_machine(
    machine: LayoutMachine | str | Path,
    flow: str | FlowModel,
    folder: str | Path,
    *,
    name: str | None = None,
    dt: float = 5e-3,
    locked: Collection[str] = (),
    force: bool = False,
    stability: bool = False,
) -> Exported:
    """Write the files of `machine_c` into a folder.

    Parameters
    ----------
    machine, flow, name, dt, locked, force, stability
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
    texts = machine_c(machine, flow, name=name, dt=dt, locked=locked, force=force, stability=stability)
    return write_exported(texts, folder)


def _enumerators(name: str, parts: MachineParts) -> str:
    lines = []
    for number, (output, unit) in enumerate(parts.outputs):
        lines.append(f"    {name}_{output.replace('.', '_')}".upper() + f" = {number}, /* {unit} */")
    return "\n".join([*lines, f"    {name.upper()}_N_OUTPUTS = {len(lines)}"])


def _more_inputs(parts: MachineParts) -> str:
    """What comes behind the voltages."""
    force = "; then a force in N at the tip, x, y and z of the ground" if FORCE[0] in parts.inputs else ""
    slope = (
        "; then how the ground rises along the machine's x and y, in rad, for its margins"
        if SLOPE[0] in parts.inputs
        else ""
    )
    return force + slope


def _joint(parts: MachineParts) -> str:
    """An output that says where a joint is."""
    return next(output for output, _ in parts.outputs if output.endswith((".angle", ".position"))).replace(".", "_")
