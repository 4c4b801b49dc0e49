"""Refinement: all coefficients of a grown network together, by Levenberg-Marquardt with exact derivatives.

Growth fits each node to the target with the nodes before it fixed; together they can do better. The loss knows the
output's bounds: a row whose target lies on a bound is satisfied by any output beyond it.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.linalg.blas import dsyrk

from polydraulic.networks.growth.derivatives import forward, jacobian
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.model.table import Node

_FIRST_DAMPING, _LARGEST_DAMPING = 1e-3, 1e12
_SMALLEST_DAMPING = 1e-9
_ENOUGH = 1e-4  # a step that lowers the loss by a smaller share is one of the last
_LAST_STEPS = 3


class _Normal(NamedTuple):
    """Gauss-Newton equations and the loss at one point."""

    gram: np.ndarray
    gradient: np.ndarray  # half of it
    loss: float


def refine(
    nodes: Sequence[Node],
    rows: TrainingRows,
    bounds: tuple[float, float],
    *,
    max_iterations: int,
    watch: Callable[[int, float], None] = lambda iteration, loss: None,
) -> tuple[list[Node], float]:
    """Lower the squared error over all coefficients that are not zero.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs.
    rows : TrainingRows
    bounds : (low, high)
        Of the normalized output.
    max_iterations : int
        Passes over the rows at most.
    watch : function (iteration, loss)

    Returns
    -------
    nodes : list of Node
    fse : float
        Mean squared error of the normalized output, clamped to its bounds.
    """
    free = [np.flatnonzero(node.coef) for node in nodes]
    coef = np.concatenate([np.array(node.coef)[keep] for node, keep in zip(nodes, free, strict=True)])
    here = _normal(nodes, free, coef, rows, bounds, np.inf)
    assert here is not None, "a grown network is finite on its own rows"
    damping, raise_by, slow = _FIRST_DAMPING, 2.0, 0
    for iteration in range(max_iterations):
        step, promised = _step(here, damping)
        there = _normal(nodes, free, coef - step, rows, bounds, here.loss) if promised > 0.0 else None
        if there is None:
            damping, raise_by = damping * raise_by, raise_by * 2.0
            if damping > _LARGEST_DAMPING:
                break
            continue
        gained = here.loss - there.loss
        # less damping only where the linear model kept its promise: no step back after every step forward
        damping = max(damping * max(1.0 / 3.0, 1.0 - (2.0 * gained / promised - 1.0) ** 3), _SMALLEST_DAMPING)
        raise_by = 2.0
        slow = slow + 1 if gained < _ENOUGH * here.loss else 0
        coef, here = coef - step, there
        watch(iteration, here.loss)
        if slow == _LAST_STEPS or here.loss <= 1e-24:
            break
    return _with(nodes, free, coef), here.loss


def _with(nodes: Sequence[Node], free: list[np.ndarray], coef: np.ndarray) -> list[Node]:
    """Nodes with new values of the free coefficients."""
    found, start = [], 0
    for node, keep in zip(nodes, free, strict=True):
        values = np.zeros(len(node.coef))
        values[keep] = coef[start : start + keep.size]
        start += keep.size
        found.append(Node(node.kind, node.inputs, tuple(values.tolist())))
    return found


def _step(here: _Normal, damping: float) -> tuple[np.ndarray, float]:
    """Step against the gradient, and what it would lower the loss by if the network were linear; 0 if there is none."""
    diagonal = np.diagonal(here.gram)
    added = damping * np.maximum(diagonal, 1e-12 * diagonal.max())
    try:
        step: np.ndarray = cho_solve(cho_factor(here.gram + np.diag(added)), here.gradient)
    except LinAlgError:
        return here.gradient, 0.0
    promised = float(step @ (added * step + here.gradient))
    return step, promised if np.isfinite(promised) else 0.0


def _normal(
    nodes: Sequence[Node],
    free: list[np.ndarray],
    coef: np.ndarray,
    rows: TrainingRows,
    bounds: tuple[float, float],
    limit: float,
) -> _Normal | None:
    """Equations at some coefficients; None as soon as it is clear that the loss is not below the limit, or no number."""
    moved = _with(nodes, free, coef)
    n, low, high = coef.size, *bounds
    weight = rows.scaling.weight
    gram, gradient, loss = np.zeros((n, n), order="F"), np.zeros(n), 0.0
    for x, y, w in rows:
        with np.errstate(over="ignore", invalid="ignore"):
            values, designs = forward(moved, x)
            output = values[-1]
            met = ((y >= high) & (output >= high)) | ((y <= low) & (output <= low))
            root = np.where(met, 0.0, 1.0 if w is None else np.sqrt(w))
            residual = root * (output - y)
            loss += float(residual @ residual) / weight
            if not loss < limit:
                return None
            slope = jacobian(moved, free, values, designs, root)
            dsyrk(1.0, slope, 1.0, gram, trans=1, overwrite_c=True)
            gradient += residual @ slope
    gram = gram / weight
    return _Normal(gram + np.triu(gram, 1).T, gradient / weight, loss)
