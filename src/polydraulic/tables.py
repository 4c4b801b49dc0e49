"""Tables: named columns of numbers with units, read from and written to CSV and Parquet.

A simulated run, a training database and a measured log are all such tables. In a CSV file the header carries the
unit in brackets, ``boom.p_in [Pa]``; in a Parquet file it is in the metadata of the field.
"""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.files import replacing

_HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*$")
_INFO_KEY = b"polydraulic"


@dataclass(frozen=True)
class Table:
    """Named columns of equal length, each with a unit.

    Attributes
    ----------
    columns : dict from name to (n_row,) array of float
    units : dict from name to unit; empty string where none was given
    info : what made the table (plain numbers and strings); kept in Parquet metadata
    """

    columns: dict[str, np.ndarray]
    units: dict[str, str]
    info: dict[str, object] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise InputError(f"no column {name!r}; the table has {list(self.columns)}")
        return self.columns[name]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    @property
    def names(self) -> list[str]:
        """Column names, in order."""
        return list(self.columns)

    def unit(self, name: str) -> str:
        """Unit of a column; empty where none was given."""
        return self.units.get(name, "")

    def matrix(self, names: Sequence[str]) -> np.ndarray:
        """Return the named columns side by side, shape (n_row, n_name)."""
        return np.column_stack([self[name] for name in names])


def write_table(table: Table, path: str | Path) -> None:
    """Write a table as ``.csv`` or ``.parquet``.

    Raises
    ------
    InputError
        If the ending is neither, or the place cannot be written.
    """
    with table_writer(path, {name: table.unit(name) for name in table.names}, table.info) as write:
        write([table[name] for name in table.names])


@contextmanager
def table_writer(
    path: str | Path, units: Mapping[str, str], info: Mapping[str, object] | None = None
) -> Iterator[Callable[[Sequence[np.ndarray]], None]]:
    """Write a table block by block; the function it gives takes the columns of a block, in order.

    Parameters
    ----------
    path : str or Path
        As for `write_table`.
    units : mapping from name to unit
        The columns.
    info : mapping, optional
    """
    ending = table_ending(path)
    with replacing(path) as temporary:
        if ending == ".csv":
            with temporary.open("w", encoding="utf-8") as file:
                file.write(
                    ",".join(_quoted(f"{name} [{unit}]" if unit else name) for name, unit in units.items()) + "\n"
                )

                def write_rows(columns: Sequence[np.ndarray]) -> None:
                    np.savetxt(file, np.column_stack(columns), fmt="%.17g", delimiter=",")

                yield write_rows
        else:
            import pyarrow as pa
            import pyarrow.parquet as pq

            fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in units.items()]
            schema = pa.schema(fields, metadata={_INFO_KEY: json.dumps(dict(info or {}))})
            with pq.ParquetWriter(temporary, schema) as file:
                yield lambda columns: file.write_table(pa.table(list(columns), schema=schema))


def _quoted(head: str) -> str:
    """A head of a CSV column, in quotes where it holds a comma."""
    return '"' + head.replace('"', '""') + '"' if "," in head or '"' in head else head


def read_table(path: str | Path, columns: Sequence[str] | None = None, *, optional: Sequence[str] = ()) -> Table:
    """Read a CSV or Parquet table; only `columns` if given, and those of `optional` that it has.

    Raises
    ------
    InputError
        If the file is missing, is not a table, lacks a column, or holds something that is not a finite number
        (named with its column and row).
    """
    path = Path(path)
    ending = table_ending(path)
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    import pyarrow as pa

    try:
        if ending == ".csv":
            from pyarrow import csv

            raw = csv.read_csv(path)
        else:
            import pyarrow.parquet as pq

            raw = pq.read_table(path)
    except (pa.ArrowInvalid, pa.ArrowKeyError, OSError) as error:
        raise InputError(f"{path}: cannot be read as a {ending[1:]} table ({str(error).splitlines()[0]})") from error
    if raw.num_rows == 0:
        raise InputError(f"{path}: the table has no rows")
    names, units = [], {}
    for entry in raw.schema:
        match = _HEADER.match(entry.name) if ending == ".csv" else None
        name = match["name"] if match else entry.name
        unit = (match["unit"] if match else (entry.metadata or {}).get(b"unit", b"").decode()) or ""
        if name in units:
            raise InputError(f"{path}: column {name!r} appears twice; give each column its own name")
        names.append(name)
        units[name] = unit
    wanted = (
        [*columns, *(name for name in optional if name in units and name not in columns)]
        if columns is not None
        else names
    )
    missing = [name for name in wanted if name not in units]
    if missing:
        raise InputError(f"{path}: no column {missing[0]!r}; the table has {names}")
    data = {name: _numbers(raw.column(names.index(name)), name, path) for name in wanted}
    stored = (raw.schema.metadata or {}).get(_INFO_KEY)
    return Table(data, {name: units[name] for name in wanted}, json.loads(stored) if stored else {})


def table_ending(path: str | Path) -> str:
    """Ending of a table's path, or an InputError."""
    ending = Path(path).suffix.lower()
    if ending not in (".csv", ".parquet"):
        raise InputError(f"{path}: a table ends in .csv or .parquet, not in {ending!r}")
    return ending


def _numbers(column: object, name: str, path: Path) -> np.ndarray:
    import pyarrow as pa

    assert isinstance(column, pa.ChunkedArray)
    if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        shown = next((str(v) for v in column.to_pylist() if v is not None), "no values")
        raise InputError(f"{path}: column {name!r} holds {shown!r}; every value must be a finite number")
    values = column.cast(pa.float64()).to_numpy(zero_copy_only=False).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            f"{path}: column {name!r} holds {values[bad[0]]} in row {bad[0] + 1} ({bad.size} of {values.size} rows); "
            "every value must be a finite number: drop these rows or fill them first"
        )
    return values


def shown_column(table: Table, name: str, units: str = DEFAULT) -> tuple[np.ndarray, str]:
    """A column, (n_row,), as it is shown, and its unit."""
    unit = table.unit(name)
    return as_shown(table[name], unit, units), shown_unit(unit, units)


def shown_table(table: Table, units: str = DEFAULT) -> Table:
    """A table with all columns as they are shown: to be read, not to compute with."""
    columns = {name: as_shown(values, table.unit(name), units) for name, values in table.columns.items()}
    return Table(columns, {name: shown_unit(table.unit(name), units) for name in table.names}, dict(table.info))


def began(table: Table) -> float:
    """When the times of a log were zero, in s since 1970; 0 if that is not known, or the times themselves are dates."""
    found = table.info.get("began", 0.0)
    return float(found) if isinstance(found, int | float) else 0.0
