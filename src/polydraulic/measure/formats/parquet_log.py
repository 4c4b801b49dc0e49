"""Parquet logs: one group of rows; units from the metadata of the fields. Fields of records are signals ``record.field``."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.columns.cells import is_time, numbers
from polydraulic.columns.local_clock import LocalClock
from polydraulic.columns.survey import Notation, TextColumn, survey
from polydraulic.columns.timestamps import DateOrder, doubt, seconds, time_kind
from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.log import BLOCK, Log, LogBlock, Signal, once

_SHOWN = 60  # letters of a kind of values
_SAMPLE = 200  # cells that tell whether texts are times


def open_parquet(path: Path, dates: str | None = None) -> Log:
    """Open a Parquet log; see `polydraulic.measure.formats.logs.open_log`."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        with pq.ParquetFile(path) as file:
            given, n_row = file.schema_arrow, file.metadata.num_rows
    except (pa.ArrowException, OSError, UnicodeError) as error:
        raise InputError(f"{path}: cannot be read as a Parquet log ({_said(error)})") from error
    if n_row == 0:
        raise InputError(f"{path}: the log has no rows")
    schema = _flat_schema(given)
    fields: dict[str, Any] = {}
    for f in schema:
        fields.setdefault(f.name, f)  # of columns of one name the first is read
    left_out = {f.name: _nested(f.type) for f in schema if pa.types.is_nested(f.type)}
    left_out |= {f"column {n}": "it has no name: give it one" for n, name in enumerate(given.names, 1) if not name}
    kinds = {f.name: _kind(path, f) for f in fields.values() if not pa.types.is_nested(f.type)}
    orders = {name: _order(path, name, kind, dates) for name, kind in kinds.items() if _is_text(fields[name].type)}
    doubts = {name: "" if order.settled else order.example for name, order in orders.items()}
    besides = _besides(list(schema))
    signals, twice = once(
        [
            Signal(f.name, _unit(f), 0, kinds[f.name], besides.get(f.name, ""), doubts.get(f.name, ""))
            for f in schema
            if f.name in kinds
        ]
    )
    if not signals:
        raise InputError(f"{path}: the log has no columns of single values; it has {given.names}")

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        begun = 0
        beside = besides.get(time or "")
        names = list(dict.fromkeys([name for name in (time, beside, *wanted) if name]))
        texts = {
            name: _Texts(path, name, kinds[name], orders[name], findings)
            for name in names
            if _is_text(fields[name].type)
        }
        if time in texts:
            texts[time].refuse_doubt(path)
        local = None
        if time and kinds[time] and not getattr(fields[time].type, "tz", None) and not _elapsed(fields[time]):
            local = LocalClock(time, kinds[time] == "clock" and not beside, findings)
        for batch in _batches(path, names):
            of = {}
            for name in names:
                column = batch.column(batch.schema.names.index(name))
                of[name] = texts[name].numbers(column) if name in texts else numbers(column)
            rows = np.arange(begun, begun + batch.num_rows) + 1
            begun += batch.num_rows
            at = of[time][0] + (of[beside][0] if beside else 0.0) if time else None
            yield LogBlock(
                rows,
                at if at is None or local is None else local.times(at, rows),
                {name: of[name][0] for name in wanted},
                {name: of[name][1] for name in wanted},
                begun / n_row,
            )

    return Log(path, signals, False, read, twice, left_out=left_out)


def _flat_schema(schema: Any) -> Any:
    """The schema with a field for each of those of records, whose names are those of both, parted by a point; without columns that have no name."""
    import pyarrow as pa

    fields: list[Any] = []
    waiting = list(schema)
    while waiting:
        field = waiting.pop(0)
        if pa.types.is_struct(field.type):
            waiting = [part.with_name(f"{field.name}.{part.name}") for part in field.type] + waiting
        elif field.name:
            fields.append(field)
    return pa.schema(fields)


