"""Tables: named columns of numbers with units, read from and written to CSV and Parquet.

A simulated run, a training database and a measured log are all such tables. In a CSV file the header carries the
unit in brackets, ``boom.p_in [Pa]``; in a Parquet file it is in the metadata of the field.

A table whose columns lack values in some rows says so by a column ``missing``: how many of the others have none in each row. Such a
value is empty in CSV, null in Parquet and NaN in memory, and is given only to who asks for it (`partial`); others get whole rows.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import DEFAULT, as_shown, columns_html, columns_text, head, shown_unit
from polydraulic.errors import InputError
from polydraulic.files import replacing
from polydraulic.names import checked_name, checked_text
from polydraulic.table_files import (
    OF_LOGS,
    arrow_floats,
    arrow_info,
    arrow_numbers,
    arrow_schema,
    arrow_unit,
    name_and_unit,
    quoted,
    read_file,
    refuse_twice,
    write_rows,
)

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from numpy.typing import ArrayLike

MISSING = "missing"  # the column that declares missing values


@dataclass(frozen=True, eq=False, repr=False)
class Table:
    """Named columns of equal length, each with a unit.

    ``len(table)`` is the number of rows; iteration and ``in`` go over the names. Two tables are equal if they have the same names in
    the same order, the same units and the same values, where NaN equals NaN; `info` does not count.

    ``table[name]`` of a table that declares missing values is refused where the column lacks some; `whole` gives rows that have all.

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
                data[str(name)] = arrow_numbers(pa.array(values), str(name))
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
        refuse_twice(table.column_names, "")
        columns = {name: arrow_numbers(table.column(name), name) for name in table.column_names}
        try:
            return cls(columns, {entry.name: arrow_unit(entry) for entry in table.schema}, arrow_info(table.schema))
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
        refuse_twice(names, "")
        if units is None:
            units = {name: unit for name, unit in frame.attrs.get("units", {}).items() if name in names}
        columns = {name: frame.iloc[:, place] for place, name in enumerate(names)}
        return cls.from_dict(columns, units, frame.attrs.get("info"))

    def to_arrow(self) -> "pa.Table":
        """Return an Arrow table; units are in the metadata of its fields, `info` in those of its schema, as in Parquet files."""
        schema = arrow_schema({n: self.unit(n) for n in self}, self.info)
        return arrow_floats(self.columns.values(), schema, nulls=MISSING in self)

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

    def known(self, names: Sequence[str]) -> np.ndarray:
        """Return in which rows all of the named columns have a value, (n_row,) array of bool."""
        columns, found = [self._column(name) for name in names], np.ones(len(self), dtype=bool)
        for column in columns if MISSING in self else ():
            found &= ~np.isnan(column)
        return found

    def whole(self, names: Sequence[str]) -> "Table":
        """Return the named columns in the rows in which all of them have a value; a table that declares no missing values keeps all rows.

        Where rows are left out, ``segment`` is counted anew: rows of one segment still follow each other without a gap.

        Raises
        ------
        InputError
            No such column, or no row with a value of all of them.
        """
        keep, units = self.known(names), {name: self.unit(name) for name in names}
        if keep.all():
            return Table({name: self._column(name) for name in names}, units, self.info)
        if not keep.any():
            count, least = min((np.count_nonzero(self.known([name])), name) for name in names)
            raise InputError(
                f"no row has a value of all of {', '.join(names)}; {least!r} has one in {count} of {len(self)}"
            )
        columns = {name: self._column(name)[keep] for name in names}
        if "segment" in columns:
            columns["segment"] = segments_of(self["segment"], keep)
        return Table(columns, units, self.info)

    def partial(self) -> "Table":
        """Return the table with its missing values, which are NaN, declared: the column ``missing`` counts those of each row.

        Raises
        ------
        InputError
            If ``time`` or ``segment`` lacks a value, or a value is infinite.
        """
        columns = {name: values for name, values in self.columns.items() if name != MISSING}
        count = np.zeros(len(self))
        for name, values in columns.items():
            if np.isinf(values).any() or (name in ("time", "segment") and np.isnan(values).any()):
                finite(values, name)
            count += np.isnan(values)
        return Table(columns | {MISSING: count}, self.units | {MISSING: "1"}, self.info)

    def __getitem__(self, name: str) -> np.ndarray:
        values = self._column(name)
        if MISSING in self.columns and (lacks := int(np.count_nonzero(np.isnan(values)))):
            raise InputError(
                f"column {name!r} has no value in {lacks} of {len(self)} rows; take whole rows by table.whole([...]), or NaN by table.columns[{name!r}]"
            )
        return values

    def _column(self, name: str) -> np.ndarray:
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
            and all(np.array_equal(self.columns[name], other.columns[name], equal_nan=True) for name in self)
        )

    __hash__ = None  # type: ignore[assignment]  # columns are arrays, which can change

    def __repr__(self) -> str:
        return columns_text(self.columns, self.units)

    def _repr_html_(self) -> str:
        return columns_html(self.columns, self.units)


