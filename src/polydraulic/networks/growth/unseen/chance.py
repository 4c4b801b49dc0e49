"""How likely a search would have found as much in a target that none of its inputs has anything to do with.

A search over thousands of candidates finds something in any target. What one fixed network with K coefficients explains of N normal
targets that do not depend on its inputs, as a share of their variance, is distributed as Beta(K / 2, (N - 1 - K) / 2). Which network it is
was chosen, though: written down by a code in which no network is the beginning of another one, one that takes L (natural) digits has the
share e^-L in all, so that the probability that any network at all explains so much for its length is at most e^L times its own (the
union bound; the razor of Blumer, Ehrenfeucht, Haussler and Warmuth, 1987).
"""

from collections.abc import Sequence
from math import lgamma, log

import numpy as np
from scipy.special import betainc

from polydraulic.networks.growth.derivatives import coefficients, forward
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.model.nodes import KIND_NAMES, LINEAR, POLYNOMIALS
from polydraulic.networks.model.table import Node

_NORMAL = 3.0  # fourth moment of a normal target over the square of the second


def log_chance(nodes: Sequence[Node], n_input: int, n_row: float, error: float) -> float:
    """Logarithm of the largest probability that any network explains so much, given its length, of a target that depends on nothing.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network with one node at least.
    n_input : int
        How many inputs the search could choose from.
    n_row : float
        Independent rows, or their weight.
    error : float
        Mean squared error of the network, as a share of the target's variance.

    Returns
    -------
    float
        Above zero where the bound says nothing.
    """
    k = sum(int(np.count_nonzero(node.coef)) for node in nodes)
    left = n_row - 1.0 - k
    if left <= 0.0:
        return 0.0
    with np.errstate(divide="ignore"):
        return length(nodes, n_input) + float(np.log(betainc(0.5 * left, 0.5 * k, min(max(error, 0.0), 1.0))))


def length(nodes: Sequence[Node], n_input: int) -> float:
    """Natural digits that it takes to write down which network it is, its coefficients apart.

    How many nodes; of each how many inputs, which of those that are there and of the nodes before, how many terms, and which.
    """
    n_node = len(nodes)
    found = log(n_node * (n_node + 1.0))
    for place, node in enumerate(nodes):
        n_known, n_term = n_input + place, len(node.coef)
        found += log(len(POLYNOMIALS)) + _log_choices(n_known, len(node.inputs))
        if node.kind == LINEAR:  # has all its terms, and as many inputs as there are
            found += log(n_known)
        else:
            found += log(n_term) + _log_choices(n_term, int(np.count_nonzero(node.coef)))
    return found


def log_terms(kinds: Sequence[str], n_input: int) -> float:
    """Logarithm of the number of different terms that nodes of these kinds can choose from in a first layer; 1 at least."""
    single, double, triple = (name in kinds for name in KIND_NAMES[:3])
    number = 3 * n_input * (single or double or triple)
    number += n_input * (n_input - 1) // 2 * (double or triple) + n_input * (n_input - 1) * (n_input - 2) // 6 * triple
    return max(1.0, log(max(number, 1)))


def effective_rows(nodes: Sequence[Node], rows: TrainingRows) -> float:
    """As how many rows of a normal target the rows count: fewer where a few of them, far from all others, make up the agreement.

    For any target the variance of what a network and a target that do not depend on each other have in common is the mean of the product
    of their squares; that of a normal target which is explained altogether is three times smaller than it seems, and counts in full.

    Parameters
    ----------
    nodes : sequence of Node
        Of a network on normalized inputs.
    rows : TrainingRows

    Returns
    -------
    float
        At most the weight of the rows.
    """
    free, coef = coefficients(nodes)
    sums = np.zeros(6)
    for x, y, w in rows:
        output = forward(free, coef, x)[0][-1]
        weight = np.ones(len(y)) if w is None else w
        agreed = output * y
        sums += [
            weight @ output,
            weight @ output**2,
            weight @ y**2,
            weight @ agreed**2,
            weight @ (agreed * y),
            weight.sum(),
        ]
    mean, square, target, both, with_target, total = sums
    mean /= total
    # about the mean of the output; the target's is zero
    square -= total * mean * mean
    both += mean * (mean * target - 2.0 * with_target)
    return float(min(total, _NORMAL * square * target / both)) if both > 0.0 else total


def _log_choices(n: int, k: int) -> float:
    return lgamma(n + 1.0) - lgamma(k + 1.0) - lgamma(n - k + 1.0)
