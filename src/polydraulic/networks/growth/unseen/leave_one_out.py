"""The error that a network would make on each row, had it not learnt from it.

To first order the answer follows from one fit: a row with leverage h, the share of its own target in its prediction, would miss
by its residual over 1 - h. Rows far from all others have a leverage near 1: they decide high powers alone, fit perfectly, and neither
the fitting error nor a penalty for coefficients shows that nothing supports the network there.

Of a log the neighbours of a row in time say the same as the row itself, so that whole blocks are left out together.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cholesky, eigh, solve_triangular
from scipy.linalg.blas import dsyrk

from polydraulic.networks.growth.derivatives import coefficients, forward, jacobian
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.model.table import Node

_RIDGE = 1e-10  # of the diagonal, against dependent coefficients
_MOST = 1.0 - 1e-9  # leverage
_LEFT = 1e-7  # of the curvature that it has with the block: with less, learning from the other rows would not get far along it


def leave_one_out(
    nodes: Sequence[Node], rows: TrainingRows, bounds: tuple[float, float], *, learnt: float | None = None
) -> float:
    """Mean squared error of predictions clamped to the bounds, each without its own row, in two passes.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs; empty for the constant zero.
    rows : TrainingRows
    bounds : (low, high)
        Of the normalized output.
    learnt : float, optional
        Weight of the rows that the network was learnt from, if `rows` are a sample of these.
    """
    free, coef = coefficients(nodes)
    n = len(coef)
    gram = np.zeros((n, n), order="F")
    if nodes:
        for x, _, w in rows:
            root = np.ones(len(x)) if w is None else np.sqrt(w)
            dsyrk(1.0, jacobian(free, coef, *forward(free, coef, x), root), 1.0, gram, trans=1, overwrite_c=True)
        gram *= (learnt or rows.scaling.weight) / rows.scaling.weight
        diagonal = np.diagonal(gram)
        factor = cholesky(gram + np.diag(_RIDGE * diagonal + 1e-12 * diagonal.max()))
    total = 0.0
    for x, y, w in rows:
        output, leverage = np.zeros(len(y)), np.zeros(len(y))
        if nodes:
            values, products = forward(free, coef, x)
            slope = jacobian(free, coef, values, products, np.ones(len(x)))
            seen = solve_triangular(factor, slope.T, trans=1, check_finite=False)
            output, leverage = values[-1], np.einsum("ij,ij->j", seen, seen)
        without = y - (y - output) / (1.0 - np.minimum(leverage, _MOST))
        error = np.clip(without, *bounds) - y
        total += float(error @ error if w is None else w @ (error * error))
    return total / rows.scaling.weight


def leave_blocks_out(nodes: Sequence[Node], blocks: TrainingRows, bounds: tuple[float, float]) -> np.ndarray:
    """Squared errors of predictions clamped to the bounds, each without the whole block of its row, to first order.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs; empty for a constant.
    blocks : TrainingRows
        Whose blocks are those that are left out; read twice.
    bounds : (low, high)
        Of the normalized output.

    Returns
    -------
    (n_block,) array
        Sum over the rows of each block, over the weight of all rows; their sum is the mean squared error.
    """
    total = blocks.scaling.weight
    grams: list[np.ndarray] = []
    for x, y, w in blocks:
        slope, _, root = _linear(nodes, x, y, w)
        grams.append((slope * root[:, None]).T @ (slope * root[:, None]))
    whole = np.sum(grams, axis=0)
    size = np.sqrt(np.maximum(np.diagonal(whole), np.finfo(np.float64).tiny))
    errors: list[float] = []
    for x, y, w in blocks:
        gram = grams[len(errors)]
        slope, output, root = _linear(nodes, x, y, w)
        # Newton's step of the other rows' squares: the fit has no gradient, so that theirs is what the block takes away
        curvature, direction = eigh((whole - gram) / np.outer(size, size))
        gradient = direction.T @ ((slope.T @ (root * root * (y - output))) / size)
        step = (direction @ (gradient / np.maximum(curvature, _LEFT))) / size
        error = root * (np.clip(output - slope @ step, *bounds) - y)
        errors.append(float(error @ error) / total)
    return np.array(errors)


def _linear(
    nodes: Sequence[Node], x: np.ndarray, y: np.ndarray, w: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slopes by the free coefficients, outputs, and roots of the weights; without nodes of the constant, which is zero."""
    root = np.ones(len(y)) if w is None else np.sqrt(w)
    if not nodes:
        return np.ones((len(y), 1)), np.zeros(len(y)), root
    free, coef = coefficients(nodes)
    values, products = forward(free, coef, x)
    return jacobian(free, coef, values, products, np.ones(len(y))), values[-1], root
