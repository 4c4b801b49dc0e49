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
        self._pieces: list[tuple[int, list[np.ndarray]]] = []  # number of the piece, its columns
        self._open: list[list[np.ndarray]] = []  # parts of the piece that is not full yet
        self._n_open = 0
        self._every, self._number = 1, 0

    def add(self, columns: list[np.ndarray]) -> None:
        """Add rows."""
        n_row, begin = len(columns[0]), 0
        self.n_row += n_row
        while begin < n_row:
            end = min(n_row, begin + _PIECE - self._n_open)
            if self._number % self._every == 0:
                self._open.append([column[begin:end].copy() for column in columns])
            self._n_open += end - begin
            begin = end
            if self._n_open == _PIECE:
                self._close()

    def _close(self) -> None:
        if self._open:
            self._pieces.append((self._number, [np.concatenate(parts) for parts in zip(*self._open, strict=True)]))
        self._number += 1
        self._open, self._n_open = [], 0
        if len(self._pieces) > _PIECES:
            self._every *= 2
            self._pieces = [piece for piece in self._pieces if piece[0] % self._every == 0]

    def table(self) -> Table:
        """The rows kept; pieces that do not follow one another are segments of their own."""
        if self._open:
            self._close()
        names, pieces = list(self.units), [piece for _, piece in self._pieces] or [[np.zeros(0)] * len(self.units)]
        columns = dict(zip(names, map(np.concatenate, zip(*pieces, strict=True)), strict=True))
        numbers = np.concatenate([np.full(len(p[0]), n) for n, p in self._pieces] or [np.zeros(0)])
        if len(numbers):
            fresh = (np.diff(columns["segment"]) != 0.0) | (np.diff(numbers) > 1)
            columns["segment"] = np.concatenate([[0.0], np.cumsum(fresh)])
        return Table(columns, self.units)
