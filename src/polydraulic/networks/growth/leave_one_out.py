"""The error that a network would make on each row, had it not learnt from it.

To first order the answer follows from one fit: a row with leverage h, the share of its own target in its prediction, would miss
by its residual over 1 - h. Rows far from all others have a leverage near 1: they decide high powers alone, fit perfectly, and neither
the fitting error nor a penalty for coefficients shows that nothing supports the network there.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.blas import dsyrk

from polydraulic.networks.growth.derivatives import forward, jacobian
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.model.table import Node

_RIDGE = 1e-10  # of the diagonal, against dependent coefficients
_MOST = 1.0 - 1e-9  # leverage


def leave_one_out(nodes: Sequence[Node], rows: TrainingRows, bounds: tuple[float, float]) -> float:
    """Mean squared error of predictions clamped to the bounds, each without its own row, in two passes.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs; empty for the constant zero.
    rows : TrainingRows
    bounds : (low, high)
        Of the normalized output.
    """
    free = [np.flatnonzero(node.coef) for node in nodes]
    n = sum(keep.size for keep in free)
    gram = np.zeros((n, n), order="F")
    if nodes:
        for x, _, w in rows:
            values, designs = forward(nodes, x)
            root = np.ones(len(x)) if w is None else np.sqrt(w)
            dsyrk(1.0, jacobian(nodes, free, values, designs, root), 1.0, gram, trans=1, overwrite_c=True)
        diagonal = np.diagonal(gram)
        factor = cho_factor(gram + np.diag(_RIDGE * diagonal + 1e-12 * diagonal.max()))
    total = 0.0
    for x, y, w in rows:
        output, leverage = np.zeros(len(y)), np.zeros(len(y))
        if nodes:
            values, designs = forward(nodes, x)
            slope = jacobian(nodes, free, values, designs, np.ones(len(x)))
            output, leverage = values[-1], np.einsum("ij,ji->i", slope, cho_solve(factor, slope.T))
        without = y - (y - output) / (1.0 - np.minimum(leverage, _MOST))
        error = np.clip(without, *bounds) - y
        total += float(error @ error if w is None else w @ (error * error))
    return total / rows.scaling.weight
