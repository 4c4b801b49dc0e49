"""Which of the networks that a growth went through to keep: the one that predicts rows best that it has not seen.

Of independent rows every row is left out, and the chosen network is refined. Of rows that depend on each other whole blocks are left
out. Few blocks judge less finely than many rows, and what a network does in a block that it has not seen depends on whether it is
refined: so each layer is refined before it is judged, until one is worse than the best before it, and of networks about as good
the smallest is kept.
"""

from collections.abc import Callable, Sequence
from math import inf, nan
from typing import NamedTuple

import numpy as np

from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.growth.unseen.leave_one_out import leave_blocks_out, leave_one_out
from polydraulic.networks.model.table import Node

Refine = Callable[[list[Node]], tuple[list[Node], float]]


class KeptLayer(NamedTuple):
    """A network, its fitting error, and the error on unseen rows of each network that was judged, NaN of the others."""

    nodes: list[Node]
    fse: float
    unseen: list[float]


def last_layer(grown: Sequence[list[Node]], fse: Sequence[float], refine: Refine | None) -> KeptLayer:
    """The last accepted layer, as the predicted squared error alone has it.

    Parameters
    ----------
    grown : sequence of list of Node
        Networks on normalized inputs, from the empty one on.
    fse : sequence of float
        Of each.
    refine : function of nodes to (nodes, fse), or None
    """
    unseen = [nan] * len(grown)
    if refine is None or not grown[-1]:
        return KeptLayer(grown[-1], fse[-1], unseen)
    return KeptLayer(*refine(grown[-1]), unseen)


def best_on_rows(
    grown: Sequence[list[Node]],
    fse: Sequence[float],
    refine: Refine | None,
    rows: TrainingRows,
    bounds: tuple[float, float],
    learnt: float | None = None,
) -> KeptLayer:
    """The layer with the smallest leave-one-out error; refined, if that lowers it. Arguments as `last_layer` and `leave_one_out`."""
    errors = [leave_one_out(nodes, rows, bounds, learnt=learnt) for nodes in grown]
    depth = int(np.argmin(errors))
    if refine is not None and grown[depth]:
        refined, its_fse = refine(grown[depth])
        if leave_one_out(refined, rows, bounds, learnt=learnt) <= errors[depth]:
            return KeptLayer(refined, its_fse, errors)
    return KeptLayer(grown[depth], fse[depth], errors)


def best_on_blocks(
    grown: Sequence[list[Node]],
    fse: Sequence[float],
    refine: Refine | None,
    blocks: TrainingRows,
    bounds: tuple[float, float],
) -> KeptLayer:
    """The smallest of the best networks on blocks left out; arguments as `last_layer`, `blocks` as `leave_blocks_out`."""
    tried: list[tuple[list[Node], float]] = []
    errors: list[np.ndarray] = []
    least = inf
    for nodes, own in zip(grown, fse, strict=True):
        found, error = (nodes, own), leave_blocks_out(nodes, blocks, bounds)
        if refine is not None and nodes:
            refined = refine(nodes)
            if (its := leave_blocks_out(refined[0], blocks, bounds)).sum() <= error.sum():
                found, error = refined, its
        tried.append(found)
        errors.append(error)
        if error.sum() > least:
            break
        least = error.sum()
    sums = [float(error.sum()) for error in errors]
    return KeptLayer(*tried[smallest_of_the_best(errors)], [*sums, *[nan] * (len(grown) - len(sums))])


def smallest_of_the_best(errors: Sequence[np.ndarray]) -> int:
    """The first network whose errors are not above those of the best one by more than the standard error of the difference.

    Parameters
    ----------
    errors : sequence of (n_block,) array
        Of each network, by block.
    """
    best = min(errors, key=np.sum)
    allowed = [float(np.std(error - best, ddof=1)) * best.size**0.5 for error in errors]
    return next(k for k, error in enumerate(errors) if np.sum(error - best) <= allowed[k])
