"""The four kinds of node and their terms, in the order in which the thesis prints them (sec. 3.1).

`TERMS` is the single source: a term is the tuple of exponents of the node's inputs. Design matrices are built from it,
and the compiled evaluation and the generated C are tested against it. A linear node has one term for each input and no
constant, so that its terms depend on how many inputs it has.
"""

import numpy as np

SINGLE, DOUBLE, TRIPLE, LINEAR = range(4)
KIND_NAMES = ("single", "double", "triple", "linear")
N_INPUTS = (1, 2, 3)

TERMS: dict[int, tuple[tuple[int, ...], ...]] = {
    SINGLE: ((0,), (1,), (2,), (3,)),
    DOUBLE: ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1), (3, 0), (0, 3)),
    TRIPLE: (
        (0, 0, 0),
        (1, 0, 0),
        (0, 1, 0),
        (0, 0, 1),
        (2, 0, 0),
        (0, 2, 0),
        (0, 0, 2),
        (1, 1, 0),
        (1, 0, 1),
        (0, 1, 1),
        (1, 1, 1),
        (3, 0, 0),
        (0, 3, 0),
        (0, 0, 3),
    ),
}


def terms(kind: int, n_inputs: int) -> tuple[tuple[int, ...], ...]:
    """Exponents of a node's terms, one tuple a term."""
    if kind == LINEAR:
        return tuple(tuple(int(i == j) for j in range(n_inputs)) for i in range(n_inputs))
    return TERMS[kind]


def design(kind: int, x: np.ndarray) -> np.ndarray:
    """Design matrix of a node.

    Parameters
    ----------
    kind : int
    x : (n_row, n_input) array

    Returns
    -------
    (n_row, n_term) array
    """
    powers = [np.ones_like(x), x, x * x, x * x * x]
    columns = []
    for exponents in terms(kind, x.shape[1]):
        column = np.ones(len(x))
        for j, exponent in enumerate(exponents):
            if exponent:
                column = column * powers[exponent][:, j]
        columns.append(column)
    return np.column_stack(columns)


def least_squares(matrix: np.ndarray, y: np.ndarray, weight: np.ndarray | None) -> np.ndarray:
    """Coefficients of the (weighted) least-squares fit; of equally good ones the smallest."""
    if weight is not None:
        root = np.sqrt(weight)
        matrix, y = matrix * root[:, None], y * root
    return np.linalg.lstsq(matrix, y, rcond=1e-12)[0]
