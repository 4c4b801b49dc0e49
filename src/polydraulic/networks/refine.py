"""Refinement: all coefficients of a grown network together, by Levenberg-Marquardt with exact derivatives.

Growth fits each node to the target with the nodes before it fixed; together they can do better. The loss knows the
output's bounds: a row whose target lies on a bound is satisfied by any output beyond it.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from polydraulic.networks.nodes import design, slopes
from polydraulic.networks.rows import Rows
from polydraulic.networks.table import Node

_FIRST_DAMPING, _LARGEST_DAMPING = 1e-3, 1e12
_SMALLEST_DAMPING = 1e-9
_ENOUGH = 1e-4  # a step that lowers the loss by a smaller share is one of the last
_LAST_STEPS = 3


class _Normal(NamedTuple):
    """Gauss-Newton equations and the loss at one point."""

    gram: np.ndarray
    gradient: np.ndarray
    loss: float


def refine(
    nodes: Sequence[Node],
    rows: Rows,
    bounds: tuple[float, float],
    *,
    max_iterations: int,
    progress: Callable[[int, float], None] = lambda iteration, loss: None,
) -> tuple[list[Node], float]:
    """Lower the squared error over all coefficients that are not zero.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs.
    rows : Rows
    bounds : (low, high)
        Of the normalized output.
    max_iterations : int
        Passes over the rows at most.
    progress : function (iteration, loss)

    Returns
    -------
    nodes : list of Node
    fse : float
        Mean squared error of the normalized output, clamped to its bounds.
    """
    free = [np.flatnonzero(node.coef) for node in nodes]
    coef = np.concatenate([np.array(node.coef)[keep] for node, keep in zip(nodes, free, strict=True)])
    here = _normal(nodes, free, coef, rows, bounds)
    assert here is not None, "a grown network is finite on its own rows"
    damping, slow = _FIRST_DAMPING, 0
    for iteration in range(max_iterations):
        step = _step(here, damping)
        there = None if step is None else _normal(nodes, free, coef - step, rows, bounds)
        if step is None or there is None or not there.loss < here.loss:
            damping *= 5.0
            if damping > _LARGEST_DAMPING:
                break
            continue
        slow = slow + 1 if here.loss - there.loss < _ENOUGH * here.loss else 0
        coef, here = coef - step, there
        damping = max(damping / 5.0, _SMALLEST_DAMPING)
        progress(iteration, here.loss)
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


def _step(here: _Normal, damping: float) -> np.ndarray | None:
    diagonal = np.diagonal(here.gram)
    damped = here.gram + damping * np.diag(np.maximum(diagonal, 1e-12 * diagonal.max()))
    try:
        step: np.ndarray = cho_solve(cho_factor(damped), here.gradient)
    except LinAlgError:
        return None
    return step if np.all(np.isfinite(step)) else None


def _normal(
    nodes: Sequence[Node], free: list[np.ndarray], coef: np.ndarray, rows: Rows, bounds: tuple[float, float]
) -> _Normal | None:
    """Equations at some coefficients; None where the output is no longer finite."""
    moved = _with(nodes, free, coef)
    n, low, high = coef.size, *bounds
    gram, gradient, loss = np.zeros((n, n)), np.zeros(n), 0.0
    for x, y, w in rows:
        with np.errstate(over="ignore", invalid="ignore"):
            output, jacobian = _jacobian(moved, free, x)
        if not np.all(np.isfinite(output)):
            return None
        met = ((y >= high) & (output >= high)) | ((y <= low) & (output <= low))
        residual = np.where(met, 0.0, output - y)
        jacobian[met] = 0.0
        w = np.ones(len(y)) if w is None else w
        weighted = jacobian * w[:, None]
        gram += weighted.T @ jacobian
        gradient += weighted.T @ residual
        loss += float(w @ (residual * residual))
    return _Normal(gram, gradient, loss / rows.scaling.weight) if np.isfinite(loss) else None


def _jacobian(nodes: Sequence[Node], free: list[np.ndarray], x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Output on a block of rows, and its derivatives by the free coefficients."""
    n_input, n_free = x.shape[1], [keep.size for keep in free]
    values = np.empty((len(x), n_input + len(nodes)), order="F")
    values[:, :n_input] = x
    designs = []
    for place, node in enumerate(nodes):
        matrix = design(node.kind, values[:, list(node.inputs)])
        designs.append(matrix)
        values[:, n_input + place] = matrix @ np.array(node.coef)
    # backwards: what the output gains from each slot
    gain = np.zeros((len(x), n_input + len(nodes)), order="F")
    gain[:, -1] = 1.0
    jacobian = np.empty((len(x), sum(n_free)), order="F")
    start = sum(n_free)
    for place in range(len(nodes) - 1, -1, -1):
        node, own = nodes[place], gain[:, n_input + place]
        start -= n_free[place]
        np.multiply(designs[place][:, free[place]], own[:, None], out=jacobian[:, start : start + n_free[place]])
        by_input = slopes(node.kind, values[:, list(node.inputs)], np.array(node.coef))
        for slot, slope in zip(node.inputs, by_input.T, strict=True):
            gain[:, slot] += own * slope
    return values[:, -1], jacobian
