"""Where to cut a region in two: the threshold at which two small polynomials fit better than one.

The rows are sorted along each input and their normal equations summed in bins; sums from below and from above then give the
error of both fits for every bin border without another pass. The best border is refined among the rows around it.
"""

from itertools import combinations_with_replacement
from math import comb
from typing import NamedTuple

import numpy as np

_BINS = 32
_ZOOMS = 3
_MOST_TERMS = 40  # of the polynomial on each side
_RIDGE = 1e-10  # of the diagonal, against dependent columns


class Cut(NamedTuple):
    """A threshold and the squared error, summed over rows, that fits on both of its sides leave."""

    squares: float
    axis: int
    at: float


def best_cut(X: np.ndarray, y: np.ndarray, weight: np.ndarray, min_rows: float) -> Cut | None:
    """The most promising cut of some rows.

    Parameters
    ----------
    X : (n_row, n_input) array
    y : (n_row, n_output) array
        In comparable units.
    weight : (n_row,) array
    min_rows : float
        Rows, counted by their weights, that must remain on each side.

    Returns
    -------
    Cut or None
        None if no input can be cut with this many rows on both sides.
    """
    columns = np.column_stack([_terms(X), y]) * np.sqrt(weight)[:, None]
    cuts = [_cut_along(X[:, axis], axis, columns, weight, y.shape[1], min_rows) for axis in range(X.shape[1])]
    return min((cut for cut in cuts if cut is not None), default=None)


def _terms(X: np.ndarray) -> np.ndarray:
    """Polynomial terms of normalized inputs, of the highest degree up to three that stays small."""
    n = X.shape[1]
    degree = max([1, *(d for d in (2, 3) if comb(n + d, d) <= _MOST_TERMS)])
    spread = X.std(axis=0)
    v = (X - X.mean(axis=0)) / np.where(spread > 0.0, spread, 1.0)
    chosen = (c for d in range(degree + 1) for c in combinations_with_replacement(range(n), d))
    return np.column_stack([np.prod(v[:, list(c)], axis=1) for c in chosen])


def _cut_along(
    x: np.ndarray, axis: int, columns: np.ndarray, weight: np.ndarray, n_output: int, min_rows: float
) -> Cut | None:
    order = np.argsort(x, kind="stable")
    # a cut at i has weight below[i - 1] below it
    x, columns, below = (
        x[order],
        columns[order],
        np.cumsum(weight[order]),
    )
    low, high = min_rows, below[-1] - min_rows
    best: Cut | None = None
    for _ in range(_ZOOMS):
        borders = _borders(x, below, low, high)
        if not borders.size:
            break
        grams = np.array([part.T @ part for part in np.split(columns, borders)])  # one more than there are borders
        from_below, from_above = np.cumsum(grams, axis=0)[:-1], np.cumsum(grams[::-1], axis=0)[::-1][1:]
        squares = _rest(from_below, n_output) + _rest(from_above, n_output)
        place = int(np.argmin(squares))
        if best is None or squares[place] < best.squares:
            i = borders[place]
            best = Cut(float(squares[place]), axis, float(0.5 * x[i - 1] + 0.5 * x[i]))
        around = borders[max(place - 1, 0)], borders[min(place + 1, borders.size - 1)]
        low, high = (float(below[i - 1]) for i in around)
    return best


def _borders(x: np.ndarray, below: np.ndarray, low: float, high: float) -> np.ndarray:
    """Where to cut sorted rows so that the weight below lies between `low` and `high`; equal values stay together."""
    if low > high:
        return np.zeros(0, dtype=int)
    at = np.searchsorted(below, np.linspace(low, high, _BINS + 1) * (1.0 - 1e-12))
    at = np.unique(np.searchsorted(x, x[np.minimum(at, len(x) - 1)], side="right"))
    at = at[at < len(x)]
    return np.asarray(at[(below[at - 1] >= low) & (below[at - 1] <= high)])


def _rest(gram: np.ndarray, n_output: int) -> np.ndarray:
    """Squared error of the least-squares fit from the normal equations of (n_fit, n_term + n_output) columns."""
    inner, right = gram[:, :-n_output, :-n_output], gram[:, :-n_output, -n_output:]
    diagonal = np.einsum("kii->ki", inner)
    damped = inner + _RIDGE * np.eye(inner.shape[1]) * diagonal[:, None, :] + 1e-300 * np.eye(inner.shape[1])
    coef = np.linalg.solve(damped, right)
    total = np.einsum("kii->k", gram[:, -n_output:, -n_output:])
    return np.asarray(np.maximum(total - np.sum(coef * right, axis=(1, 2)), 0.0))
