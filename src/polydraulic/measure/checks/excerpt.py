"""A part of a long table that is small enough to be looked at: whole pieces of rows from all over it."""

from collections.abc import Mapping

import numpy as np

from polydraulic.tables import Table

_PIECE = 2000  # rows
_PIECES = 150


class Excerpt:
    """Pieces of rows that come block by block; when they are too many, every other one goes.

    Parameters
    ----------
    units : mapping from name to unit
        The columns, ``time`` and ``segment`` first.
    """

    def __init__(self, units: Mapping[str, str]) -> None:
        self.units = dict(units)
        self.n_row = 0
        self._pieces: list[tuple[int, np.ndarray]] = []  # number of the piece, its rows
        self._open: list[np.ndarray] = []
        self._every, self._number = 1, 0

    def add(self, columns: list[np.ndarray]) -> None:
        """Add rows."""
        block = np.column_stack(columns)
        self.n_row += len(block)
        while len(block):
            room = _PIECE - sum(map(len, self._open))
            self._open.append(block[:room])
            block = block[room:]
            if sum(map(len, self._open)) == _PIECE:
                self._close()

    def _close(self) -> None:
        if self._open and self._number % self._every == 0:
            self._pieces.append((self._number, np.concatenate(self._open)))
        self._number += 1
        self._open = []
        if len(self._pieces) > _PIECES:
            self._every *= 2
            self._pieces = [piece for piece in self._pieces if piece[0] % self._every == 0]

    def table(self) -> Table:
        """The rows kept; pieces that do not follow one another are segments of their own."""
        if self._open:
            self._close()
        rows = np.concatenate([piece for _, piece in self._pieces] or [np.empty((0, len(self.units)))])
        numbers = np.concatenate([np.full(len(p), n) for n, p in self._pieces] or [np.zeros(0)])
        names = list(self.units)
        columns = {name: np.ascontiguousarray(rows[:, place]) for place, name in enumerate(names)}
        if len(rows):
            fresh = (np.diff(columns["segment"]) != 0.0) | (np.diff(numbers) > 1)
            columns["segment"] = np.concatenate([[0.0], np.cumsum(fresh)])
        return Table(columns, self.units)
