"""Recordings of joysticks: columns of text and Parquet files, read as logs are; whatever is doubtful in one is an error."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.columns.cells import is_time, numbers
from polydraulic.columns.text_file import TextFile
from polydraulic.errors import InputError

ENDINGS = (".csv", ".csv.gz", ".txt", ".parquet")
_HARMLESS = ("comment", "short line", "midnight", "clock change", "thousands", "on and off")


class _Strict:
    """Notes of a reader of which all but harmless ones are errors."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def add(self, kind: str, channel: str = "", detail: str = "") -> object:
        if kind not in _HARMLESS:
            of = f" of column {channel!r}" if channel else ""
            raise InputError(f"{self.path}: {kind}{of}" + (f": {detail}" if detail else ""))
        return None

    def add_rows(self, kind: str, channel: str, rows: np.ndarray, detail: str = "") -> None:
        if rows.size:
            self.add(kind, channel, f"row {int(rows[0])}" + (f", {detail}" if detail else ""))

    def expect(self, kind: str, channel: str, detail: str) -> None:
        """Do nothing: the finding, if it comes, is an error of its own."""


class Recording:
    """An opened recording.

    Parameters
    ----------
    path : Path
        One of `ENDINGS`.

    Attributes
    ----------
    names : list of str
        Of its columns.

    Raises
    ------
    InputError
        A file that cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        if not path.is_file():
            raise InputError(f"{path}: no such file")
        self._text = None if path.suffix.lower() == ".parquet" else TextFile(path)
        if self._text is not None:
            self.names = self._text.names
        else:
            import pyarrow as pa
            import pyarrow.parquet as pq

            try:
                self._table = pq.read_table(path)
            except (pa.ArrowException, OSError) as error:
                raise InputError(f"{path}: cannot be read as Parquet ({str(error).splitlines()[0]})") from error
            self.names = self._table.schema.names

    def columns(self, time: str, others: Sequence[str]) -> list[np.ndarray]:
        """Time in s (dates as s since 1970) and voltages in V.

        Raises
        ------
        InputError
            A column that is not there or comes twice, a unit of another kind, a cell that is not a number.
        """
        for name in (time, *others):
            if name not in self.names:
                raise InputError(f"{self.path}: no column {name!r}; the table has {self.names}")
            if self.names.count(name) > 1:
                raise InputError(f"{self.path}: two columns are called {name!r}; rename one of them")
        found = self._of_text(time, others) if self._text is not None else self._of_parquet(time, others)
        if not found or len(found[0]) == 0:
            raise InputError(f"{self.path}: the table has no rows")
        kinds = [("s", time), *(("V", name) for name in others)]
        return [self._si(name, unit, values) for (unit, name), values in zip(kinds, found, strict=True)]

    def _of_text(self, time: str, others: Sequence[str]) -> list[np.ndarray]:
        assert self._text is not None
        blocks: Iterator[Any] = self._text.read(others, time, _Strict(self.path))
        parts: list[list[np.ndarray]] = []
        for block in blocks:
            for name, places in block.text.items():
                if places.size:
                    raise InputError(f"{self.path}: column {name!r} has no number in row {block.rows[places[0]]}")
            parts.append([block.time, *(block.values[name] for name in others)])
        return [np.concatenate(column) for column in zip(*parts, strict=True)]

    def _of_parquet(self, time: str, others: Sequence[str]) -> list[np.ndarray]:
        found = []
        for name in (time, *others):
            values, bad = numbers(self._table.column(name))
            if bad.size:
                raise InputError(f"{self.path}: column {name!r} has no number in row {bad[0] + 1}")
            found.append(values)
        return found

    def _si(self, name: str, unit: str, values: np.ndarray) -> np.ndarray:
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(f"{self.path}: column {name!r} holds {values[bad[0]]:g} in row {bad[0] + 1}")
        given = self._unit(name) or unit
        try:
            found = units.read_unit(given)
        except InputError as error:
            raise InputError(f"{self.path}: column {name!r}: {error}") from error
        if found.si != unit:
            raise InputError(
                f"{self.path}: column {name!r} has unit {given!r}; it must be one of {list(units.FACTORS[unit])}"
            )
        return np.asarray(found.to_si(values))

    def _unit(self, name: str) -> str:
        """Unit of a column as the file gives it; dates and times of day are in s."""
        if self._text is not None:
            return "" if self._text.kind(name) else self._text.units[self._text.place(name)]
        column = self._table.schema.field(name)
        return "" if is_time(column.type) else (column.metadata or {}).get(b"unit", b"").decode("utf-8", "replace")
