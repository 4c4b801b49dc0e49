"""Which network answers where: a tree of splits, the one form of all regions.

A grid of given edges (thesis Table 3) becomes a balanced tree, a tree found in data is kept as it is. A value on an edge
belongs to the region below it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError


@dataclass(frozen=True)
class Split:
    """Rows with input `axis` above `at` go one way, the others the other; each way ends at the number of a network."""

    axis: int
    at: float
    below: "Partition"
    above: "Partition"


Partition = Split | int

EVERYWHERE: Partition = 0


def grid(edges: Mapping[int, Sequence[float]]) -> Partition:
    """Partition into the cells of a grid.

    Parameters
    ----------
    edges : mapping from input index to rising edges
        Cells are numbered with the last cut input varying fastest.
    """
    axes = list(edges.items())

    def cells(depth: int, first: int) -> Partition:
        if depth == len(axes):
            return first
        axis, cuts = axes[depth]
        stride = int(np.prod([len(other) + 1 for _, other in axes[depth + 1 :]], dtype=int))

        def between(low: int, high: int) -> Partition:
            if low == high:
                return cells(depth + 1, first + low * stride)
            middle = (low + high) // 2
            return Split(axis, float(cuts[middle]), between(low, middle), between(middle + 1, high))

        return between(0, len(cuts))

    return cells(0, 0)


def checked_edges(edges: Mapping[Any, Sequence[float]], names: Sequence[str]) -> dict[int, tuple[float, ...]]:
    """Edges by input index, from edges by index or name.

    Raises
    ------
    InputError
        If an input is unknown, or edges do not rise.
    """
    found: dict[int, tuple[float, ...]] = {}
    for key, cuts in edges.items():
        axis = list(names).index(key) if key in names else key
        if not isinstance(axis, int | np.integer) or not 0 <= axis < len(names):
            raise InputError(f"edges name the input {key!r}; the inputs are {list(names)}")
        values = np.asarray(cuts, dtype=np.float64)
        if values.ndim != 1 or not values.size or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
            raise InputError(f"edges of {key!r} = {cuts!r}: must be rising finite numbers")
        found[int(axis)] = tuple(values.tolist())
    return found


def networks_of(partition: Partition) -> list[int]:
    """Numbers of the networks, from below to above."""
    if isinstance(partition, Split):
        return networks_of(partition.below) + networks_of(partition.above)
    return [partition]


def region_of(partition: Partition, X: np.ndarray) -> np.ndarray:
    """Number of the network that answers for each row; the same rule as the compiled `choose`."""
    found = np.empty(len(X), dtype=np.int64)

    def descend(part: Partition, rows: np.ndarray) -> None:
        if isinstance(part, Split):
            above = X[rows, part.axis] > part.at
            descend(part.below, rows[~above])
            descend(part.above, rows[above])
        else:
            found[rows] = part

    descend(partition, np.arange(len(X)))
    return found


def region_boxes(partition: Partition, n_input: int) -> dict[int, np.ndarray]:
    """Box of each network (n_input, 2), infinite where nothing cuts, by its number."""
    found: dict[int, np.ndarray] = {}

    def descend(part: Partition, box: np.ndarray) -> None:
        if not isinstance(part, Split):
            found[part] = box
            return
        below, above = box.copy(), box.copy()
        below[part.axis, 1] = above[part.axis, 0] = part.at
        descend(part.below, below)
        descend(part.above, above)

    descend(partition, np.tile([-np.inf, np.inf], (n_input, 1)))
    return found


def box_name(box: np.ndarray, names: Sequence[str]) -> str:
    """A region in words: ``x in (0.188, 0.376]``."""
    parts = []
    for name, (low, high) in zip(names, box.tolist(), strict=True):
        if low > -np.inf or high < np.inf:
            parts.append(f"{name} in ({low:g}, {high:g}{']' if high < np.inf else ')'}")
    return " and ".join(parts) or "everywhere"


class Regions(NamedTuple):
    """A partition as plain arrays; a way is the number of a split, or below zero: -1 - k leads to network k."""

    root: int
    depth: int  # splits on the longest way
    axis: np.ndarray  # (n_split,) int64
    at: np.ndarray  # (n_split,) float64
    below: np.ndarray  # (n_split,) int64
    above: np.ndarray  # (n_split,) int64


def flatten(partition: Partition, first: int = 0) -> Regions:
    """Arrays of a partition whose network 0 has the number `first` in a table."""
    rows: list[list[float]] = []

    def descend(part: Partition) -> tuple[int, int]:
        """Way to `part`, and the splits on the longest way through it."""
        if not isinstance(part, Split):
            return -1 - (first + part), 0
        number = len(rows)
        rows.append([])
        (below, deep), (above, high) = descend(part.below), descend(part.above)
        rows[number] = [part.axis, part.at, below, above]
        return number, 1 + max(deep, high)

    root, depth = descend(partition)
    columns = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    axis, below, above = (columns[i].astype(np.int64) for i in (0, 2, 3))
    return Regions(root, depth, axis, columns[1].copy(), below, above)


@kernel
def choose(regions: Regions, x: np.ndarray) -> int:
    """Network that answers for the inputs in the first places of `x`."""
    way = regions.root
    for _ in range(regions.depth):
        if way < 0:
            break
        way = regions.above[way] if x[regions.axis[way]] > regions.at[way] else regions.below[way]
    return -1 - way
