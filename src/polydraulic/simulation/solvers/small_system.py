"""Small systems of linear equations in arrays that a driver owns: factorised once, solved for many right sides.

Where the number of unknowns is a constant of the caller, its loops become straight lines.
"""

import numpy as np

from polydraulic._kernel import kernel


@kernel
def factorise_system(matrix: np.ndarray, order: np.ndarray, first: int, n: int) -> None:
    """Replace a matrix by its factors L and U in place, with one over its pivots in their places.

    Factors that are zero are skipped, so that a system whose first unknowns hang together in a few places costs what these cost.

    Parameters
    ----------
    matrix : (n, n) array
        The pivots of its first unknowns are their diagonal elements.
    order : (n,) array of int
        Filled: with which later row each row was exchanged.
    first : int
        From this unknown on the largest element is the pivot.
    n : int
    """
    for k in range(n):
        best = k
        if k >= first:
            for i in range(k + 1, n):
                best = i if abs(matrix[i, k]) > abs(matrix[best, k]) else best
        order[k] = best
        if best != k:
            for j in range(n):
                kept = matrix[k, j]
                matrix[k, j] = matrix[best, j]
                matrix[best, j] = kept
        over = 1.0 / matrix[k, k]
        matrix[k, k] = over
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                factor = matrix[i, k] * over
                matrix[i, k] = factor
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]


@kernel
def solve_system(matrix: np.ndarray, order: np.ndarray, right: np.ndarray, first: int, n: int) -> None:
    """Replace a right side by the solution, in place; all else is as in `factorise_system`, which has filled `matrix` and `order`."""
    for k in range(first, n):
        best = order[k]
        kept = right[k]
        right[k] = right[best]
        right[best] = kept
    for k in range(n):
        for i in range(k + 1, n):
            right[i] -= matrix[i, k] * right[k]
    for k in range(n - 1, -1, -1):
        total = right[k]
        for j in range(k + 1, n):
            total -= matrix[k, j] * right[j]
        right[k] = total * matrix[k, k]
