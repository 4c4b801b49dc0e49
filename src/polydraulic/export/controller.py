"""A coordinated controller as C99: the kernels of a call, translated, around numbers that are data.

Two files: ``NAME.h``, which a program includes, and ``NAME.c``. A call has the bits of the package, and allocates nothing.
"""

from pathlib import Path

import numpy as np

from polydraulic.control.coordinated import VELOCITIES, CoordinatedControl
from polydraulic.errors import InputError
from polydraulic.export.exported import Exported, filled, write_exported
from polydraulic.export.machine import MOST_NUMBERS
from polydraulic.export.machine_parts import check_size
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program


def controller_c(control: CoordinatedControl, *, name: str = "controller") -> dict[str, str]:
    """Texts of the C files of a controller by file name.

    Parameters
    ----------
    control : CoordinatedControl
        Its machine, flow model and settings become numbers of the file; what it has done so far does not.
    name : str
        Before all names that the linker sees.

    Raises
    ------
    InputError
        If `name` is not a C identifier, or networks are too large for a C file.
    """
    if c_name(name) != name:
        raise InputError(
            f"name = {name!r}: must be a C identifier, for example {c_name(name)!r}, that no library has taken"
        )
    parts, n = control.parts, len(control.names)
    arrays = {"scratch": parts.n_scratch, "live": parts.n_live}
    check_size("networks", parts.n_number, MOST_NUMBERS)
    program = Program([f"{name}_{word}" for word in ("state", "init", "step", "numbers")])
    examples = [
        parts.numbers,
        *(np.zeros(size) for size in arrays.values()),
        np.zeros(3 * n),
        np.zeros(len(VELOCITIES)),
        np.zeros(n),
    ]
    program.entry(f"{name}_kernel_step", parts.step, examples)
    fill = {
        "name": name,
        "NAME": name.upper(),
        "dt": repr(float(control.dt)),
        "functions": ", ".join(control.names),
        "velocities": ", ".join(VELOCITIES),
        "n_functions": str(n),
        "n_measured": str(3 * n),
        "n_velocities": str(len(VELOCITIES)),
        **{f"n_{key}": str(size) for key, size in arrays.items()},
        "share": str(parts.share),
        "structs": program.scope.structs(),
        "data": program.scope.data(parts.numbers, f"{name}_numbers", "static "),
        "code": program.code(),
    }
    return filled("controller", name, fill)


def export_controller(control: CoordinatedControl, folder: str | Path, *, name: str = "controller") -> Exported:
    """Write the files of `controller_c` into a folder.

    Parameters
    ----------
    control : CoordinatedControl
    folder : str or Path
    name : str
        As for `controller_c`.

    Returns
    -------
    Exported
        The header that a program includes, and the source.

    Raises
    ------
    InputError
        As `controller_c`, or if the folder cannot be written.
    """
    return write_exported(controller_c(control, name=name), folder)
