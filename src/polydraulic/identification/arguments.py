"""What the functions of this package are given: tables and models, or where they are; what each of them checks.

Several tables are taken as one. Where one ends and the next begins is kept: no segment, and no block that is held out, goes over it.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.formats.campaign import expand
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.model_file import load_models
from polydraulic.tables import MISSING, Table, began, finite, read_table

TIMES = ("time", "segment")  # what tells a log from any table
_FILES = "files"  # in the info of a table: names and numbers of rows of those that it was made of
_SHIFTS = "shifts"  # in the info of such a table: s by which the times of each are later than its own
_UNUSED = "unused"  # in the info of a table of whole rows: how many others there were, and how often each column lacked a value
_APART = 60.0  # s between tables whose times begin anew: nobody knows how long it was
_DATES = 315_532_800.0  # s since 1970: from 1980 on times are dates
_NAMED = 3  # tables in the name of several


def table_of(
    given: Table | str | Path | Sequence[Table | str | Path],
    columns: Sequence[str] | None = None,
    optional: Sequence[str] = (),
    *,
    partial: bool = False,
) -> tuple[Table, str]:
    """A table or that of a file, and what it is called; only `columns` if given, and those of `optional` that it has.

    Of tables that declare missing values, rows with a value of all these columns, and `unused_in_words` says how many others there were;
    with `partial`, all rows, as by `read_table`.

    Several tables, or files that match a pattern such as ``day*.parquet``, become one: those with dates in the order of these, all
    others as they are given. Times rise through all of them, a minute apart where they restart, and ``segment`` is counted on.

    Raises
    ------
    InputError
        As `read_table`; also of a table in memory without rows, or with a value that is not a finite number. Of several tables: one that
        lacks a column of the others or has it in another unit, that is there twice, or whose dates overlap those of another one.
    """
    several: Any = given
    one = (
        isinstance(given, Table | str | Path | Mapping) or hasattr(given, "columns") or not isinstance(given, Iterable)
    )
    parts = [several] if one else list(several)
    strange = [part for part in parts if not isinstance(part, Table | str | Path)]
    if strange:
        raise InputError(
            f"a table is given as a Table, a path, or a list of them, not as {type(strange[0]).__name__}; of a data frame Table.from_pandas makes "
            "one, of a mapping Table.from_dict"
        )
    found = [place for part in parts for place in ([part] if isinstance(part, Table) else expand(part))]
    if not found:
        raise InputError("no table is given")
    if len(found) == 1:
        return _one(found[0], columns, optional, partial)
    named = [_one(part, columns, optional, partial) for part in found]
    if len({name for _, name in named}) < len(named):  # of several folders, or in memory
        named = [(table, f"{name} ({number})") for number, (table, name) in enumerate(named, 1)]
    return _joined(named)


def parts_of(table: Table) -> list[int]:
    """Numbers of rows of the tables that a table was made of; one number for any other."""
    files: Any = table.info.get(_FILES, [])
    rows = [int(n) for _, n in files] if isinstance(files, list) else []
    return rows if sum(rows) == len(table) and rows else [len(table)]


def names_of_parts(table: Table) -> list[str]:
    """What the tables are called that a table was made of; empty for any other."""
    files: Any = table.info.get(_FILES, [])
    return [str(name) for name, _ in files] if len(parts_of(table)) > 1 else []


def unused_in_words(table: Table) -> str:
    """Sentence on rows that `table_of` left out, since a column that is read has no value in them; empty if there are none."""
    unused: Any = table.info.get(_UNUSED)
    if not unused:
        return ""
    count, lacks = unused
    each = ", ".join(f"{name} in {n}" for name, n in lacks.items() if n)
    return f"{count} of {count + len(table)} rows are not used, since columns that are read have no value there: {each}"


def whole_rows(table: Table, names: Sequence[str]) -> Table:
    """Rows that have a value of all these columns, as by `Table.whole`, which know of which tables they are."""
    found, called = table.whole(names), names_of_parts(table)
    if len(found) == len(table) or not called:
        return found
    ends = np.cumsum(parts_of(table))
    left = [int(np.count_nonzero(own)) for own in np.split(table.known(names), ends[:-1])]
    shifts: Any = table.info.get(_SHIFTS, [])
    info = {**table.info, _FILES: [[name, n] for name, n in zip(called, left, strict=True) if n]}
    if len(shifts) == len(left):
        info[_SHIFTS] = [shift for shift, n in zip(shifts, left, strict=True) if n]
    return Table(found.columns, found.units, info)


class PartTimes(NamedTuple):
    """One of several logs that were joined.

    Attributes
    ----------
    name : str
    begins : float, s
        First of its times, as they were joined.
    shift : float, s
        By which these are later than its own.
    """

    name: str
    begins: float
    shift: float


def times_of_parts(table: Table) -> tuple[PartTimes, ...]:
    """The logs that a table was made of, by their times; empty for any other."""
    names, shifts = names_of_parts(table), cast("list[float]", table.info.get(_SHIFTS, []))
    if not names or len(shifts) != len(names) or "time" not in table.names:
        return ()
    firsts = np.cumsum([0, *parts_of(table)])[:-1]
    begins = table["time"][firsts].tolist()
    return tuple(PartTimes(*part) for part in zip(names, begins, map(float, shifts), strict=True))


def _one(
    given: Table | str | Path, columns: Sequence[str] | None, optional: Sequence[str], partial: bool
) -> tuple[Table, str]:
    if not isinstance(given, Table):
        found = read_table(given, columns, optional=optional, partial=True)
        try:
            return found if partial else _whole(found), Path(given).name
        except InputError as error:
            raise InputError(f"{given}: {error}") from error
    names = [name for name in given.names if name != MISSING]
    wanted = names if columns is None else [*columns, *(n for n in optional if n in names and n not in columns)]
    if not len(given):
        raise InputError("the table has no rows")
    absent = [name for name in wanted if name not in names]
    if absent:
        raise InputError(f"no column {absent[0]!r}; the table has {names}")
    some = Table({n: given.columns[n] for n in wanted}, {n: given.unit(n) for n in wanted}, given.info)
    if MISSING in given:
        return some.partial() if partial else _whole(some.partial()), "table"
    for name in wanted:
        finite(some[name], name)
    return _whole(some), "table"


def _whole(table: Table) -> Table:
    """Rows that have a value of all columns, which know how many others there were."""
    info = {key: value for key, value in table.info.items() if key != _UNUSED}
    if MISSING not in table:
        return Table(table.columns, table.units, info)
    names = [name for name in table.names if name != MISSING]
    found = table.whole(names)
    if len(found) < len(table):
        lacks = {name: int(np.count_nonzero(~table.known([name]))) for name in names}
        info[_UNUSED] = [len(table) - len(found), lacks]
    return Table(found.columns, found.units, info)


def _joined(named: list[tuple[Table, str]]) -> tuple[Table, str]:
    first, name_of_first = named[0]
    for table, name in named[1:]:
        for one, other, has in ((first, table, name), (table, first, name_of_first)):
            missing = [column for column in one.names if column not in (*other.names, "segment", MISSING)]
            if missing:
                where = name_of_first if one is first else name
                raise InputError(
                    f"{has}: no column {missing[0]!r}, which {where} has; give tables with the same columns"
                )
        for column in first.names:
            units = first.unit(column), table.unit(column)
            if column in table.names and units[0] != units[1]:
                raise InputError(
                    f"{name}: column {column!r} is in {units[1]!r}, in {name_of_first} in {units[0]!r}; bring them to one unit"
                )
    for k, (table, name) in enumerate(named):
        twin = next((other for one, other in named[:k] if len(one) == len(table) and one == table), None)
        if twin is not None:
            raise InputError(f"{name} has the same rows as {twin}; give each table once")
    named, times = _in_order(named)
    names = [c for c in first.names if c not in (*TIMES, MISSING)]
    columns = {c: np.concatenate([table.columns[c] for table, _ in named]) for c in names}
    if times:
        columns["time"] = np.concatenate(times)
    columns["segment"] = np.concatenate(_segments([table for table, _ in named]))
    unit_of = first.units | {"segment": "1"}
    called = [name for _, name in named]
    info = {**named[0][0].info, _FILES: [[name, len(table)] for table, name in named]}
    unused: list[Any] = [table.info[_UNUSED] for table, _ in named if _UNUSED in table.info]
    if unused:
        lacks = {column: sum(each.get(column, 0) for _, each in unused) for column in first.names}
        info[_UNUSED] = [sum(count for count, _ in unused), lacks]
    if times:
        info[_SHIFTS] = [float(time[0] - table["time"][0]) for time, (table, _) in zip(times, named, strict=True)]
    if not all(began(table) for table, _ in named):  # times are not counted from one date
        info.pop("began", None)
    more = f" and {len(called) - _NAMED} more" if len(called) > _NAMED else ""
    joined = Table(columns, {c: unit_of.get(c, "") for c in columns}, info)
    declared = joined.partial() if any(MISSING in table for table, _ in named) else joined
    return declared, ", ".join(called[:_NAMED]) + more


def _in_order(named: list[tuple[Table, str]]) -> tuple[list[tuple[Table, str]], list[np.ndarray]]:
    """Tables in the order of their dates, and times that rise through all of them; no times where the tables have none."""
    if "time" not in named[0][0].names:
        return named, []
    dated = [(began(table) + float(table["time"].min()), *pair) for pair in named for table in pair[:1]]
    if min(date for date, _, _ in dated) > _DATES:
        dated.sort(key=lambda one: one[0])
        for (_, table, name), (date, _, following) in pairwise(dated):
            over = began(table) + float(table["time"].max()) - date
            if over >= 0.0:
                raise InputError(
                    f"{following} begins {over:.4g} s before {name} ends: the same time would count twice; cut one"
                )
        zero = began(dated[0][1])
        return [(t, n) for _, t, n in dated], [table["time"] + (began(table) - zero) for _, table, _ in dated]
    times: list[np.ndarray] = []
    for table, _ in named:
        time, end = table["time"], float(times[-1].max()) if times else -np.inf
        times.append(time if time.min() > end else time + (end + _APART - float(time.min())))
    return named, times


def _segments(tables: Sequence[Table]) -> list[np.ndarray]:
    """Numbers of segments that are counted on from table to table."""
    found: list[np.ndarray] = []
    following = 0.0
    for table in tables:
        own = table["segment"] - table["segment"].min() if "segment" in table.names else np.zeros(len(table))
        found.append(own + following)
        following = float(found[-1].max()) + 1.0
    return found


def models_of(given: Sequence[Model] | str | Path) -> list[Model]:
    """Models, or those of a model file."""
    return load_models(given) if isinstance(given, str | Path) else list(given)


def check_columns(table: Table, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse columns that are none, twice, both input and output, or constant; the time of several tables, too."""
    for names, what in ((inputs, "input"), (outputs, "output")):
        if not len(names):  # an array has no truth of its own
            raise InputError(f"no {what} is given; the table has {table.names}")
        twice = sorted(name for name in set(names) if list(names).count(name) > 1)
        if twice:
            raise InputError(f"column {twice[0]!r} is given twice as {what}")
    if "time" in inputs and len(parts_of(table)) > 1:
        raise InputError(
            "column 'time' is an input: of several tables it says when, not what; give one table, or leave it out"
        )
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(f"column {sorted(both)[0]!r} is both input and output")
    for name in [*inputs, *outputs]:
        if len(table) > 1 and np.ptp(table[name]) == 0.0:
            role = "cannot explain anything: leave it out" if name in inputs else "needs no model"
            raise InputError(f"column {name!r} is {table[name][0]:g} in all {len(table)} rows; it {role}")
