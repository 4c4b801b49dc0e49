"""Rows of a text file as blocks of text cells, in bounded memory; rows of other lengths are repaired or named."""

import csv as python_csv
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.ahead import ahead
from polydraulic.columns.cells import MISSING
from polydraulic.columns.dialect import BLANKS, Dialect, end_of_cell, fields
from polydraulic.columns.local_clock import Notes
from polydraulic.columns.quotes import as_usual
from polydraulic.columns.source import DAMAGED, Scan, Source
from polydraulic.errors import InputError

BLOCK = 4 << 20  # bytes
_COMMENT = ("#", "//", "%", ";")
_COMPARED = 20  # lines at least that a last one without an end is compared with
_BEFORE_CUT = 1 << 16  # bytes that these are looked for in: the last of many is hardly the one with fewest decimals


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

    def expect(self, kind: str, channel: str, detail: str) -> None:
        """Do nothing."""


def cell_blocks(
    path: Path,
    found: Scan,
    dialect: Dialect,
    columns: Sequence[int],
    notes: Notes,
    numeric: Collection[int] = (),
    decimal: str = ".",
) -> Iterator[CellBlock]:
    """Read columns of a text file, block by block.

    Parameters
    ----------
    path : Path
    found : Scan
    dialect : Dialect
    columns : sequence of int
        Places of the columns.
    notes : Notes
        Takes ``missing line``, ``short line``, ``cut line`` and ``comment``.
    numeric : collection of int
        Columns that come as numbers in blocks in which they hold nothing else, and as texts in others.
    decimal : str
        The decimal mark of these.

    Raises
    ------
    InputError
        A file that is damaged.
    """
    parser = _Parser(dialect, columns, numeric, decimal)
    begun = 0  # lines of data before the block
    waiting: list[tuple[int, str]] = []  # odd rows behind the last good one of their block
    for text, batch, odd, share, cut in ahead(_parsed(path, found, dialect, parser)):
        count, odd = batch.num_rows + len(odd), [(begun + number, line) for number, line in odd]
        if cut:
            notes.add_rows(
                "cut line",
                "",
                np.array([begun + count + 1]),
                f"its last value is {cut!r}: if it is whole, end its line",
            )
        rows = np.arange(begun + 1, begun + 1 + count)
        rows = np.delete(rows, [number - begun - 1 for number, _ in odd]) if odd else rows
        begun, odd = begun + count, waiting + odd
        last = int(rows[-1]) if len(rows) else 0
        mended = _mend([row for row in odd if row[0] < last], dialect, columns, notes)
        waiting = [row for row in odd if row[0] > last]
        if not len(rows):
            continue
        block = CellBlock(rows, {n: batch.column(str(n)) for n in columns}, share)
        if mended is not None:
            numbers = _as_numbers(mended, parser.of(batch), decimal)
            if numbers is None:
                texts = parser.texts(text)[0]
                block = block._replace(cells={n: texts.column(str(n)) for n in columns})
            block = _merge(block, mended if numbers is None else numbers)
        yield block
    mended = _mend(waiting, dialect, columns, notes)
    if mended is not None:
        yield mended


def _parsed(
    path: Path, found: Scan, dialect: Dialect, parser: "_Parser"
) -> Iterator[tuple[bytes, Any, Any, float, str]]:
    """Blocks of whole lines, what the parser makes of them, the share of the file that has been read, and a last value that is cut off."""
    import pyarrow as pa

    earlier = b""
    try:
        with Source(path, found.encoding, dialect.begin, dialect.delimiter == BLANKS) as source:
            for block in source.lines(BLOCK):
                text, cut = without_stray_quotes(as_usual(block, dialect.quotes)), ""
                if str(dialect.width - 1) in parser.needed:
                    text, cut = without_cut_line(text, parser.delimiter, parser.decimal, earlier)
                    earlier = (earlier + text[-_BEFORE_CUT:])[-_BEFORE_CUT:]
                yield text, *parser.parse(text), source.share, cut
    except (pa.ArrowException, UnicodeError, *DAMAGED) as error:
        said = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(f"{path}: cannot be read as a CSV log ({said})") from error


def without_cut_line(text: bytes, delimiter: str, decimal: str = ".", earlier: bytes = b"") -> tuple[bytes, str]:
    """Lines without a last one that breaks off within its last value, and what is left of this one; empty where none breaks off.

    `earlier` is what stands before them.

    A logger that loses its power leaves 10 of 101.99. The file then ends without the end of a line, behind a value with fewer decimals than
    any before it, or a whole number with fewer digits than those just before. Where there are decimals, digits say nothing: 9.99 follows 10.00.
    """
    if text.endswith((b"\n", b"\r")) or not text:
        return text, ""
    start = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1
    line, mark = text[start:], delimiter.encode()
    before = (earlier + text[max(0, start - _BEFORE_CUT) : start]).splitlines()[1:]
    others = [one.rpartition(mark)[2].strip() for one in before if one.count(mark) == line.count(mark)]
    others, last = [one for one in others if one], line.rpartition(mark)[2].strip()
    if not last or len(others) < _COMPARED or b'"' in line:
        return text, ""
    decimals = [_decimals(one, decimal.encode()) for one in others]
    left = _decimals(last, decimal.encode())
    whole = max(decimals) < 0 and last.lstrip(b"+-").isdigit()
    cut = left < min(decimals) or (whole and len(last) < min(map(len, others[-_COMPARED:])))
    return (text[:start], last.decode("utf-8", "replace")) if cut else (text, "")


