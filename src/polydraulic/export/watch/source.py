"""A machine that is watched, as C99: the kernels of a row, translated, around numbers that are data.

Two files: ``NAME.h``, which a program includes, and ``NAME.c``. A row has the bits of the package, and allocates nothing.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.c.text import string
from polydraulic.export.exported import Exported, filled, write_exported
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program
from polydraulic.watch.kernels.alarms import ALONE
from polydraulic.watch.kernels.numbers import LISTED, OPENED, STUCK, SUSPECTS
from polydraulic.watch.watch import FREEZE, FaultWatch


def fault_names(watch: FaultWatch) -> list[str]:
    """Faults that a machine is watched for, by their numbers."""
    return list(dict.fromkeys(d.name for d in watch.of.directions))


def watch_c(watch: FaultWatch, *, name: str = "watch") -> dict[str, str]:
    """Texts of the C files of a machine that is watched, by file name.

    Parameters
    ----------
    watch : FaultWatch
        Its machine, sensors, what is to be expected and thresholds become numbers of the file; what it has seen so far does not.
    name : str
        Before all names that the linker sees.

    Raises
    ------
    InputError
        If `name` is not a C identifier.
    """
    if c_name(name) != name:
        raise InputError(
            f"name = {name!r}: must be a C identifier, for example {c_name(name)!r}, that no library has taken"
        )
    judge, of = watch.judge_parts, watch.of
    numbers, n, sensors = judge.numbers, len(of.directions), len(of.columns)
    words = (
        "state",
        "init",
        "update",
        "share",
        "could_show",
        "named",
        "harmless",
        "chance",
        "since",
        "fault_name",
        "fault_of",
        "numbers",
    )
    program = Program([f"{name}_{word}" for word in words])
    row = np.zeros(sensors)
    program.entry(
        f"{name}_kernel_row", judge.kernels.watch_row, [numbers, judge.work, judge.live, judge.marks, 0.0, row]
    )
    faults = fault_names(watch)
    stays = [f"{column}{FREEZE}" for column in of.columns]
    places = {
        "n_sensors": sensors, "n_faults": len(faults), "n_live": len(judge.live), "n_work": len(judge.work), "n_marks": len(judge.marks),
        "n_directions": n, "opened": OPENED, "stuck": STUCK, "listed": LISTED, "suspects": SUSPECTS, "at_sums": numbers.at_sums,
        "at_showing": numbers.at_sums + 2 * n, "at_chances": numbers.at_chances, "in_named": numbers.in_marks + 2 * n + sensors,
        "in_worked": len(judge.marks) - 2 * sensors, "alone": ALONE,
    }  # fmt: skip
    fill = {
        "name": name,
        "NAME": name.upper(),
        "title": of.machine.title.replace("*/", "* /"),
        "dt": repr(float(of.shape.raster)),
        "sensors": _enumerators(f"{name}_row", of.columns),
        "faults": _enumerators(f"{name}_fault", faults),
        "fault_of": ", ".join(str(faults.index(d.name)) for d in of.directions),
        "names": ",\n".join(f"        {string(fault)}" for fault in (*faults, *stays)),
        "structs": program.scope.structs(),
        "data": program.scope.data(numbers, f"{name}_numbers", "static "),
        "code": program.code(),
        **{key: str(place) for key, place in places.items()},
    }
    return filled("watch", name, fill)


def export_watch(watch: FaultWatch, folder: str | Path, *, name: str = "watch") -> Exported:
    """Write the files of `watch_c` into a folder.

    Parameters
    ----------
    watch : FaultWatch
    folder : str or Path
    name : str
        As for `watch_c`.

    Returns
    -------
    Exported
        The header that a program includes, and the source.

    Raises
    ------
    InputError
        As `watch_c`, or if the folder cannot be written.
    """
    return write_exported(watch_c(watch, name=name), folder)


def _enumerators(name: str, of: Sequence[str]) -> str:
    return "\n".join(f"    {name}_{each.replace('.', '_')}".upper() + f" = {k}," for k, each in enumerate(of))
