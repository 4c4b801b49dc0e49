"""Refinement over several steps: coefficients that predict well when the answers are read again.

Growth and `refine` look one step ahead, where errors of the slow part of a model hardly show. Here all coefficients move together
until windows that run by themselves fit best; derivatives are differences, since a run is a compiled loop and costs little.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from polydraulic.networks.dynamic.free_run import Loop, pieces, prepare_loop, run_windows
from polydraulic.networks.dynamic.spans import Span, rows_of
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.table import Node

_MAX_EVALUATIONS = 30  # of the derivatives
_MAX_ROWS = 20_000  # that a refinement looks at


def refine_over_steps(
    models: Sequence[Model], names: Sequence[str], signals: np.ndarray, spans: Sequence[Span], horizon: int
) -> list[Model]:
    """Lower the squared error of runs over `horizon` rows, in units of the outputs' standard deviations.

    Parameters
    ----------
    models : sequence of Model
        Dynamic, one per output.
    names : sequence of str
        Of the columns of `signals`.
    signals : (n_row, n_signal) array
        Inputs, then outputs.
    spans : sequence of (start, stop)
        Rows to answer.
    horizon : int
        Windows of this many rows begin from measured outputs. At most 20000 rows are used, in windows spread evenly.
    """
    from scipy.optimize import least_squares

    loop = prepare_loop(models, names)
    windows = pieces(spans, horizon)
    kept = max(1, _MAX_ROWS // horizon)
    if len(windows) > kept:
        windows = [windows[k] for k in np.linspace(0, len(windows) - 1, kept).astype(int)]
    rows = rows_of(windows)
    measured = signals[rows, signals.shape[1] - len(models) :]
    scale = spread(measured)
    free = np.nonzero(loop.table.coef)
    if not free[0].size:
        return list(models)

    def residuals(coef: np.ndarray) -> np.ndarray:
        loop.table.coef[free] = coef
        errors: np.ndarray = (run_windows(loop, signals, windows)[rows] - measured) / scale
        return errors.ravel()

    found = least_squares(residuals, loop.table.coef[free].copy(), x_scale="jac", max_nfev=_MAX_EVALUATIONS)
    loop.table.coef[free] = found.x
    return _with_coefficients(models, loop)


def spread(values: np.ndarray) -> np.ndarray:
    """Return the standard deviation of each column, 1 where a column is constant."""
    found = values.std(axis=0)
    return np.where(found > 0.0, found, 1.0)


def _with_coefficients(models: Sequence[Model], loop: Loop) -> list[Model]:
    """Models with the coefficients that now stand in the table."""
    row, found = 0, []
    for model in models:
        networks = []
        for network in model.networks:
            nodes = []
            for node in network.nodes:
                coef = tuple(loop.table.coef[row, : len(node.coef)].tolist())
                nodes.append(Node(node.kind, node.inputs, coef))
                row += 1
            networks.append(replace(network, nodes=tuple(nodes)))
        found.append(replace(model, networks=tuple(networks)))
    return found