def _flat(batch: Any) -> Any:
    """A batch with the fields of its records as columns."""
    import pyarrow as pa

    if not any(pa.types.is_struct(kind) for kind in batch.schema.types):
        return batch
    table = pa.Table.from_batches([batch])
    while any(pa.types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return table.combine_chunks().to_batches()[0]


def _besides(fields: Sequence[Any]) -> dict[str, str]:
    """Of dates without a time of day and times of day in columns side by side, the name of the one to that of the other."""
    import pyarrow as pa

    found: dict[str, str] = {}
    for one, other in pairwise(fields):
        for date, clock in ((one, other), (other, one)):
            if pa.types.is_date(date.type) and pa.types.is_time(clock.type):
                found.setdefault(date.name, clock.name)
                found.setdefault(clock.name, date.name)
    return found


def _nested(kind: Any) -> str:
    """Why a column of lists is none, and what to do."""
    said = str(kind)
    return f"values of kind {said if len(said) <= _SHOWN else said[:_SHOWN] + '...'}, not single numbers: write one number a row"


def _batches(path: Path, names: Sequence[str]) -> Iterator[Any]:
    import pyarrow as pa
    import pyarrow.parquet as pq

    begun = 0
    # buffered ahead, the file is in memory
    with pq.ParquetFile(path, pre_buffer=False, buffer_size=1 << 20) as file:
        try:
            for batch in file.iter_batches(BLOCK, columns=list(names)):
                begun += batch.num_rows
                yield _flat(batch)
        except (pa.ArrowException, OSError) as error:
            raise InputError(f"{path}: damaged after row {begun} ({_said(error)})") from error


class _Texts:
    """A column of texts: times, or numbers."""

    def __init__(self, path: Path, name: str, kind: str, order: DateOrder, findings: Findings) -> None:
        self.name, self.kind, self.order = name, kind, order

        def whole() -> Notation:
            found = survey(({name: _plain(batch.column(0))} for batch in _batches(path, [name])), [name], ".")[name]
            if found.kind:
                findings.add(found.kind, name, found.detail)
            return found

        self.column = TextColumn(Notation() if kind else whole(), whole)

    def refuse_doubt(self, path: Path) -> None:
        """Raise an error if the dates can be read in two ways."""
        if not self.order.settled:
            raise doubt(path, self.name, self.order.example)

    def numbers(self, column: Any) -> tuple[np.ndarray, np.ndarray]:
        cells = _plain(column)
        if not self.kind:
            return self.column.numbers(cells)
        found = seconds(cells, self.kind, self.order.order)
        return found, np.flatnonzero(~np.isfinite(found) & cells.is_valid().to_numpy(zero_copy_only=False))


def _order(path: Path, name: str, kind: str, dates: str | None) -> DateOrder:
    """What the dates of a column of texts tell about their order; `dates` if that is said."""
    found = DateOrder()
    found.order = dates
    if kind == "stamp" and dates is None:
        for batch in _batches(path, [name]):
            found.look(_plain(batch.column(0)))
            if found.settled:
                break
    return found


def _plain(column: Any) -> Any:
    import pyarrow as pa

    if pa.types.is_dictionary(column.type):
        column = column.dictionary_decode()
    return column.cast(pa.string())


def _is_text(kind: Any) -> bool:
    import pyarrow as pa

    kind = kind.value_type if pa.types.is_dictionary(kind) else kind
    return bool(pa.types.is_string(kind) or pa.types.is_large_string(kind))


def _elapsed(field: Any) -> bool:
    import pyarrow as pa

    return bool(pa.types.is_duration(field.type))


def _kind(path: Path, field: Any) -> str:
    """As `Signal.kind`: whether a column holds times, by its type or by its first texts."""
    import pyarrow as pa

    if is_time(field.type):
        of_day = pa.types.is_time(field.type)
        return "clock" if of_day else "elapsed" if pa.types.is_duration(field.type) else "stamp"
    if not _is_text(field.type):
        return ""
    batch = next(_batches(path, [field.name]), None)
    return "" if batch is None else time_kind(c for c in _plain(batch.column(0))[:_SAMPLE].to_pylist() if c is not None)


def _said(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


def _unit(field: Any) -> str:
    return (field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
