"""Rows of one topic in a temporary file: columns come in when messages bring them, and are never more than a bound."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from polydraulic.measure.formats.log import BLOCK
from polydraulic.measure.formats.ros.fields import BagColumn, Layout

MOST = 512  # columns of a topic
_WAITING = 256  # rows that wait for being written
_BYTES = 8 << 20  # of a block that is read
_STAMP, _RECEIPT, _LAYOUT, _HEAD = 0, 1, 2, 3  # what stands before the values of a row


class TopicRows:
    """Times, layouts and numbers of the messages of a topic.

    Attributes
    ----------
    columns : list of BagColumn
    n_row : int
    too_many : int
        Rows that were not kept: they would have brought more columns than `MOST`.
    """

    def __init__(self, path: Path) -> None:
        self.columns: list[BagColumn] = []
        self.n_row = self.too_many = 0
        self._path = path
        self._places: dict[str, int] = {}
        self._layouts: dict[Layout, tuple[int, np.ndarray]] = {}
        self._written: list[tuple[int, int]] = []  # width and number of rows, of stretches of the file
        self._waiting = np.zeros((0, 0))
        self._n_waiting = 0

    def knows(self, layout: Layout) -> bool:
        """Whether rows of this layout have been added."""
        return layout in self._layouts

    def add_layout(self, layout: Layout, columns: Sequence[BagColumn]) -> bool:
        """Add the columns of a layout that is new; False where they are too many."""
        fresh = [column for column in columns if column.name not in self._places]
        if len(self.columns) + len(fresh) > MOST or len(self._layouts) >= MOST:
            return False
        if fresh:
            self.flush()
            for column in fresh:
                self._places[column.name] = len(self.columns)
                self.columns.append(column)
            self._waiting = np.zeros((_WAITING, _HEAD + len(self.columns)))
        places = np.array([self._places[column.name] for column in columns], dtype=np.int64)
        self._layouts[layout] = len(self._layouts), _HEAD + places
        return True

    def add(self, stamp: float, receipt: float, layout: Layout, values: Sequence[float]) -> None:
        """Add a row; both times in s."""
        number, places = self._layouts[layout]
        if self._waiting.shape[0] == 0:
            self._waiting = np.zeros((_WAITING, _HEAD))
        row = self._waiting[self._n_waiting]
        row[_HEAD:] = np.nan
        row[_STAMP], row[_RECEIPT], row[_LAYOUT] = stamp, receipt, number
        row[places] = values
        self._n_waiting += 1
        self.n_row += 1
        if self._n_waiting == _WAITING:
            self.flush()

    def flush(self) -> None:
        """Write what waits."""
        if not self._n_waiting:
            return
        rows = self._waiting[: self._n_waiting]
        with self._path.open("ab") as file:
            file.write(rows.tobytes())
        width, n = rows.shape[1], rows.shape[0]
        if self._written and self._written[-1][0] == width:
            self._written[-1] = width, self._written[-1][1] + n
        else:
            self._written.append((width, n))
        self._n_waiting = 0

    def parts(self) -> list[tuple[list[int], list[BagColumn]]]:
        """Layouts that have no column in common, with their columns: messages of publishers that share a topic."""
        found: list[tuple[list[int], set[int]]] = []
        for number, places in self._layouts.values():
            own = set(places.tolist())
            if not own:
                continue
            same = [part for part in found if part[1] & own]
            found = [part for part in found if not part[1] & own]
            found.append(([number, *(n for part in same for n in part[0])], own.union(*(part[1] for part in same))))
        found.sort(key=lambda part: min(part[1]))
        return [(numbers, [self.columns[place - _HEAD] for place in sorted(own)]) for numbers, own in found]

    def blocks(
        self, layouts: Sequence[int], names: Sequence[str], *, stamped: bool
    ) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray], float]]:
        """Times and values of some columns, of the rows of some layouts, and the share of the file that has been read.

        Parameters
        ----------
        layouts : sequence of int
        names : sequence of str
        stamped : bool
            Whether times are those of the headers, or of receipt.
        """
        at, done = 0, 0
        for width, n in self._written:
            most = min(BLOCK, _BYTES // (8 * width))
            for begun in range(0, n, most):
                count = min(most, n - begun)
                rows = np.fromfile(self._path, count=count * width, offset=at).reshape(count, width)
                at, done = at + rows.nbytes, done + count
                rows = rows[np.isin(rows[:, _LAYOUT], layouts)]
                places = {name: _HEAD + self._places[name] for name in names}
                values = {
                    name: rows[:, place].copy() if place < width else np.full(len(rows), np.nan)
                    for name, place in places.items()
                }
                yield rows[:, _STAMP if stamped else _RECEIPT].copy(), values, done / self.n_row