def write_table(table: Table, path: str | Path) -> None:
    """Write a table as ``.csv`` or ``.parquet``.

    Raises
    ------
    InputError
        If the ending is neither, the place cannot be written, or ``table.info`` holds what no file keeps.
    """
    with table_writer(path, {name: table.unit(name) for name in table.names}, table.info) as write:
        write(list(table.columns.values()))


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
        With one that is called ``missing``, NaN is written as no value.
    info : mapping, optional
    """
    ending = table_ending(path)
    if not units:
        raise InputError(f"{path}: the table has no columns to write")
    for name, unit in units.items():
        checked_text(unit, f"unit of column {checked_name(name, 'column')!r},")
        if ending == ".csv" and name_and_unit(head(name, unit)) != (name, unit):
            raise InputError(f"column {name!r} [{unit}] would be misread from CSV: rename it, or write .parquet")
    with replacing(path) as temporary:
        if ending == ".csv":
            with temporary.open("w", encoding="utf-8") as file:
                file.write(",".join(quoted(head(name, unit)) for name, unit in units.items()) + "\n")
                yield lambda columns: write_rows(file, columns, empty=MISSING in units)
        else:
            import pyarrow.parquet as pq

            schema = arrow_schema(units, info or {})
            with pq.ParquetWriter(temporary, schema, use_dictionary=False) as file:  # hardly a number comes twice
                yield lambda columns: file.write_table(arrow_floats(columns, schema, nulls=MISSING in units))


def read_table(
    path: str | Path, columns: Sequence[str] | None = None, *, optional: Sequence[str] = (), partial: bool = False
) -> Table:
    """Read a CSV or Parquet table; only `columns` if given, and those of `optional` that it has.

    Of a table that declares missing values (column ``missing``), only rows come that have a value of all columns that are read, as by
    `Table.whole`; with `partial`, all rows come, NaN where a value is missing, and declared as by `Table.partial`.

    Raises
    ------
    InputError
        If the file is missing, is not a table, lacks a column, or holds something that is not a finite number
        (named with its column and row); if values are missing that are not declared, or no row has a value of all columns.
    """
    path = Path(path)
    ending = table_ending(path, f"; {OF_LOGS}")
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    raw, split, info = read_file(path, ending)
    if raw.num_rows == 0:
        raise InputError(f"{path}: the table has no rows")
    refuse_twice([name for name, _ in split], f"{path}: ")
    units = dict(split)
    names = list(units)
    also = [name for name in optional if name in units and name not in (columns or ())]
    wanted = [name for name in names if name != MISSING] if columns is None else [*columns, *also]
    missing = [name for name in wanted if name not in units]
    if missing:
        hint = f"; {OF_LOGS}" if any(mark in name for name in names for mark in ";\t") else ""
        raise InputError(f"{path}: no column {missing[0]!r}; the table has {names}{hint}")
    declares = MISSING in units and MISSING not in wanted
    found = {n: arrow_numbers(raw.column(names.index(n)), n, f"{path}: ") for n in (names if declares else wanted)}
    some = Table({name: found[name] for name in wanted}, {name: units[name] for name in wanted}, info)
    if not declares:
        return Table({n: finite(v, n, f"{path}: ") for n, v in found.items()}, some.units, info)
    try:
        if not np.array_equal(Table(found, {}).partial()[MISSING], found[MISSING]):
            raise InputError(
                f"column {MISSING!r} must count the values that the other columns lack in each row, and does not: a row or a cell was changed; "
                "rename it if it is about something else"
            )
        return some.partial() if partial else some.partial().whole(wanted)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def table_ending(path: str | Path, hint: str = "") -> str:
    """Ending of a table's path, or an InputError that ends in a hint."""
    ending = Path(path).suffix.lower()
    if ending not in (".csv", ".parquet"):
        raise InputError(f"{path}: a table ends in .csv or .parquet, not in {ending!r}{hint}")
    return ending


def finite(values: np.ndarray, name: str, where: str = "") -> np.ndarray:
    """The values of a column, or an InputError that names the first one that is not finite."""
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise InputError(
            f"{where}column {name!r} holds {values[bad[0]]} in row {bad[0] + 1} ({bad.size} of {values.size} rows); "
            f"every value must be a finite number: drop these rows or fill them first{f'; {OF_LOGS}' if where else ''}"
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


def segments_of(segment: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Segments of the rows that are kept, (n_kept,) of those (n_row,), counted from 0 and cut where others lie between."""
    rows = np.flatnonzero(keep)
    cut = (np.diff(rows) > 1) | (np.diff(segment[rows]) != 0.0)
    return np.concatenate([[0], np.cumsum(cut)])[: len(rows)].astype(segment.dtype)


def began(table: Table) -> float:
    """When the times of a log were zero, in s since 1970; 0 if that is not known, or the times themselves are dates."""
    found = table.info.get("began", 0.0)
    return float(found) if isinstance(found, int | float) else 0.0
