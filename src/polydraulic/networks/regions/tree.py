"""A partition grown further, as a tree: the costliest region is cut in two, again and again."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.networks.model.partition import Partition, Split, networks_of


class Leaf(NamedTuple):
    """A region: its box (n_input, 2), what answers in it, what its error costs, and whether it stays as it is."""

    box: np.ndarray
    fitted: Any
    cost: float
    settled: bool


class Halves(NamedTuple):
    """The two leaves of a cut of input `axis` at `at`."""

    axis: int
    at: float
    below: Leaf
    above: Leaf


def grow_tree(
    partition: Partition, leaves: Sequence[Leaf], cut: Callable[[Leaf], Halves | None], max_regions: int
) -> tuple[Partition, list[Leaf]]:
    """Cut the costliest leaf that is not settled, until there is none or there are enough.

    Parameters
    ----------
    partition : Split or int
        What to start from.
    leaves : sequence of Leaf
        Its regions.
    cut : function of a leaf
        None to leave it as it is.
    max_regions : int

    Returns
    -------
    partition : Split or int
    leaves : list of Leaf
        One per region.
    """
    leaves = list(leaves)
    while len(leaves) < max_regions:
        waiting = [k for k, leaf in enumerate(leaves) if not leaf.settled]
        if not waiting:
            break
        k = max(waiting, key=lambda number: leaves[number].cost)
        halves = cut(leaves[k])
        if halves is None:
            leaves[k] = leaves[k]._replace(settled=True)
            continue
        partition = _replaced(partition, k, Split(halves.axis, halves.at, k, len(leaves)))
        leaves[k] = halves.below
        leaves.append(halves.above)
    order = networks_of(partition)
    return _renumbered(partition, {k: place for place, k in enumerate(order)}), [leaves[k] for k in order]


def box_halves(box: np.ndarray, axis: int, at: float) -> tuple[np.ndarray, np.ndarray]:
    """Boxes below and above a cut."""
    below, above = box.copy(), box.copy()
    below[axis, 1] = above[axis, 0] = at
    return below, above


def _replaced(partition: Partition, k: int, split: Split) -> Partition:
    if not isinstance(partition, Split):
        return split if partition == k else partition
    below, above = _replaced(partition.below, k, split), _replaced(partition.above, k, split)
    return Split(partition.axis, partition.at, below, above)


def _renumbered(partition: Partition, number: dict[int, int]) -> Partition:
    if not isinstance(partition, Split):
        return number[partition]
    below, above = _renumbered(partition.below, number), _renumbered(partition.above, number)
    return Split(partition.axis, partition.at, below, above)
