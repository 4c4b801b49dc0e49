"""What the functions of this package are given: tables, models and machines, or where they are; what each of them checks."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.model_file import load_models
from polydraulic.parameters.load import load_machine
from polydraulic.parameters.schema import Machine
from polydraulic.tables import Table, read_table

Progress = Callable[[str, int, int], object]  # what begins, how much is done, how much there is in all


def table_of(
    given: Table | str | Path, columns: Sequence[str] | None = None, optional: Sequence[str] = ()
) -> tuple[Table, str]:
    """A table or that of a file, and what it is called; only `columns` if given, and those of `optional` that it has.

    Raises
    ------
    InputError
        As `read_table`; also of a table in memory without rows, or with a value that is not a finite number.
    """
    if not isinstance(given, Table):
        return read_table(given, columns, optional=optional), Path(given).name
    wanted = (
        given.names if columns is None else [*columns, *(n for n in optional if n in given.names and n not in columns)]
    )
    table = Table({name: given[name] for name in wanted}, {name: given.unit(name) for name in wanted}, given.info)
    if not len(table):
        raise InputError("the table has no rows")
    for name in wanted:
        bad = np.flatnonzero(~np.isfinite(table[name]))
        if bad.size:
            raise InputError(
                f"column {name!r} holds {table[name][bad[0]]} in row {bad[0] + 1} ({bad.size} of {len(table)} rows); "
                "every value must be a finite number: drop these rows or fill them first"
            )
    return table, "table"


def models_of(given: Sequence[Model] | str | Path) -> list[Model]:
    """Models, or those of a model file."""
    return load_models(given) if isinstance(given, str | Path) else list(given)


def machine_of(given: Machine | str | Path) -> Machine:
    """A machine, or a parameter set by its name or file."""
    return given if isinstance(given, Machine) else load_machine(given)


def steps_of(progress: Progress | None, total: int) -> Callable[[str], None]:
    """A function that is called as each of `total` steps begins, and tells `progress` how many are done."""
    begun = 0

    def begin(what: str) -> None:
        nonlocal begun
        if progress is not None:
            progress(what, begun, total)
        begun += 1

    return begin


def check_columns(table: Table, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse a column that is both input and output, or constant."""
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(f"column {sorted(both)[0]!r} is both input and output")
    for name in [*inputs, *outputs]:
        if len(table) and np.ptp(table[name]) == 0.0:
            role = "cannot explain anything: leave it out" if name in inputs else "needs no model"
            raise InputError(f"column {name!r} is {table[name][0]:g} in all {len(table)} rows; it {role}")
