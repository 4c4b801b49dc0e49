"""Least squares of a candidate node from a triangular factor that is updated block by block.

Stacking a block under the factor of the rows before it and taking the QR factor again keeps all that least squares
needs, at the accuracy of orthogonal least squares and without keeping rows.
"""

from typing import NamedTuple

import numpy as np

_RCOND = 1e-12


class Fit(NamedTuple):
    """Coefficients, zero where a term was left out, and the sum of squared residuals."""

    coef: np.ndarray
    squares: float


def grow(factor: np.ndarray | None, matrix: np.ndarray, y: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Triangular factor of [matrix, y] with the rows of one more block, each times the root of its weight."""
    block = np.column_stack([matrix, y]) * np.sqrt(weight)[:, None]
    return np.asarray(np.linalg.qr(block if factor is None else np.vstack([factor, block]), mode="r"))


def solve(factor: np.ndarray, terms: np.ndarray) -> Fit:
    """Least squares with some of the terms; of equally good solutions the smallest."""
    coef = np.zeros(factor.shape[1] - 1)
    right = factor[:, -1]
    if terms.size:
        coef[terms] = np.linalg.lstsq(factor[:, terms], right, rcond=_RCOND)[0]
    rest = right - factor[:, :-1] @ coef
    return Fit(coef, float(rest @ rest))


def carve(factor: np.ndarray, price: float) -> Fit:
    """Leave out terms, the least useful first, while each costs more than it explains.

    Parameters
    ----------
    factor : (n_term + 1, n_term + 1) array
        From `grow`.
    price : float
        What a coefficient must lower the sum of squared residuals by to stay.
    """
    terms = np.arange(factor.shape[1] - 1)
    best = solve(factor, terms)
    while terms.size > 1:  # ends: a term fewer each time
        tries = [solve(factor, np.delete(terms, k)) for k in _least_useful(factor, terms, best)]
        cheapest = min(tries, key=lambda fit: fit.squares)
        if cheapest.squares - best.squares >= price:
            return best
        best, terms = cheapest, np.flatnonzero(cheapest.coef)
    return best


def _least_useful(factor: np.ndarray, terms: np.ndarray, fit: Fit) -> list[int]:
    """Places of the few terms whose loss, estimated one at a time, is smallest."""
    inverse = np.linalg.pinv(factor[:, terms], rcond=_RCOND)
    spread = np.einsum("ij,ij->i", inverse, inverse)
    loss = fit.coef[terms] ** 2 / np.maximum(spread, 1e-300)
    return np.argsort(loss)[:2].tolist()
