"""How much of the operating box a table has seen, and where it has not been."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.tables import Table
from polydraulic.units import Conversion

CELLS = 10  # along each side of a map
LEVELS = 4  # of each input, in the box of all of them
_LEAST = 0.04  # share of a map that an empty rectangle needs to be named
_NAMED = 3  # holes of a map


class Hole(NamedTuple):
    """An empty rectangle of a map: ranges of both inputs, and the share of the map that it takes."""

    x: tuple[float, float]
    y: tuple[float, float]
    share: float


class PairMap(NamedTuple):
    """Where a pair of inputs has been.

    Attributes
    ----------
    x, y : str
    x_edges, y_edges : (CELLS + 1,) arrays
    counts : (CELLS, CELLS) array
        Rows by cell.
    share : float
        Of the cells that hold a row.
    holes : list of Hole
        The largest empty rectangles that do not overlap.
    """

    x: str
    y: str
    x_edges: np.ndarray
    y_edges: np.ndarray
    counts: np.ndarray
    share: float
    holes: list[Hole]


class Coverage(NamedTuple):
    """Maps of all pairs, and how many cells of the whole box (`LEVELS` of each input) hold a row."""

    names: list[str]
    box: dict[str, tuple[float, float]]
    pairs: list[PairMap]
    visited: int
    cells: int

    def statements(self, units: Mapping[str, Conversion]) -> list[str]:
        """Holes in words, the largest first; numbers in the units of `units`, or as they are."""
        found = []
        for pair in self.pairs:
            for hole in pair.holes:
                a, b = _range(pair.x, hole.x, units), _range(pair.y, hole.y, units)
                found.append((hole.share, f"no rows with {a} and {b} ({hole.share:.0%} of their map)"))
        return [text for _, text in sorted(found, key=lambda item: -item[0])]


def coverage(table: Table, names: Sequence[str], box: Mapping[str, tuple[float, float]] | None = None) -> Coverage:
    """How much of a box of inputs a table covers.

    Parameters
    ----------
    table : Table
    names : sequence of str
        Inputs.
    box : mapping from name to (low, high), optional
        The operating box; for what is left out, the range in the table. Rows outside it do not count.

    Raises
    ------
    InputError
        No rows, no names, or an empty range.
    """
    if not names or len(table) == 0:
        raise InputError("coverage needs inputs and rows")
    ranges = {}
    for name in names:
        values = table[name]
        low, high = (box or {}).get(name, (float(values.min()), float(values.max())))
        if not low <= high:
            raise InputError(f"box of {name!r} = ({low}, {high}): low must lie below high")
        ranges[name] = (low, high if high > low else low + max(1e-12, abs(low) * 1e-9))
    of = {name: _cells(table[name], ranges[name]) for name in names}
    pairs = [_pair(a, b, of) for a, b in combinations(names, 2)]
    place, inside = np.zeros(len(table), dtype=np.int64), np.ones(len(table), dtype=bool)
    counted = list(names)[:30]  # 4^30 still is a whole number of 64 bits
    for name in counted:
        low, high = ranges[name]
        cell = np.floor(LEVELS * (table[name] - low) / (high - low)).astype(np.int64)
        inside &= (table[name] >= low) & (table[name] <= high)
        place = LEVELS * place + np.clip(cell, 0, LEVELS - 1)
    return Coverage(list(names), ranges, pairs, len(np.unique(place[inside])), LEVELS ** len(counted))


def _range(name: str, ends: tuple[float, float], units: Mapping[str, Conversion]) -> str:
    low, high = (units[name].from_si(end) if name in units else end for end in ends)
    return f"{name} {low:.4g} to {high:.4g} {units[name].unit if name in units else ''}".rstrip()


def _cells(values: np.ndarray, ends: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Edges of cells, and the cell of each value; -1 outside of them."""
    edges = np.linspace(*ends, CELLS + 1)
    place = np.searchsorted(edges, values, side="right") - 1
    place[values == edges[-1]] = CELLS - 1
    place[place == CELLS] = -1
    return edges, place


def _pair(a: str, b: str, cells: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> PairMap:
    (x, first), (y, second) = cells[a], cells[b]
    place = (CELLS * first + second)[(first >= 0) & (second >= 0)]
    counts = np.bincount(place, minlength=CELLS * CELLS).reshape(CELLS, CELLS)
    return PairMap(a, b, x, y, counts, float(np.mean(counts > 0)), _holes(counts > 0, x, y))


def _holes(seen: np.ndarray, x: np.ndarray, y: np.ndarray) -> list[Hole]:
    """The largest rectangles without a visited cell, one after the other."""
    taken, n = seen.copy(), len(seen)
    low, high = np.triu_indices(n)
    found: list[Hole] = []
    for _ in range(_NAMED):
        total = np.zeros((n + 1, n + 1), dtype=np.int64)
        total[1:, 1:] = taken.cumsum(0).cumsum(1)
        rows = total[high + 1] - total[low]  # (pair of rows, n + 1)
        filled = rows[:, high + 1] - rows[:, low]  # (pair of rows, pair of columns)
        sides = high - low + 1
        area = np.where(filled == 0, np.outer(sides, sides), 0)
        i, j = np.unravel_index(int(np.argmax(area)), area.shape)
        share = float(area[i, j]) / seen.size
        if share < _LEAST:
            break
        found.append(Hole((float(x[low[i]]), float(x[high[i] + 1])), (float(y[low[j]]), float(y[high[j] + 1])), share))
        taken[low[i] : high[i] + 1, low[j] : high[j] + 1] = True
    return found
