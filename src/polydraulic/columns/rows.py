"""Rows of a text file as blocks of text cells, in bounded memory; rows of other lengths are repaired or named."""

import csv as python_csv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.columns.cells import MISSING
from polydraulic.columns.dialect import BLANKS, Dialect, fields
from polydraulic.columns.local_clock import Notes
from polydraulic.columns.source import DAMAGED, Scan, Source
from polydraulic.errors import InputError

BLOCK = 4 << 20  # bytes
_COMMENT = ("#", "//", "%", ";")


class CellBlock(NamedTuple):
    """Some rows: their numbers (lines of data counted from 1), their cells by column (Arrow arrays), the share that is read."""

    rows: np.ndarray
    cells: dict[int, Any]
    done: float


class Silent:
    """Notes that nobody reads."""

    def add(self, kind: str, channel: str = "", detail: str = "") -> object:
        """Do nothing."""
        return None

    def add_rows(self, kind: str, channel: str, rows: np.ndarray, detail: str = "") -> None:
        """Do nothing."""


def cell_blocks(path: Path, found: Scan, dialect: Dialect, columns: Sequence[int], notes: Notes) -> Iterator[CellBlock]:
    """Read columns of a text file, block by block.

    Parameters
    ----------
    path : Path
    found : Scan
    dialect : Dialect
    columns : sequence of int
        Places of the columns.
    notes : Notes
        Takes ``missing line``, ``short line`` and ``comment``.

    Raises
    ------
    InputError
        A file that is damaged.
    """
    import pyarrow as pa
    from pyarrow import csv

    odd: list[tuple[int, str]] = []

    def keep(row: Any) -> str:
        odd.append((row.number, row.text))
        return "skip"

    names = [str(n) for n in range(dialect.width)]
    needed = [str(n) for n in dict.fromkeys(columns)]
    delimiter = "\t" if dialect.delimiter == BLANKS else dialect.delimiter
    seen, begun = 0, 0  # of the odd rows; rows that Arrow has given
    with Source(path, found.encoding, dialect.begin, dialect.delimiter == BLANKS) as source:
        try:
            reader = csv.open_csv(
                pa.PythonFile(source, mode="r"),
                # one thread, since only then are lines numbered
                csv.ReadOptions(use_threads=False, block_size=BLOCK, column_names=names),
                csv.ParseOptions(delimiter=delimiter, invalid_row_handler=keep),
                csv.ConvertOptions(
                    include_columns=needed,
                    column_types=dict.fromkeys(needed, pa.string()),
                    null_values=MISSING,
                    strings_can_be_null=True,
                ),
            )
            for batch in reader:
                rows = np.arange(begun, begun + batch.num_rows) + 1
                begun += batch.num_rows
                numbered = np.asarray([number for number, _ in odd], dtype=np.int64)
                rows += np.searchsorted(numbered - np.arange(len(odd)), rows, side="right")
                last = int(rows[-1]) if len(rows) else 0
                upto = int(np.searchsorted(numbered, last))
                mended = _mend(odd[seen:upto], dialect, columns, notes)
                seen = upto
                cells = {n: batch.column(str(n)) for n in columns}
                yield _merge(CellBlock(rows, cells, source.share), mended)
        except pa.ArrowInvalid as error:
            if "Empty CSV file" not in str(error):
                raise _unreadable(path, error) from error
        except (pa.ArrowException, UnicodeError, *DAMAGED) as error:
            raise _unreadable(path, error) from error
    mended = _mend(odd[seen:], dialect, columns, notes)
    if mended is not None:
        yield mended


def _unreadable(path: Path, error: Exception) -> InputError:
    said = (str(error).splitlines() or [type(error).__name__])[0]
    return InputError(f"{path}: cannot be read as a CSV log ({said})")


def _mend(odd: Sequence[tuple[int, str]], dialect: Dialect, columns: Sequence[int], notes: Notes) -> CellBlock | None:
    """Rows of other lengths that can be used; the others are noted."""
    import pyarrow as pa

    kept: list[tuple[int, list[str]]] = []
    short, missing, comments = [], [], []
    for number, text in odd:
        if text.lstrip().startswith(_COMMENT[: 3 if dialect.delimiter == ";" else 4]):
            comments.append(number)
            continue
        try:
            cells = fields(text, "\t" if dialect.delimiter == BLANKS else dialect.delimiter)
        except python_csv.Error:
            cells = []
        if len(cells) > dialect.width and not any(cells[dialect.width :]):
            kept.append((number, cells[: dialect.width]))  # it ends in delimiters
        elif len(cells) in dialect.short:
            short.append(number)
            kept.append((number, cells + [""] * (dialect.width - len(cells))))
        else:
            missing.append(number)
    for kind, rows in (("missing line", missing), ("short line", short), ("comment", comments)):
        notes.add_rows(kind, "", np.asarray(rows, dtype=np.int64))
    if not kept:
        return None
    table = {n: pa.array([None if c[n] in MISSING else c[n] for _, c in kept], pa.string()) for n in columns}
    return CellBlock(np.asarray([number for number, _ in kept]), table, 1.0)


def _merge(block: CellBlock, more: CellBlock | None) -> CellBlock:
    import pyarrow as pa

    if more is None:
        return block
    rows = np.concatenate([block.rows, more.rows])
    order = np.argsort(rows, kind="stable")
    cells = {n: pa.concat_arrays([c, more.cells[n]]).take(pa.array(order)) for n, c in block.cells.items()}
    return CellBlock(rows[order], cells, block.done)
