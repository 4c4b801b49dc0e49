"""The kinds of node and their terms, in the order in which the thesis prints them (sec. 3.1).

`TERMS` is the single source: a term is the tuple of exponents of the node's inputs. Design matrices are built from it,
and the compiled evaluation and the generated C are tested against it. A linear node has one term for each input and no
constant. A sigmoid node, of which perceptrons are made, has a constant and one term for each input, and its value is
1 / (1 + exp(-sum)). A ramp has the same terms; its value is the sum where that is between 0 and 1, else the nearer of the two:
the edge of a dead zone, and where a valve is open.
"""

from functools import cache

import numpy as np

SINGLE, DOUBLE, TRIPLE, LINEAR, SIGMOID, RAMP = range(6)
KIND_NAMES = ("single", "double", "triple", "linear", "sigmoid", "ramp")
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
    """Exponents of a node's terms, one tuple per term."""
    if kind in (LINEAR, SIGMOID, RAMP):
        constant = () if kind == LINEAR else ((0,) * n_inputs,)
        return constant + tuple(tuple(int(i == j) for j in range(n_inputs)) for i in range(n_inputs))
    return TERMS[kind]


@cache
def term_steps(kind: int, n_inputs: int) -> tuple[tuple[int, int], ...]:
    """How each term but the constant follows from an earlier one (-1 for none): that term's place and a further input."""
    exponents = terms(kind, n_inputs)
    found = []
    for exponent in exponents:
        for j in reversed(range(n_inputs)):
            smaller = tuple(e - (i == j) for i, e in enumerate(exponent))
            if sum(exponent) > 1 and smaller in exponents:
                found.append((exponents.index(smaller), j))
                break
        else:
            found.append((-1, exponent.index(1) if any(exponent) else -1))
    return tuple(found)


def design(kind: int, x: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Design matrix of a node.

    Parameters
    ----------
    kind : int
    x : (n_row, n_input) array
    out : (n_row, n_term) array, optional
        Where to put it.

    Returns
    -------
    (n_row, n_term) array
        In column order, unless `out` is not.
    """
    steps = term_steps(kind, x.shape[1])
    matrix = np.empty((len(x), len(steps)), order="F") if out is None else out
    columns, inputs = list(matrix.T), list(x.T)
    for column, (earlier, j) in zip(columns, steps, strict=True):
        if earlier >= 0:
            np.multiply(columns[earlier], inputs[j], out=column)
        else:
            column[:] = inputs[j] if j >= 0 else 1.0
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
    read = 0
    for c, inputs in zip(coef.tolist(), _reads(kind, size), strict=True):
        read |= inputs if c else 0
    kept = [j for j in range(size) if read >> j & 1] or [0]
    if len(kept) == size:
        return kind, kept, coef
    smaller, exponents = LINEAR if kind == LINEAR else len(kept) - 1, terms(kind, size)
    value = {tuple(e[j] for j in kept): c for c, e in zip(coef, exponents, strict=True) if c}
    return smaller, kept, np.array([value.get(e, 0.0) for e in terms(smaller, len(kept))])


@cache
def _reads(kind: int, n_inputs: int) -> tuple[int, ...]:
    """Which inputs each term reads, as bits of a number."""
    return tuple(sum(1 << j for j, power in enumerate(exponent) if power) for exponent in terms(kind, n_inputs))


@cache
def _derivatives(kind: int) -> np.ndarray:
    """Derivatives of terms are terms: coefficients of the slopes, (n_input, n_term, n_term), from those of the node."""
    exponents = terms(kind, N_INPUTS[kind])
    found = np.zeros((N_INPUTS[kind], len(exponents), len(exponents)))
    for place, exponent in enumerate(exponents):
        for j, power in enumerate(exponent):
            if power:
                found[j, exponents.index(tuple(e - (i == j) for i, e in enumerate(exponent))), place] = power
    return found


def slopes(kind: int, x: np.ndarray, coef: np.ndarray, matrix: np.ndarray | None = None) -> np.ndarray:
    """Derivatives of a node's output by each of its inputs.

    Parameters
    ----------
    kind : int
    x : (n_row, n_input) array
    coef : (n_term,) array
    matrix : (n_row, n_term) array, optional
        The design matrix, where it is known.

    Returns
    -------
    (n_row, n_input) array
        In column order.
    """
    if kind == LINEAR:
        return np.repeat(coef[:, None], len(x), axis=1).T
    matrix = design(kind, x) if matrix is None else matrix
    return ((_derivatives(kind) @ coef) @ matrix.T).T
