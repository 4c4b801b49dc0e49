"""Values and exact derivatives of a network on a block of rows, by all of its coefficients that are not zero."""

from collections.abc import Sequence

import numpy as np

from polydraulic.networks.model.nodes import design, slopes
from polydraulic.networks.model.table import Node


def forward(nodes: Sequence[Node], x: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Inputs and nodes on a block of rows, one per row, and the design matrices of the nodes."""
    n_input = x.shape[1]
    values = np.empty((n_input + len(nodes), len(x)))
    values[:n_input] = x.T
    designs = []
    for place, node in enumerate(nodes):
        matrix = design(node.kind, values[list(node.inputs)].T)
        designs.append(matrix)
        np.dot(matrix, np.array(node.coef), out=values[n_input + place])
    return values, designs


def jacobian(
    nodes: Sequence[Node], free: list[np.ndarray], values: np.ndarray, designs: list[np.ndarray], root: np.ndarray
) -> np.ndarray:
    """Derivatives of the output by the free coefficients, each row times the root of its weight."""
    n_input, n_free = len(values) - len(nodes), [keep.size for keep in free]
    # backwards: what the output gains from each node
    gain = np.zeros((len(nodes), values.shape[1]))
    gain[-1] = root
    start = sum(n_free)
    found = np.empty((values.shape[1], start), order="F")
    for place in range(len(nodes) - 1, -1, -1):
        node, own = nodes[place], gain[place]
        start -= n_free[place]
        for column, term in enumerate(free[place].tolist(), start):
            np.multiply(designs[place][:, term], own, out=found[:, column])
        if max(node.inputs) >= n_input:
            by_input = slopes(node.kind, values[list(node.inputs)].T, np.array(node.coef), designs[place])
            for slot, slope in zip(node.inputs, by_input.T, strict=True):
                if slot >= n_input:
                    gain[slot - n_input] += own * slope
    return found
