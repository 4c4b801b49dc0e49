"""A machine that is watched, as C99: the kernels of a row, translated, around numbers that are data.

Two files: ``NAME.h``, which a program includes, and ``NAME.c``. A row has the bits of the package, and allocates nothing.
"""

from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.exported import Exported, filled, write_exported
from polydraulic.export.model_bundle import c_name
from polydraulic.export.translate.program import Program
from polydraulic.export.watch.networks import networks_c
from polydraulic.export.watch.self_test import self_test_texts
from polydraulic.export.watch.texts import enumerators, number_lines, strings
from polydraulic.watch.drift import BIAS, DRIFT
from polydraulic.watch.kernels.alarms import ALONE
from polydraulic.watch.kernels.numbers import COURSE, GROWS, LISTED, OPENED, STUCK, SUSPECTS
from polydraulic.watch.watch import FREEZE, FaultWatch

# behind the name, of what the file declares itself
_WORDS = (
    "state", "init", "update", "share", "could_show", "named", "harmless", "chance", "since", "fault_name", "fault_of", "bias_of", "shown_by", "likely",
    "drifts", "numbers", "kinds", "kind", "certainty", "familiar", "kind_name",
)  # fmt: skip


def fault_names(watch: FaultWatch) -> list[str]:
    """Faults that a machine is watched for, by their numbers."""
    return list(dict.fromkeys(d.name for d in watch.of.directions))


def all_names(watch: FaultWatch) -> list[str]:
    """What an alarm may be named, by number: faults, sensors that stay, sensors that drift."""
    columns = watch.of.columns
    return [
        *fault_names(watch),
        *(f"{column}{FREEZE}" for column in columns),
        *(f"{column}{DRIFT}" for column in columns),
    ]


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
    judge = watch.judge_parts
    program = Program([f"{name}_{word}" for word in _WORDS])
    row = np.zeros(len(watch.of.columns))
    program.entry(
        f"{name}_kernel_row", judge.kernels.watch_row, [judge.numbers, judge.work, judge.live, judge.marks, 0.0, row]
    )
    texts = _texts(watch, name)
    networks = networks_c(watch, program, texts)
    data = program.scope.data(judge.numbers, f"{name}_numbers", "static ")
    texts |= {
        "ask": networks.ask,
        "rooms": networks.rooms,
        "structs": program.scope.structs(),
        "data": "\n".join([data, networks.data]),
        "code": program.code(),
        "self_test": filled("watch_self_test", name, texts | self_test_texts(watch), (".c",))[f"{name}.c"],
    }
    header = filled("watch", name, {**texts, "networks": networks.header}, (".h",))
    return header | filled("watch", name, {**texts, "networks": networks.source}, (".c",))


def _texts(watch: FaultWatch, name: str) -> dict[str, str]:
    """Names, and places in the state, that the templates are filled with."""
    judge, of, faults = watch.judge_parts, watch.of, fault_names(watch)
    n, sensors, at_sums = len(of.directions), len(of.columns), judge.numbers.at_sums
    biases = [f"{column}{BIAS}" for column in of.columns]
    places = {
        "n_sensors": sensors, "n_faults": len(faults), "n_live": len(judge.live), "n_work": len(judge.work), "n_marks": len(judge.marks),
        "n_directions": n, "opened": OPENED, "stuck": STUCK, "listed": LISTED, "suspects": SUSPECTS, "course": COURSE, "grows": GROWS,
        "at_sums": at_sums, "at_showing": at_sums + 2 * n, "at_chances": judge.numbers.at_chances,
        "in_named": judge.numbers.in_marks + 2 * n + sensors, "in_worked": len(judge.marks) - 2 * sensors, "alone": ALONE,
    }  # fmt: skip
    return {
        "name": name,
        "NAME": name.upper(),
        "title": of.machine.title.replace("*/", "* /"),
        "dt": repr(float(of.shape.raster)),
        "sensors": enumerators(f"{name}_row", of.columns),
        "faults": enumerators(f"{name}_fault", faults),
        "fault_of": number_lines([faults.index(d.name) for d in of.directions]),
        "bias_of": number_lines([faults.index(bias) if bias in faults else -1 for bias in biases]),
        "names": strings(all_names(watch)),
        **{key: str(place) for key, place in places.items()},
    }


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
