"""Least squares of a candidate node from a triangular factor, block by block and without keeping rows.

The moments from which a node was scored give a first factor, in which nearly dependent columns have lost digits. The rows
times its inverse are nearly orthogonal, so that their products lose nothing, and these correct it: as exact as orthogonal
least squares, at the speed of matrix products.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dgemm
from scipy.linalg.lapack import dgelsy

from polydraulic._kernel import driver
from polydraulic.networks.growth.variables import fill_terms, steps_table

_PIVOT = 1e-11  # of its square: a column with a smaller rest is left as it is by the first factor
_RCOND = 1e-12  # of its length: a column with a smaller rest depends on the columns before it
_CLEAR = 1e-10  # of the largest pivot: where none is smaller, no terms depend on each other
_ROUNDING = 1e-14  # of the target's length: what a term explains that is smaller is rounding
# rows multiplied at a time, whose terms stay in the cache; no power of two, or columns would take each other's place there
ROWS = 1000
_SOLVED = 128  # rows solved at a time


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
    n = len(right) + 1
    square, work, first = np.empty(n), np.zeros((2, n, n)), np.zeros((n, n))
    _begin(gram, right, target_square, square, work, first)
    return TriangularFactor(square, first, np.zeros((n, n), order="F"))


def add_rows(
    triangle: TriangularFactor, kind: int, inputs: np.ndarray, values: np.ndarray, y: np.ndarray, root: np.ndarray
) -> None:
    """Take in a block of rows.

    Parameters
    ----------
    triangle : TriangularFactor
        Its total is changed in place.
    kind : int
        Of the node.
    inputs : (n_input,) array of int
        Variables that it reads.
    values : (n_variable, n_row) array
    y : (n_row,) array
        Target.
    root : (n_row,) array
        Of the weights.
    """
    steps, work = steps_table(kind, len(inputs)), np.empty((len(triangle.square), _SOLVED))
    for start in range(0, len(y), ROWS):
        columns = np.empty((len(triangle.square), min(ROWS, len(y) - start)))
        _nearly_orthogonal(values, y, root, inputs, steps, triangle.first, start, work, columns)
        dgemm(1.0, columns.T, columns.T, 1.0, triangle.total, trans_a=True, overwrite_c=True)


def factor_of(triangle: TriangularFactor) -> np.ndarray:
    """Triangular factor of the rows seen; a column that depends on those before it has an empty row.

    Returns
    -------
    (n_term + 1, n_term + 1) array
    """
    n = len(triangle.square)
    smallest, correction, found = np.empty(n), np.zeros((n, n)), np.empty((n, n))
    _correct(triangle.square, triangle.first, triangle.total, smallest, correction, found)
    return found


def solve_terms(factor: np.ndarray, terms: np.ndarray) -> LeastSquaresFit:
    """Least squares with some of the terms; of equally good solutions the smallest."""
    n, right = terms.size, factor[:, -1]
    coef = np.zeros(factor.shape[1] - 1)
    if n and not _solve(factor, terms, np.empty((n + 1, len(factor))), coef):
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
def _begin(
    gram: np.ndarray, right: np.ndarray, target_square: float, square: np.ndarray, work: np.ndarray, first: np.ndarray
) -> None:
    """Squares of the columns, and the first factor; `work` holds the products and the factor before its pivots are one."""
    n = right.shape[0]
    products, factor = work[0], work[1]
    for column in range(n):
        for row in range(column + 1):
            products[row, column] = gram[row, column]
        products[column, n] = right[column]
    products[n, n] = target_square
    for column in range(n + 1):
        square[column] = products[column, column]
        first[0, column] = _PIVOT * square[column]
    _cholesky(products, first[0], factor)
    for column in range(n + 1):
        pivot = factor[column, column] if factor[column, column] > 0.0 else 1.0
        for row in range(n + 1):
            first[row, column] = factor[column, row] / pivot if row > column else 0.0
        first[column, column] = 1.0


@driver
def _nearly_orthogonal(
    values: np.ndarray,
    y: np.ndarray,
    root: np.ndarray,
    inputs: np.ndarray,
    steps: np.ndarray,
    first: np.ndarray,
    start: int,
    work: np.ndarray,
    columns: np.ndarray,
) -> None:
    """Rows of [matrix, y] from `start` on, times the roots of their weights and the inverse of the first factor; one column per row."""
    n, n_row = columns.shape
    for low in range(0, n_row, work.shape[1]):
        high = min(low + work.shape[1], n_row)
        fill_terms(values, root, inputs, steps, start + low, start + high, work)
        target, r, t = work[n - 1], root[start + low : start + high], y[start + low : start + high]
        for i in range(high - low):
            target[i] = r[i] * t[i]
        for c in range(n):
            column, written = work[c], columns[c, low:high]
            whole = c - c % 4
            for k in range(0, whole, 4):  # four columns for each time that this one is read and written
                x0, x1, x2, x3 = work[k], work[k + 1], work[k + 2], work[k + 3]
                f0, f1, f2, f3 = first[c, k], first[c, k + 1], first[c, k + 2], first[c, k + 3]
                for i in range(high - low):
                    column[i] = (((column[i] - f0 * x0[i]) - f1 * x1[i]) - f2 * x2[i]) - f3 * x3[i]
            for k in range(whole, c):
                x, f = work[k], first[c, k]
                for i in range(high - low):
                    column[i] -= f * x[i]
            for i in range(high - low):
                written[i] = column[i]


@driver
def _correct(
    square: np.ndarray,
    first: np.ndarray,
    total: np.ndarray,
    smallest: np.ndarray,
    correction: np.ndarray,
    found: np.ndarray,
) -> None:
    """The factor of the nearly orthogonal rows times the first one."""
    n = square.shape[0]
    for column in range(n):
        smallest[column] = _RCOND * _RCOND * square[column]
    smallest[n - 1] = 0.0
    _cholesky(total, smallest, correction)
    for row in range(n):
        for column in range(n):
            entry = 0.0
            for k in range(row, column + 1):
                entry += correction[row, k] * first[column, k]
            found[row, column] = entry


@driver
def _solve(factor: np.ndarray, terms: np.ndarray, work: np.ndarray, coef: np.ndarray) -> bool:
    """Least squares by Householder's reflections; false where terms may depend on each other, which takes pivots."""
    n, m = terms.size, work.shape[1]
    for j in range(n + 1):
        column = terms[j] if j < n else factor.shape[1] - 1
        for i in range(m):
            work[j, i] = factor[i, column]
    smallest, largest = np.inf, 0.0
    for j in range(n):
        square = 0.0
        for i in range(j, m):
            square += work[j, i] * work[j, i]
        pivot = -np.sqrt(square) if work[j, j] > 0.0 else np.sqrt(square)
        smallest, largest = min(smallest, abs(pivot)), max(largest, abs(pivot))
        if not smallest > _CLEAR * largest:
            return False
        half = square - pivot * work[j, j]  # of the square of the reflection's direction
        work[j, j] -= pivot
        for k in range(j + 1, n + 1):
            share = 0.0
            for i in range(j, m):
                share += work[j, i] * work[k, i]
            share /= half
            for i in range(j, m):
                work[k, i] -= share * work[j, i]
        work[j, j] = pivot
    for j in range(n - 1, -1, -1):
        entry = work[n, j]
        for k in range(j + 1, n):
            entry -= work[k, j] * coef[terms[k]]
        coef[terms[j]] = entry / work[j, j]
    return True


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
