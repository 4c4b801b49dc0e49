"""The kinds of node and their terms, in the order in which the thesis prints them (sec. 3.1).

`TERMS` is the single source: a term is the tuple of exponents of the node's inputs. Design matrices are built from it,
and the compiled evaluation and the generated C are tested against it. A linear node has one term for each input and no
constant. A sigmoid node, of which perceptrons are made, has a constant and one term for each input, and its value is
1 / (1 + exp(-sum)).
"""

import numpy as np

SINGLE, DOUBLE, TRIPLE, LINEAR, SIGMOID = range(5)
KIND_NAMES = ("single", "double", "triple", "linear", "sigmoid")
POLYNOMIALS = KIND_NAMES[:4]
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
    if kind in (LINEAR, SIGMOID):
        constant = ((0,) * n_inputs,) if kind == SIGMOID else ()
        return constant + tuple(tuple(int(i == j) for j in range(n_inputs)) for i in range(n_inputs))
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
        In column order.
    """
    exponents = terms(kind, x.shape[1])
    if kind == LINEAR:
        return x.copy(order="F")
    matrix = np.empty((len(x), len(exponents)), order="F")  # column by column, as it is filled
    powers = [x, x * x]
    powers.append(powers[0] * powers[1])
    for column, exponent in zip(matrix.T, exponents, strict=True):
        factors = [powers[e - 1][:, j] for j, e in enumerate(exponent) if e]
        column[:] = factors[0] if factors else 1.0
        for factor in factors[1:]:
            column *= factor
    return matrix


def without_idle_inputs(kind: int, coef: np.ndarray) -> tuple[int, list[int], np.ndarray]:
    """The smallest node that computes the same, when some terms have coefficient zero.

    Parameters
    ----------
    kind : int
    coef : (n_term,) array

    Returns
    -------
    kind : int
    kept : list of int
        Places of the inputs that it still reads; the first if none matters.
    coef : (n_term_left,) array
    """
    size = coef.size if kind == LINEAR else N_INPUTS[kind]
    exponents = terms(kind, size)
    kept = [j for j in range(size) if any(c and e[j] for c, e in zip(coef, exponents, strict=True))] or [0]
    if len(kept) == size:
        return kind, kept, coef
    smaller = LINEAR if kind == LINEAR else len(kept) - 1
    value = {tuple(e[j] for j in kept): c for c, e in zip(coef, exponents, strict=True) if c}
    return smaller, kept, np.array([value.get(e, 0.0) for e in terms(smaller, len(kept))])


def slopes(kind: int, x: np.ndarray, coef: np.ndarray) -> np.ndarray:
    """Derivatives of a node's output by each of its inputs.

    Parameters
    ----------
    kind : int
    x : (n_row, n_input) array
    coef : (n_term,) array

    Returns
    -------
    (n_row, n_input) array
    """
    powers = [np.ones_like(x), x, x * x]
    found = np.zeros_like(x)
    for c, exponents in zip(coef, terms(kind, x.shape[1]), strict=True):
        for j, exponent in enumerate(exponents):
            if exponent and c:
                column = np.full(len(x), c * exponent)
                for i, other in enumerate(exponents):
                    left = other - (i == j)
                    if left:
                        column = column * powers[left][:, i]
                found[:, j] += column
    return found
