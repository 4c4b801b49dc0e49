"""Refinement: all coefficients of a grown network together, by Levenberg-Marquardt with exact derivatives.

Growth fits each node to the target with the nodes before it fixed; together they can do better. The loss knows the
output's bounds: a row whose target lies on a bound is satisfied by any output beyond it.
"""

from collections.abc import Callable, Sequence
from math import inf

import numpy as np
from scipy.linalg.blas import dsyrk

from polydraulic._kernel import driver
from polydraulic.networks.growth.derivatives import FreeTerms, coefficients, forward, jacobian
from polydraulic.networks.growth.levenberg_marquardt import Damping, Equations, lower_loss
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.model.table import Node

_RULES = Damping(
    largest=1e12,
    smallest=1e-9,
    raise_by=2.0,
    raise_more=2.0,
    # less damping only where the linear model kept its promise: no step back after every step forward
    lower=lambda share: max(1.0 / 3.0, 1.0 - (2.0 * share - 1.0) ** 3),
    least_relative=1e-12,
    enough=1e-4,
    last_steps=3,
    perfect=1e-24,
)


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
        Mean squared error of the normalized output, clamped to its bounds; infinite for nodes that are not finite on the rows, as may be
        where they were refined on others.
    """
    free = [np.flatnonzero(node.coef) for node in nodes]
    moving, coef = coefficients(nodes)
    here = _normal(moving, coef, rows, bounds, np.inf)
    if here is None:
        return list(nodes), inf
    found, there = lower_loss(
        coef,
        here,
        lambda coef, limit: _normal(moving, coef, rows, bounds, limit),
        _RULES,
        max_attempts=max_iterations,
        watch=watch,
    )
    return _with(nodes, free, found), there.loss


def _with(nodes: Sequence[Node], free: list[np.ndarray], coef: np.ndarray) -> list[Node]:
    """Nodes with new values of the free coefficients."""
    found, start = [], 0
    for node, keep in zip(nodes, free, strict=True):
        values = np.zeros(len(node.coef))
        values[keep] = coef[start : start + keep.size]
        start += keep.size
        found.append(Node(node.kind, node.inputs, tuple(values.tolist())))
    return found


def _normal(
    free: FreeTerms, coef: np.ndarray, rows: TrainingRows, bounds: tuple[float, float], limit: float
) -> Equations | None:
    """Equations at some coefficients; None as soon as it is clear that the loss is not below the limit, or no number."""
    n, low, high = coef.size, *bounds
    weight = rows.scaling.weight
    gram, gradient, loss = np.zeros((n, n), order="F"), np.zeros(n), 0.0
    for x, y, w in rows:
        values, products = forward(free, coef, x)
        residual, root = np.empty(len(y)), np.ones(len(y)) if w is None else np.sqrt(w)
        loss += _residuals(values[-1], y, low, high, residual, root) / weight
        if not loss < limit:
            return None
        slope = jacobian(free, coef, values, products, root)
        dsyrk(1.0, slope, 1.0, gram, trans=1, overwrite_c=True)
        gradient += residual @ slope
    gram /= weight
    return Equations(gram + np.triu(gram, 1).T, gradient / weight, loss, loss)


@driver
def _residuals(
    output: np.ndarray, y: np.ndarray, low: float, high: float, residual: np.ndarray, root: np.ndarray
) -> float:
    """Sum of the squared residuals, which are written, times the roots of weights; both are zero where a bound is met."""
    total = 0.0
    for i in range(y.shape[0]):
        if (y[i] >= high and output[i] >= high) or (y[i] <= low and output[i] <= low):
            root[i] = 0.0
        residual[i] = root[i] * (output[i] - y[i]) if root[i] > 0.0 else 0.0
        total += residual[i] * residual[i]
    return total
