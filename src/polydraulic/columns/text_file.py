"""A text file of columns: opened, its columns as numbers and its time in seconds, block by block."""

import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.columns.dialect import BLANKS, Dialect, find_dialect
from polydraulic.columns.header import example
from polydraulic.columns.local_clock import LocalClock, Notes
from polydraulic.columns.rows import Silent, cell_blocks
from polydraulic.columns.source import Scan, scan_bytes
from polydraulic.columns.survey import Notation, TextColumn, survey
from polydraulic.columns.timestamps import DateOrder, doubt, has_time_of_day, has_zone, seconds, time_kind


class NumberBlock(NamedTuple):
    """Some rows.

    Attributes
    ----------
    rows : (n_row,) array of int
        Lines of data counted from 1.
    time : (n_row,) array or None
        In s where the column holds times as text, otherwise its numbers.
    values : dict from name to (n_row,) array
        NaN where there is no value.
    text : dict from name to array of int
        Places in the block that hold something that is not a number.
    done : float
        Share of the file that has been read.
    """

    rows: np.ndarray
    time: np.ndarray | None
    values: dict[str, np.ndarray]
    text: dict[str, np.ndarray]
    done: float


class TextFile:
    """An opened text file.

    Parameters
    ----------
    path : str or Path
        Commas, semicolons, tabs, pipes or blanks between cells; ``.gz`` is unpacked as it is read.
    dates : str, optional
        ``"dd/mm/yyyy"`` or ``"mm/dd/yyyy"``, for dates that can be read in two ways.

    Attributes
    ----------
    path : Path
    dialect : Dialect
    names, units : list of str
        Of the columns.

    Raises
    ------
    InputError
        A file that is damaged, empty, without rows, or no text.
    """

    def __init__(self, path: str | Path, dates: str | None = None) -> None:
        self.path, self.dates = Path(path), dates
        self._scan: Scan = scan_bytes(self.path)
        self.dialect: Dialect = find_dialect(self.path, self._scan)
        end = self.dialect.n_column
        self.names, self.units = self.dialect.names[:end], self.dialect.units[:end]
        body = self._scan.head[self.dialect.begin :]
        self._comma = self._scan.comma or b"," in body
        self._point = self._scan.point or b"." in body
        self._quote = self._scan.quote or b'"' in body
        self._orders: dict[str, DateOrder] = {}
        heads = [f"{name} ({unit})" for name, unit in zip(self.names, self.units, strict=True)]
        self._places: dict[str, int] = {}
        for names in (self.names, heads):
            for place, name in enumerate(names):
                self._places.setdefault(name, place)

    def place(self, name: str) -> int:
        """Place of the first column of a name; the header's own text will do, too."""
        return self._places[name]

    def kind(self, name: str) -> str:
        """``"stamp"`` or ``"clock"`` for a column of dates or of times of day, otherwise an empty text."""
        return time_kind(self._sample(name))

    def zoned(self, name: str) -> bool:
        """Whether times of a column say their zone."""
        return has_zone(self._sample(name))

    def date_beside(self, name: str) -> str | None:
        """The column with the dates to a column of times of day, or the other way round; None if there is none."""
        kind, place = self.kind(name), self.place(name)
        if not kind or (kind == "stamp" and has_time_of_day(self._sample(name))):
            return None
        for beside in (place - 1, place + 1):
            if 0 <= beside < len(self.names):
                other = self.names[beside]
                kinds = {kind, self.kind(other)}
                dates = other if kind == "clock" else name
                if kinds == {"stamp", "clock"} and not has_time_of_day(self._sample(dates)):
                    return other
        return None

    def order_in_doubt(self, name: str) -> str:
        """A date of a column whose day and month cannot be told apart; empty if they can, or need not be."""
        if self.dates is not None or self.kind(name) != "stamp":
            return ""
        found = self.order(name)
        return "" if found.settled else found.example

    def read(self, wanted: Sequence[str], time: str | None, notes: Notes) -> Iterator[NumberBlock]:
        """Read columns as numbers, block by block.

        Parameters
        ----------
        wanted : sequence of str
            Names of columns.
        time : str or None
            TextColumn of the time. Dates, and times of day with the dates in the column beside it, are read as s.
        notes : Notes
            Takes what is wrong with lines, numbers and local clocks.

        Raises
        ------
        InputError
            A file that is damaged, dates that can be read in two ways.
        """
        if self.dialect.unnamed:
            notes.add("header", "", self.dialect.unnamed)
        clock = None if time is None else _Time(self, time, notes)
        places = {name: self.place(name) for name in wanted}
        columns = self._columns(places, notes)
        read = {(place, columns[name]) for name, place in places.items()}
        if clock is not None and clock.numbers is not None:
            read.add((clock.place, clock.numbers))
        decimal = "," if any(column.reading.decimal == "," for _, column in read) else "."
        numeric = {place for place, column in read if column.plain(decimal)}
        numeric -= {place for place, column in read if not column.plain(decimal)}  # read in two ways
        of_time = [] if clock is None else clock.places
        told: set[str] = set()
        wide = list(dict.fromkeys([*of_time, *places.values()]))
        for block in cell_blocks(self.path, self._scan, self.dialect, wide, notes, numeric, decimal):
            values, text = {}, {}
            for name, place in places.items():
                values[name], text[name] = columns[name].numbers(block.cells[place])
            at = None if clock is None else clock.times(block.cells, block.rows)
            for name in set(places) - told:
                kept = text[name] if at is None else text[name][np.isfinite(at[text[name]])]
                if kept.size:
                    told.add(name)
                    notes.expect("text", name, example(block.cells[places[name]][int(kept[0])].as_py()))
            yield NumberBlock(block.rows, at, values, text, block.done)

    def column(self, name: str, notes: Notes) -> TextColumn:
        """Return the reader of one column's numbers."""
        return self._columns({name: self.place(name)}, notes)[name]

    def _columns(self, places: dict[str, int], notes: Notes) -> dict[str, TextColumn]:
        readings = self._readings(places)
        for name, reading in readings.items():
            if reading.kind:
                notes.add(reading.kind, name, reading.detail)

        def whole(name: str) -> Notation:
            found = self._survey({name: places[name]})[name]
            if found.kind:
                notes.add(found.kind, name, found.detail)
            return found

        return {name: TextColumn(reading, lambda n=name: whole(n)) for name, reading in readings.items()}  # type: ignore[misc]

    def _readings(self, places: dict[str, int]) -> dict[str, Notation]:
        """One reading per column; the whole file is looked at only where marks in it leave a doubt."""
        comma = self._comma and (self.dialect.delimiter != "," or self._quote)
        if not comma:
            if self.dialect.delimiter in (",", BLANKS) or not self._point:
                return dict.fromkeys(places, Notation())
            doubtful = self._doubtful(places, ".")
            return dict.fromkeys(places, Notation()) | self._survey(doubtful)
        if not self._point:
            doubtful = self._doubtful(places, ",")
            return dict.fromkeys(places, Notation(",")) | self._survey(doubtful)
        return self._survey(places)

    def _doubtful(self, places: dict[str, int], mark: str) -> dict[str, int]:
        """Columns whose first cells do not settle whether a mark is the decimal one."""
        settles = _settles(mark)
        found = {}
        for name, place in places.items():
            cells = [row[place] for row in self.dialect.sample if place < len(row) and row[place]]
            if not any(settles.match(c) for c in cells):
                found[name] = place
        return found

    def _sure_mark(self) -> str:
        """The decimal mark that the first cells of all columns show for sure; empty if they show none, or both often."""
        cells = [cell for row in self.dialect.sample for cell in row]
        comma, point = (sum(bool(_settles(mark).match(cell)) for cell in cells) for mark in ",.")
        return "," if comma > 20 * point else "." if point > 20 * comma else ""

    def _survey(self, places: dict[str, int]) -> dict[str, Notation]:
        if not places:
            return {}
        usual = "," if self._comma and self.dialect.delimiter != "," else "."
        blocks = cell_blocks(self.path, self._scan, self.dialect, list(dict.fromkeys(places.values())), Silent())
        found = survey((_by_name(block.cells, places) for block in blocks), places, usual, self._sure_mark())
        return found

    def order(self, name: str) -> DateOrder:
        """What the dates of a column tell about their order."""
        if name not in self._orders:
            order = DateOrder()
            place = self.place(name)
            for block in cell_blocks(self.path, self._scan, self.dialect, [place], Silent()):
                order.look(block.cells[place])
                if order.order is not None or not order.needed:
                    break
            self._orders[name] = order
        return self._orders[name]

    def _sample(self, name: str) -> list[str]:
        place = self.place(name)
        return [row[place] for row in self.dialect.sample if place < len(row)]


