"""A small network with nodes of all polynomial kinds, and normalized rows for it."""

import numpy as np

from polydraulic.networks.growth.derivatives import coefficients, forward
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(0)
X = RNG.uniform(-1.0, 1.0, size=(300, 2))
X = (X - X.mean(axis=0)) / X.std(axis=0)
NODES = [
    Node(1, (0, 1), tuple(0.2 * RNG.normal(size=8))),
    Node(0, (2,), (0.1, 0.9, 0.0, -0.1)),
    Node(2, (3, 0, 2), tuple(0.2 * RNG.normal(size=14))),
    Node(3, (3, 4), (0.5, 0.7)),
]
FREE = [np.flatnonzero(node.coef) for node in NODES]


def output(nodes):
    return forward(*coefficients(nodes), X)[0][-1]
