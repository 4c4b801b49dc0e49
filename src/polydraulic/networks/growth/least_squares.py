"""Least squares of a candidate node from a triangular factor, block by block and without keeping rows.

The moments from which a node was scored give a first factor, in which nearly dependent columns have lost digits. The rows
times its inverse are nearly orthogonal, so that their products lose nothing, and these correct it: as exact as orthogonal
least squares, at the speed of matrix products.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dgelsy

from polydraulic._kernel import driver

_PIVOT = 1e-11  # of its square: a column with a smaller rest is left as it is by the first factor
_RCOND = 1e-12  # of its length: a column with a smaller rest depends on the columns before it
_ROUNDING = 1e-14  # of the target's length: what a term explains that is smaller is rounding


class LeastSquaresFit(NamedTuple):
    """Coefficients, zero where a term was left out, and the sum of squared residuals."""

    coef: np.ndarray
    squares: float


class TriangularFactor(NamedTuple):
    """What is known of [matrix, y], the target being the last of `n_term` + 1 columns."""

    square: np.ndarray  # (n_term + 1,): squares of the columns
    first: np.ndarray  # (n_term + 1, n_term + 1): the first factor transposed, each column with a pivot of one
    total: np.ndarray  # products of the rows times its inverse, upper half; in column order


def begin(gram: np.ndarray, right: np.ndarray, target_square: float) -> TriangularFactor:
    """First factor of a node, from its normal equations."""
    n = len(right)
    products = np.empty((n + 1, n + 1))
    products[:n, :n], products[:n, n], products[n, :n], products[n, n] = gram, right, right, target_square
    square, factor = np.diagonal(products).copy(), np.zeros(products.shape)
    _cholesky(products, _PIVOT * square, factor)
    pivots = np.diagonal(factor)
    first = np.ascontiguousarray(factor.T / np.where(pivots > 0.0, pivots, 1.0))
    np.fill_diagonal(first, 1.0)
    return TriangularFactor(square, first, np.zeros(products.shape, order="F"))


def add_rows(triangle: TriangularFactor, rows: np.ndarray, weight: np.ndarray | None) -> None:
    """Take in a block of rows.

    Parameters
    ----------
    triangle : TriangularFactor
        Its total is changed in place.
    rows : (n_row, n_term + 1) array
        Of [matrix, y], in column order; overwritten.
    weight : (n_row,) array or None
    """
    if weight is not None:
        rows *= np.sqrt(weight)[:, None]
    nearly_orthogonal = dtrsm(1.0, triangle.first.T, rows, side=1, diag=1, overwrite_b=True)
    dsyrk(1.0, nearly_orthogonal, 1.0, triangle.total, trans=1, overwrite_c=True)


def factor_of(triangle: TriangularFactor) -> np.ndarray:
    """Triangular factor of the rows seen; a column that depends on those before it has an empty row.

    Returns
    -------
    (n_term + 1, n_term + 1) array
    """
    smallest = _RCOND**2 * triangle.square
    smallest[-1] = 0.0
    correction = np.zeros(triangle.total.shape)
    _cholesky(triangle.total, smallest, correction)
    found: np.ndarray = correction @ triangle.first.T
    return found


def solve_terms(factor: np.ndarray, terms: np.ndarray) -> LeastSquaresFit:
    """Least squares with some of the terms; of equally good solutions the smallest."""
    n, right = terms.size, factor[:, -1]
    coef = np.zeros(factor.shape[1] - 1)
    if n:
        coef[terms] = dgelsy(factor[:, terms], right, np.zeros(n, dtype=np.int32), _RCOND, 64 * (n + 1))[1][:n]
    rest = right - factor[:, :-1] @ coef
    return LeastSquaresFit(coef, float(rest @ rest))


def carve(factor: np.ndarray, price: float) -> LeastSquaresFit:
    """Leave out terms that others replace, then the least useful first, while each costs more than it explains.

    Parameters
    ----------
    factor : (n_term + 1, n_term + 1) array
        From `factor_of`.
    price : float
        What a coefficient must lower the sum of squared residuals by to stay.
    """
    n = len(factor) - 1
    kept = np.zeros(n, dtype=np.bool_)
    rounding = _ROUNDING**2 * float(factor[:, n] @ factor[:, n])
    _carve(factor, max(price, rounding), np.zeros((n, n)), np.zeros(n), kept)
    return solve_terms(factor, np.flatnonzero(kept))


@driver
def _cholesky(products: np.ndarray, smallest: np.ndarray, factor: np.ndarray) -> None:
    """Upper factor of a matrix of products, of which the upper half is read; a pivot up to `smallest` empties its row."""
    for column in range(products.shape[0]):
        rest = products[column, column]
        for row in range(column):
            entry = products[row, column]
            for k in range(row):
                entry -= factor[k, row] * factor[k, column]
            entry = entry / factor[row, row] if factor[row, row] > 0.0 else 0.0
            factor[row, column] = entry
            rest -= entry * entry
        factor[column, column] = np.sqrt(rest) if rest > smallest[column] else 0.0


@driver
def _carve(factor: np.ndarray, price: float, dual: np.ndarray, coef: np.ndarray, kept: np.ndarray) -> None:
    """Which terms to keep.

    Row k of `dual`, the inverse of the factor, is the direction that only term k reaches: without the term the squared
    residuals rise by coef_k^2 / |dual_k|^2, and the other rows lose their share of that direction. Work on directions
    rather than on their products keeps nearly dependent terms apart.
    """
    n = coef.size
    n_kept = 0
    for column in range(n):
        kept[column] = factor[column, column] > 0.0
        n_kept += kept[column]
        if kept[column]:
            dual[column, column] = 1.0 / factor[column, column]
            for row in range(column - 1, -1, -1):
                if kept[row]:
                    entry = 0.0
                    for k in range(row + 1, column + 1):
                        entry -= factor[row, k] * dual[k, column]
                    dual[row, column] = entry / factor[row, row]
    for row in range(n):
        for k in range(n):
            coef[row] += dual[row, k] * factor[k, n]
    for _ in range(n_kept - 1):
        cheapest, least = -1, price
        for row in range(n):
            if kept[row]:
                length = 0.0
                for k in range(n):
                    length += dual[row, k] * dual[row, k]
                loss = coef[row] * coef[row] / length
                if loss < least:
                    cheapest, least = row, loss
        if cheapest < 0:
            break
        kept[cheapest] = False
        length = 0.0
        for k in range(n):
            length += dual[cheapest, k] * dual[cheapest, k]
        for row in range(n):
            if kept[row]:
                share = 0.0
                for k in range(n):
                    share += dual[row, k] * dual[cheapest, k]
                share /= length
                coef[row] -= share * coef[cheapest]
                for k in range(n):
                    dual[row, k] -= share * dual[cheapest, k]
