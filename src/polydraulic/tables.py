"""Tables: named columns of numbers with units, read from and written to CSV and Parquet.

A simulated run, a training database and a measured log are all such tables. In a CSV file the header carries the
unit in brackets, ``boom.p_in [Pa]``; in a Parquet file it is in the metadata of the field.
"""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from polydraulic.arrow_columns import arrow_floats
from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError, briefly
from polydraulic.files import replacing
from polydraulic.names import checked_name, checked_text
from polydraulic.pages import html

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from numpy.typing import ArrayLike

_HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*$", re.DOTALL)
_INFO_KEY = b"polydraulic"
_OF_LOGS = "a log as it was recorded goes through `polydraulic import` first"
_SHOWN_ROWS, _SHOWN_COLUMNS = 5, 30  # at both ends; of a table that is displayed


@dataclass(frozen=True, eq=False, repr=False)
class Table:
    """Named columns of equal length, each with a unit.

    ``len(table)`` is the number of rows; iteration and ``in`` go over the names. Two tables are equal if they have the same names in
    the same order, the same units and the same values, where NaN equals NaN; `info` does not count.

    Attributes
    ----------
    columns : dict from name to (n_row,) array of float
    units : dict from name to unit; empty string where none was given
    info : what made the table (plain numbers and strings); kept in Parquet metadata

    Examples
    --------
    >>> table = Table.from_dict({"time": [0.0, 0.1], "p": [2e5, 3e5]}, {"time": "s", "p": "Pa"})
    >>> table
    Table of 2 rows and 2 columns
      time [s]  0 ... 0.1
      p [Pa]    200000 ... 300000
    """

    columns: dict[str, np.ndarray]
    units: dict[str, str]
    info: dict[str, object] = field(default_factory=dict)

    @classmethod
    def from_dict(
        cls,
        columns: Mapping[str, "ArrayLike"],
        units: Mapping[str, str] | None = None,
        info: Mapping[str, object] | None = None,
    ) -> "Table":
        """Make a table from anything that holds numbers; a missing value (None) becomes NaN.

        Parameters
        ----------
        columns : mapping from name to (n_row,) array-like of numbers
        units : mapping from name to unit, optional
        info : mapping, optional

        Raises
        ------
        InputError
            Columns that hold anything else or are not equally long; a unit of a column that the table does not have.
        """
        import pyarrow as pa

        data = {}
        for name, values in columns.items():
            try:
                data[str(name)] = _numbers(pa.array(values), str(name), "")
            except (pa.ArrowException, TypeError, OverflowError) as error:
                said = str(error).splitlines()[0]
                raise InputError(f"column {str(name)!r} is not a sequence of numbers ({said})") from error
        lengths = {name: len(values) for name, values in data.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"the columns have {lengths} rows; they must be equally long")
        strange = [name for name in units or {} if name not in data]
        if strange:
            raise InputError(f"a unit is given for the column {strange[0]!r}; the table has {list(data)}")
        given = {name: checked_text((units or {}).get(name, ""), f"unit of column {name!r},") for name in data}
        return cls(data, given, dict(info or {}))

    @classmethod
    def from_arrow(cls, table: "pa.Table") -> "Table":
        """Make a table from an Arrow table; a missing value becomes NaN.

        Parameters
        ----------
        table : pyarrow.Table
            Units are read from the metadata of its fields, `info` from that of its schema, where `to_arrow` puts them.

        Raises
        ------
        InputError
            A column that holds anything else than numbers, or a name that appears twice.
        """
        _refuse_twice(table.column_names, "")
        columns = {name: _numbers(table.column(name), name, "") for name in table.column_names}
        try:
            return cls(columns, {entry.name: _unit_of(entry) for entry in table.schema}, _info_of(table.schema))
        except (ValueError, RecursionError) as error:
            raise InputError(f"units or info in the metadata of the table are damaged ({error})") from error

    @classmethod
    def from_pandas(cls, frame: "pd.DataFrame", units: Mapping[str, str] | None = None) -> "Table":
        """Make a table from the columns of a data frame; its index is left out (`reset_index` makes a column of it).

        Parameters
        ----------
        frame : pandas.DataFrame
        units : mapping from name to unit, optional
            If not given, those in ``frame.attrs["units"]``, where `to_pandas` puts them.

        Raises
        ------
        InputError
            As for `from_dict` and `from_arrow`.
        """
        names = [str(name) for name in frame.columns]
        _refuse_twice(names, "")
        if units is None:
            units = {name: unit for name, unit in frame.attrs.get("units", {}).items() if name in names}
        columns = {name: frame.iloc[:, place] for place, name in enumerate(names)}
        return cls.from_dict(columns, units, frame.attrs.get("info"))

    def to_arrow(self) -> "pa.Table":
        """Return an Arrow table; units are in the metadata of its fields, `info` in those of its schema, as in Parquet files."""
        return arrow_floats(self.columns.values(), _schema({n: self.unit(n) for n in self}, self.info))

    def to_pandas(self) -> "pd.DataFrame":
        """Return a data frame; units are in ``frame.attrs["units"]``, `info` in ``frame.attrs["info"]``."""
        try:
            import pandas as pd
        except ImportError as error:
            raise InputError("pandas is not installed; install it with: pip install 'polydraulic[pandas]'") from error
        frame = pd.DataFrame(self.columns, copy=True)
        frame.attrs.update(units={name: self.unit(name) for name in self}, info=dict(self.info))
        return frame

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

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.columns:
            raise InputError(f"no column {name!r}; the table has {list(self.columns)}")
        return self.columns[name]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values()), ()))

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Table):
            return NotImplemented
        return (
            self.names == other.names
            and all(self.unit(name) == other.unit(name) for name in self)
            and all(np.array_equal(self[name], other[name], equal_nan=True) for name in self)
        )

    __hash__ = None  # type: ignore[assignment]  # columns are arrays, which can change

    def __repr__(self) -> str:
        heads = [_head(name, self.unit(name)) for name in self.names[:_SHOWN_COLUMNS]]
        width = max(map(len, heads), default=0)
        lines = [f"Table of {len(self)} rows and {len(self.columns)} columns"]
        for head, values in zip(heads, self.columns.values(), strict=False):
            ends = f"{values[0]:.6g} ... {values[-1]:.6g}" if len(values) > 1 else ", ".join(f"{v:.6g}" for v in values)
            lines.append(f"  {head.ljust(width)}  {ends}".rstrip())
        rest = len(self.columns) - len(heads)
        return "\n".join([*lines, *([f"  and {rest} more"] if rest else [])])

    def _repr_html_(self) -> str:
        """Show the rows at both ends under names and units: what a notebook displays."""
        names, n = self.names[:_SHOWN_COLUMNS], len(self)
        at = range(n) if n <= 2 * _SHOWN_ROWS else [*range(_SHOWN_ROWS), *range(n - _SHOWN_ROWS, n)]
        rows = [[str(row), *(f"{self[name][row]:.6g}" for name in names)] for row in at]
        if n > len(rows):
            rows.insert(_SHOWN_ROWS, ["..."] * (1 + len(names)))
        more = ", the first shown" if len(names) < len(self.columns) else ""
        return html.table(
            f"{n} rows, {len(self.columns)} columns{more}",
            ["row", *(_head(name, self.unit(name)) for name in names)],
            rows,
        )


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
    units : mapping from name to unit, of the columns
    info : mapping, optional
    """
    ending = table_ending(path)
    if not units:
        raise InputError(f"{path}: the table has no columns to write")
    for name, unit in units.items():
        checked_text(unit, f"unit of column {checked_name(name, 'column')!r},")
        if ending == ".csv" and _name_and_unit(_head(name, unit)) != (name, unit):
            raise InputError(f"column {name!r} [{unit}] would be misread from CSV: rename it, or write .parquet")
    with replacing(path) as temporary:
        if ending == ".csv":
            with temporary.open("w", encoding="utf-8") as file:
                file.write(",".join(_quoted(_head(name, unit)) for name, unit in units.items()) + "\n")
                yield lambda columns: np.savetxt(file, np.column_stack(columns), fmt="%.17g", delimiter=",")
        else:
            import pyarrow.parquet as pq

            schema = _schema(units, info or {})
            with pq.ParquetWriter(temporary, schema, use_dictionary=False) as file:  # hardly a number comes twice
                yield lambda columns: file.write_table(arrow_floats(columns, schema))


def _quoted(head: str) -> str:
    """A head of a CSV column, in quotes where it holds what parts columns and lines."""
    return '"' + head.replace('"', '""') + '"' if set(head) & set(',"\n\r') else head


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
        heads = [entry.name for entry in raw.schema]
        given, info = [_unit_of(entry) for entry in raw.schema], _info_of(raw.schema)
    except (pa.ArrowException, OSError, ValueError, RecursionError) as error:  # the latter from damaged units and info
        why = (str(error).splitlines() or ["damaged"])[0]
        hint = f"; {_OF_LOGS}" if ending == ".csv" else ""
        raise InputError(f"{path}: cannot be read as a {ending[1:]} table ({why}){hint}") from error
    if raw.num_rows == 0:
        raise InputError(f"{path}: the table has no rows")
    split = list(map(_name_and_unit, heads)) if ending == ".csv" else list(zip(heads, given, strict=True))
    _refuse_twice([name for name, _ in split], f"{path}: ")
    units = dict(split)
    names = list(units)
    also = [name for name in optional if name in units and name not in (columns or ())]
    wanted = names if columns is None else [*columns, *also]
    missing = [name for name in wanted if name not in units]
    if missing:
        hint = f"; {_OF_LOGS}" if any(mark in name for name in names for mark in ";\t") else ""
        raise InputError(f"{path}: no column {missing[0]!r}; the table has {names}{hint}")
    data = {
        name: finite(_numbers(raw.column(names.index(name)), name, f"{path}: "), name, f"{path}: ") for name in wanted
    }
    return Table(data, {name: units[name] for name in wanted}, info)


def table_ending(path: str | Path) -> str:
    """Ending of a table's path, or an InputError."""
    ending = Path(path).suffix.lower()
    if ending not in (".csv", ".parquet"):
        raise InputError(f"{path}: a table ends in .csv or .parquet, not in {ending!r}")
    return ending


