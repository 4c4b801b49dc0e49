"""CSV logs: comma, semicolon or tab; decimal comma; units in the header or in a line below it; plain or gzip."""

import gzip
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.measure.findings import Findings
from polydraulic.measure.formats.arrow import numbers
from polydraulic.measure.formats.log import Log, LogBlock, Signal, once

_HEADER = re.compile(r"^\s*(?P<name>.*?)\s*(?:\[(?P<unit>[^\]]*)\])?\s*$")
_DATE = re.compile(r"^\d{4}-\d\d-\d\d")
_BLOCK = 4 << 20  # bytes


class _Dialect(NamedTuple):
    delimiter: str
    decimal: str
    encoding: str
    skip: int  # lines above the data
    width: int


def open_csv(path: Path) -> Log:
    """Open a CSV log; see `polydraulic.measure.formats.logs.open_log`."""
    head, encoding = _head(path)
    if not head:
        raise InputError(f"{path}: the file is empty")
    delimiter = max(",;\t", key=head[0].count)
    fields = _fields(head[0], delimiter)
    below = [_fields(line, delimiter) for line in head[1:]]
    decimal = (
        "," if delimiter != "," and any("," in cell and _number(cell, ",") for row in below for cell in row) else "."
    )
    names, units, skip = fields, [""] * len(fields), 1
    if all(_number(cell, decimal) for cell in fields):
        names, skip = [f"column {n}" for n in range(1, len(fields) + 1)], 0
    else:
        matches = [_HEADER.match(cell) for cell in fields]
        names = [match["name"] if match else cell for match, cell in zip(matches, fields, strict=True)]
        units = [(match["unit"] or "") if match else "" for match in matches]
        first = below[0] if below else []
        if len(first) == len(fields) and any(first) and not any(_number(c, decimal) or _DATE.match(c) for c in first):
            units, skip = [u or cell.strip("[]() ") for u, cell in zip(units, first, strict=True)], 2
    if skip and len(below) < skip:
        raise InputError(f"{path}: the log has no rows")
    signals, twice = once([Signal(name, unit, 0) for name, unit in zip(names, units, strict=True)])
    dialect = _Dialect(delimiter, decimal, encoding, skip, len(fields))
    places = {s.name: names.index(s.name) for s in signals}

    def read(group: int, wanted: Sequence[str], time: str | None, findings: Findings) -> Iterator[LogBlock]:
        return _read(path, dialect, places, wanted, time, findings)

    return Log(path, signals, False, read, twice)


def _read(
    path: Path, dialect: _Dialect, places: dict[str, int], wanted: Sequence[str], time: str | None, findings: Findings
) -> Iterator[LogBlock]:
    import pyarrow as pa
    from pyarrow import csv

    broken: list[int] = []

    def skip(row: Any) -> str:
        broken.append(row.number - dialect.skip)
        return "skip"

    columns = [str(n) for n in range(dialect.width)]
    needed = [str(places[name]) for name in dict.fromkeys([*([time] if time else []), *wanted])]
    size, begun, noted = max(1, path.stat().st_size), 0, 0
    with path.open("rb") as raw:
        stream = pa.CompressedInputStream(raw, "gzip") if path.suffix == ".gz" else pa.PythonFile(raw)
        try:
            reader = csv.open_csv(
                stream,
                # one thread, since only then are lines numbered
                csv.ReadOptions(
                    use_threads=False,
                    block_size=_BLOCK,
                    column_names=columns,
                    skip_rows=dialect.skip,
                    encoding=dialect.encoding,
                ),
                csv.ParseOptions(delimiter=dialect.delimiter, invalid_row_handler=skip),
                csv.ConvertOptions(include_columns=needed, column_types=dict.fromkeys(needed, pa.string())),
            )
            for batch in reader:
                rows = np.arange(begun, begun + batch.num_rows) + 1
                begun += batch.num_rows
                rows += np.searchsorted(np.asarray(broken) - np.arange(len(broken)), rows, side="right")
                findings.add_rows("missing line", "", np.asarray(broken[noted:]))
                noted = len(broken)
                yield _block(batch, dialect, places, wanted, time, rows, min(1.0, raw.tell() / size))
        except (pa.ArrowInvalid, pa.ArrowException, OSError, EOFError) as error:
            raise InputError(f"{path}: cannot be read as a CSV log ({str(error).splitlines()[0]})") from error
    findings.add_rows("missing line", "", np.asarray(broken[noted:]))


def _block(
    batch: Any, dialect: _Dialect, places: dict[str, int], wanted: Sequence[str], time: str | None,
    rows: np.ndarray, done: float,
) -> LogBlock:  # fmt: skip
    import pyarrow.compute as pc

    def column(name: str) -> tuple[np.ndarray, np.ndarray]:
        cells = batch.column(str(places[name]))
        return numbers(pc.replace_substring(cells, ",", ".") if dialect.decimal == "," else cells)

    values, text = {}, {}
    for name in wanted:
        values[name], text[name] = column(name)
    return LogBlock(rows, column(time)[0] if time else None, values, text, done)


def _head(path: Path) -> tuple[list[str], str]:
    """The first lines that a file begins with, and its encoding."""
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            raw = file.read(1 << 16)
    except (OSError, EOFError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    if b"\0" in raw:
        raise InputError(f"{path}: is no text; a CSV log is")
    lines = raw.splitlines()
    lines = lines[:-1] if len(raw) == 1 << 16 else lines  # the last may be cut
    try:
        encoding, text = "utf-8", [line.decode("utf-8-sig") for line in lines[:50]]
    except UnicodeDecodeError:
        encoding, text = "latin-1", [line.decode("latin-1") for line in lines[:50]]
    return [line for line in text if line.strip()], encoding


def _fields(line: str, delimiter: str) -> list[str]:
    import csv

    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter))]


def _number(cell: str, decimal: str) -> bool:
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True
