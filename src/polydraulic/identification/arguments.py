"""What the functions of this package are given: tables and models, or where they are; what each of them checks."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.model_file import load_models
from polydraulic.tables import Table, finite, read_table


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
        finite(table[name], name)
    return table, "table"


def models_of(given: Sequence[Model] | str | Path) -> list[Model]:
    """Models, or those of a model file."""
    return load_models(given) if isinstance(given, str | Path) else list(given)


def check_columns(table: Table, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse a column that is both input and output, or constant."""
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(f"column {sorted(both)[0]!r} is both input and output")
    for name in [*inputs, *outputs]:
        if len(table) and np.ptp(table[name]) == 0.0:
            role = "cannot explain anything: leave it out" if name in inputs else "needs no model"
            raise InputError(f"column {name!r} is {table[name][0]:g} in all {len(table)} rows; it {role}")