class _Time:
    """The time of a text file: numbers, dates, times of day, or dates and times of day in two columns."""

    def __init__(self, file: TextFile, name: str, notes: Notes) -> None:
        self.name, self.notes = name, notes
        self.kind = file.kind(name)
        beside = file.date_beside(name)
        date, clock = (beside, name) if self.kind == "clock" else (name, beside)
        self.places = [file.place(n) for n in (date, clock) if n is not None]
        self.place = file.place(name)
        self.order = file.dates
        self.numbers: TextColumn | None = None
        if not self.kind:
            self.numbers = file.column(name, notes)
            return
        self.both = date is not None and clock is not None
        if date is not None:
            example = file.order_in_doubt(date)
            if example:
                raise doubt(file.path, date, example)
            self.order = self.order or (file.order(date).order if file.kind(date) == "stamp" else None)
        self.local = None if file.zoned(name) else LocalClock(name, date is None, notes)

    def times(self, cells: dict[int, Any], rows: np.ndarray) -> np.ndarray:
        if self.numbers is not None:
            values, bad = self.numbers.numbers(cells[self.place])
            self._note(cells[self.place], bad)
            return values
        if self.both:
            date, clock = (cells[place] for place in self.places)
            found = seconds(date, "stamp", self.order) + seconds(clock, "clock")
        else:
            found = seconds(cells[self.place], self.kind, self.order)
        valid = cells[self.place].is_valid().to_numpy(zero_copy_only=False)
        self._note(cells[self.place], np.flatnonzero(~np.isfinite(found) & valid))
        return found if self.local is None else self.local.times(found, rows)

    def _note(self, cells: Any, bad: np.ndarray) -> None:
        if bad.size:
            self.notes.add("no time", self.name, example(cells[int(bad[0])].as_py()))


@cache
def _settles(mark: str) -> re.Pattern[str]:
    """What cells look like in which a mark can be nothing but the decimal one."""
    m = re.escape(mark)
    return re.compile(rf"^[+-]?(0*{m}\d+|0{m}\d*|\d+{m}(\d{{0,2}}|\d{{4,}}))([eE].*)?$")


def _by_name(cells: dict[int, Any], places: dict[str, int]) -> dict[str, Any]:
    return {name: cells[place] for name, place in places.items()}
