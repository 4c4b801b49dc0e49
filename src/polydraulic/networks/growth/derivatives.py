"""Values and exact derivatives of a network on a block of rows, by all of its coefficients that are not zero.

A term is a product of up to three variables: inputs, or outputs of earlier nodes. Everything stands in rows of memory, one for each variable
and for each term, along which compiled loops run.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.model.nodes import terms
from polydraulic.networks.model.table import Node


class FreeTerms(NamedTuple):
    """Terms of all nodes whose coefficients may move."""

    factors: np.ndarray  # (n_term, 3) int64: rows of the variables: 0 is one, then inputs, then nodes
    ends: np.ndarray  # (n_node + 1,) int64: where the terms of each node begin, and the last ones end


def free_terms(nodes: Sequence[Node], free: Sequence[np.ndarray]) -> FreeTerms:
    """Terms of nodes by their places `free` in each, in order."""
    factors = []
    for node, keep in zip(nodes, free, strict=True):
        exponents = terms(node.kind, len(node.inputs))
        for place in keep.tolist():
            read = [1 + slot for slot, e in zip(node.inputs, exponents[place], strict=True) for _ in range(e)]
            factors.append([*read, 0, 0, 0][:3])
    ends = np.cumsum([0, *(keep.size for keep in free)])
    return FreeTerms(np.array(factors, dtype=np.int64).reshape(-1, 3), ends)


def coefficients(nodes: Sequence[Node]) -> tuple[FreeTerms, np.ndarray]:
    """Terms whose coefficients are not zero, and these."""
    free = [np.flatnonzero(node.coef) for node in nodes]
    values = [np.array(node.coef)[keep] for node, keep in zip(nodes, free, strict=True)]
    return free_terms(nodes, free), np.concatenate([np.zeros(0), *values])


def forward(free: FreeTerms, coef: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of a network.

    Parameters
    ----------
    free : FreeTerms
    coef : (n_term,) array
    x : (n_row, n_input) array

    Returns
    -------
    values : (1 + n_input + n_node, n_row) array
        One, inputs, nodes; the last is the output.
    products : (n_term, n_row) array
        Of the factors of each term.
    """
    n_input = x.shape[1]
    values = np.empty((n_input + len(free.ends), len(x)))
    values[0], values[1 : 1 + n_input] = 1.0, x.T
    products = np.empty((len(coef), len(x)))
    with np.errstate(over="ignore", invalid="ignore"):  # as compiled: who asks looks whether all is finite
        _forward(free, coef, values, products)
    return values, products


def jacobian(
    free: FreeTerms, coef: np.ndarray, values: np.ndarray, products: np.ndarray, root: np.ndarray
) -> np.ndarray:
    """Derivatives of the output by the coefficients (n_row, n_term), each row times the root of its weight; they overwrite the products."""
    gain = np.zeros((len(free.ends) - 1, len(root)))
    gain[-1] = root
    with np.errstate(over="ignore", invalid="ignore"):
        _backward(free, coef, values, products, gain)
    return products.T


@driver
def _forward(free: FreeTerms, coef: np.ndarray, values: np.ndarray, products: np.ndarray) -> None:
    n_node, n_row = free.ends.shape[0] - 1, values.shape[1]
    first = values.shape[0] - n_node
    for node in range(n_node):
        total = values[first + node]
        for i in range(n_row):
            total[i] = 0.0
        for term in range(free.ends[node], free.ends[node + 1]):
            a, b, d = values[free.factors[term, 0]], values[free.factors[term, 1]], values[free.factors[term, 2]]
            product, c = products[term], coef[term]
            for i in range(n_row):
                product[i] = a[i] * b[i] * d[i]
                total[i] += c * product[i]


@driver
def _backward(free: FreeTerms, coef: np.ndarray, values: np.ndarray, products: np.ndarray, gain: np.ndarray) -> None:
    """What the output gains from each node, backwards, and from each term."""
    n_node, n_row = gain.shape
    first = values.shape[0] - n_node
    for node in range(n_node - 1, -1, -1):
        own = gain[node]
        for term in range(free.ends[node], free.ends[node + 1]):
            c = coef[term]
            for place in range(3):
                slot = free.factors[term, place]
                if slot >= first:
                    total = gain[slot - first]
                    a, b = values[free.factors[term, (place + 1) % 3]], values[free.factors[term, (place + 2) % 3]]
                    for i in range(n_row):
                        total[i] += c * own[i] * a[i] * b[i]
            product = products[term]
            for i in range(n_row):
                product[i] *= own[i]