def _numbers(column: Any, name: str, where: str) -> np.ndarray:
    """An Arrow array as floats; NaN where a value is missing."""
    import pyarrow as pa

    if len(column) and not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        shown = next((briefly(str(v)) for v in column.to_pylist() if v is not None), "no value")
        held = f"holds {shown} ({column.type})"
        raise InputError(f"{where}column {name!r} {held}; every value must be a number; {_OF_LOGS}")
    try:
        return np.array(column.cast(pa.float64()).to_numpy(zero_copy_only=False), dtype=np.float64)
    except pa.ArrowInvalid as error:
        raise InputError(f"{where}column {name!r} holds whole numbers beyond 2^53, which no float holds") from error


def finite(values: np.ndarray, name: str, where: str = "") -> np.ndarray:
    """The values of a column, or an InputError that names the first one that is not finite."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            f"{where}column {name!r} holds {values[bad[0]]} in row {bad[0] + 1} ({bad.size} of {values.size} rows); "
            f"every value must be a finite number: drop these rows or fill them first{f'; {_OF_LOGS}' if where else ''}"
        )
    return values


def _refuse_twice(names: Sequence[str], where: str) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(f"{where}column {twice[0]!r} appears twice; give each column its own name")


def _schema(units: Mapping[str, str], info: Mapping[str, object]) -> "pa.Schema":
    """Names and units as Arrow and Parquet keep them."""
    import pyarrow as pa

    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in units.items()]
    return pa.schema(fields, metadata={_INFO_KEY: json.dumps(dict(info))})


def _unit_of(entry: "pa.Field") -> str:
    return str((entry.metadata or {}).get(b"unit", b"").decode())


def _info_of(schema: "pa.Schema") -> dict[str, object]:
    stored = (schema.metadata or {}).get(_INFO_KEY)
    if not isinstance(found := json.loads(stored) if stored else {}, dict):
        raise ValueError(f"what it says of itself is no object: {str(found)[:40]}")
    return found


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit else name


def _name_and_unit(head: str) -> tuple[str, str]:
    found = _HEADER.match(head)
    return (found["name"], found["unit"] or "") if found else (head, "")


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