def _decimals(value: bytes, mark: bytes) -> int:
    """Letters behind a decimal mark, those of an exponent among them; -1 without a mark."""
    return len(value) - 1 - value.index(mark) if mark in value else -1


def without_stray_quotes(text: bytes) -> bytes:
    """Lines without quotes that no other closes within a few lines: they would hide all rows up to the next one."""
    if b'"' not in text:
        return text
    letters = np.frombuffer(text, dtype=np.uint8)
    ends = np.flatnonzero((letters == ord("\n")) | (letters == ord("\r")))
    before = np.searchsorted(np.flatnonzero(letters == ord('"')), [*ends, len(letters)])
    if not (np.diff(before, prepend=0) % 2).any():  # quotes are in pairs in every line
        return text
    lines = text.splitlines(keepends=True)
    place = 0
    while place < len(lines):
        end = end_of_cell(lines, place)
        if end is None:
            lines[place] = lines[place].replace(b'"', b"")
        place = place + 1 if end is None else end
    return b"".join(lines)


class _Parser:
    """Makes Arrow columns of lines. A column that held something else than numbers once is one of texts from then on."""

    def __init__(self, dialect: Dialect, columns: Sequence[int], numeric: Collection[int], decimal: str) -> None:
        self.names = [str(n) for n in range(dialect.width)]
        self.needed = [str(n) for n in dict.fromkeys(columns)]
        self.delimiter = "\t" if dialect.delimiter == BLANKS else dialect.delimiter
        self.numeric, self.decimal = {str(n) for n in numeric}, decimal

    def parse(self, text: bytes) -> tuple[Any, list[tuple[int, str]]]:
        """Columns of lines, and the numbers and texts of lines that have not as many fields as there are columns."""
        import pyarrow as pa

        if self.numeric:
            try:
                return self._read(text, self.numeric)
            except pa.ArrowInvalid:  # some column is not, or not here
                pass
        batch, odd = self.texts(text)
        self.numeric = {name for name in self.numeric if _cast(batch.column(name), self.decimal) is not None}
        return batch, odd

    def texts(self, text: bytes) -> tuple[Any, list[tuple[int, str]]]:
        """The same with all columns as texts."""
        return self._read(text, set())

    def of(self, batch: Any) -> set[int]:
        """Columns that have come as numbers."""
        import pyarrow as pa

        return {int(field.name) for field in batch.schema if pa.types.is_floating(field.type)}

    def _read(self, text: bytes, numeric: Collection[str]) -> tuple[Any, list[tuple[int, str]]]:
        import pyarrow as pa
        from pyarrow import csv

        odd: list[tuple[int, str]] = []

        def keep(row: Any) -> str:
            odd.append((row.number, row.text))
            return "skip"

        table = csv.read_csv(
            pa.py_buffer(text or b"\n"),  # nothing is left of a block of one line that breaks off
            # one thread, since only then are lines numbered
            csv.ReadOptions(use_threads=False, block_size=len(text) + 1, column_names=self.names),
            csv.ParseOptions(delimiter=self.delimiter, invalid_row_handler=keep),
            csv.ConvertOptions(
                include_columns=self.needed,
                column_types={name: pa.float64() if name in numeric else pa.string() for name in self.needed},
                null_values=MISSING,
                strings_can_be_null=True,
                decimal_point=self.decimal,
            ),
        )
        return table.combine_chunks().to_batches()[0] if table.num_rows else _empty(table.schema), odd


def _empty(schema: Any) -> Any:
    import pyarrow as pa

    return pa.RecordBatch.from_arrays([pa.array([], field.type) for field in schema], schema=schema)


def _cast(cells: Any, decimal: str) -> Any:
    """Texts as numbers; None if they are not."""
    import pyarrow as pa
    import pyarrow.compute as pc

    if decimal != ".":
        cells = pc.replace_substring(pc.replace_substring(cells, ".", "?"), decimal, ".")
    try:
        return cells.cast(pa.float64())
    except pa.ArrowInvalid:
        return None


def _as_numbers(block: CellBlock, numeric: Collection[int], decimal: str) -> CellBlock | None:
    """A block of texts with these columns as numbers; None if they are not."""
    cells = {n: _cast(of, decimal) if n in numeric else of for n, of in block.cells.items()}
    return None if any(of is None for of in cells.values()) else block._replace(cells=cells)


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
