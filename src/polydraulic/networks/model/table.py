"""A fitted network as data, and its compiled evaluation.

`Network` is what training returns and what a file holds; `NetworkTable` packs any number of networks into plain arrays, so
that one compiled function evaluates them all. A node reads only earlier slots: inputs first, then one slot per node, so that a
table cannot contain a loop. A perceptron is a network too: sigmoid nodes over the inputs, and one node over them.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import exp
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SIGMOID, SINGLE, TRIPLE

UNBOUNDED = float(np.finfo(np.float64).max)


@dataclass(frozen=True)
class Node:
    """One node; `inputs` are slots, `coef` stand in the order of `nodes.terms`."""

    kind: int
    inputs: tuple[int, ...]
    coef: tuple[float, ...]


@dataclass(frozen=True)
class Network:
    """One network: normalizers, nodes, unitizer, domain.

    Attributes
    ----------
    nodes : tuple of Node
        The last one is the output; without nodes the network is the constant `y_mean`.
    x_mean, x_scale : tuple of float
        Normalizers, one per input: (x - mean) / scale.
    x_low, x_high : tuple of float
        Domain; inputs outside are moved to its border before anything else.
    y_mean, y_scale : float
        Unitizer: mean + scale * output.
    y_low, y_high : float
        Physical bounds; the output is clamped to them.
    """

    nodes: tuple[Node, ...]
    x_mean: tuple[float, ...]
    x_scale: tuple[float, ...]
    x_low: tuple[float, ...]
    x_high: tuple[float, ...]
    y_mean: float
    y_scale: float
    y_low: float = -UNBOUNDED
    y_high: float = UNBOUNDED

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return len(self.x_mean)

    @property
    def n_coefficients(self) -> int:
        """K, the number of coefficients of all nodes; terms that were left out have zeros and do not count."""
        return sum(c != 0.0 for node in self.nodes for c in node.coef)


class NetworkTable(NamedTuple):
    """Networks packed into arrays; network k has the nodes first[k]:first[k + 1]."""

    first: np.ndarray  # (n_network + 1,) int64
    n_read: np.ndarray  # (n_network,) int64: nodes read no inputs beyond so many; 0 for a constant
    kind: np.ndarray  # (n_node,) int64
    n_in: np.ndarray  # (n_node,) int64: how many of the input slots a node uses
    inputs: np.ndarray  # (n_node, width) int64 slots
    coef: np.ndarray  # (n_node, n_coef) float64, zero-padded
    x_mean: np.ndarray  # (n_network, n_input)
    x_gain: np.ndarray  # 1 / scale
    x_low: np.ndarray
    x_high: np.ndarray
    y_mean: np.ndarray  # (n_network,)
    y_scale: np.ndarray
    y_low: np.ndarray
    y_high: np.ndarray


def pack(networks: list[Network]) -> NetworkTable:
    """Pack networks; those with fewer inputs than others get idle ones."""
    n_input = max(network.n_inputs for network in networks)
    nodes = [node for network in networks for node in network.nodes]
    width = max([3, *(len(node.inputs) for node in nodes)])
    n_coef = max([14, *(len(node.coef) for node in nodes)])
    inputs = np.zeros((len(nodes), width), dtype=np.int64)
    coef = np.zeros((len(nodes), n_coef))
    row = 0
    for network in networks:
        shift = n_input - network.n_inputs
        for node in network.nodes:
            slots = [slot + shift if slot >= network.n_inputs else slot for slot in node.inputs]
            inputs[row, : len(slots)] = slots
            coef[row, : len(node.coef)] = node.coef
            row += 1

    n_read = [
        1 + max((slot for node in network.nodes for slot in node.inputs if slot < network.n_inputs), default=-1)
        for network in networks
    ]

    def padded(name: str, fill: float) -> np.ndarray:
        table = np.full((len(networks), n_input), fill)
        for k, network in enumerate(networks):
            table[k, : network.n_inputs] = getattr(network, name)
        return table

    def scalars(name: str) -> np.ndarray:
        return np.array([getattr(network, name) for network in networks], dtype=np.float64)

    return NetworkTable(
        first=np.cumsum([0, *(len(network.nodes) for network in networks)]).astype(np.int64),
        n_read=np.array(n_read, dtype=np.int64),
        kind=np.array([node.kind for node in nodes], dtype=np.int64),
        n_in=np.array([len(node.inputs) for node in nodes], dtype=np.int64),
        inputs=inputs,
        coef=coef,
        x_mean=padded("x_mean", 0.0),
        x_gain=1.0 / padded("x_scale", 1.0),
        x_low=padded("x_low", 0.0),
        x_high=padded("x_high", 0.0),
        y_mean=scalars("y_mean"),
        y_scale=scalars("y_scale"),
        y_low=scalars("y_low"),
        y_high=scalars("y_high"),
    )


def work_size(table: NetworkTable) -> int:
    """Scratch that `evaluate` needs: one slot per input and one per node."""
    return table.x_mean.shape[1] + int(np.max(np.diff(table.first)))


# Each kind of node is written once, nested (Horner): for one row here, for many in `rows_table`. `export.c` writes the
# same nesting, so that all give the same bits.


@kernel
def single(a: float, c0: float, c1: float, c2: float, c3: float) -> float:
    """Value of a Single."""
    return c0 + a * (c1 + a * (c2 + a * c3))


@kernel
def double(
    a: float, b: float, c0: float, c1: float, c2: float, c3: float, c4: float, c5: float, c6: float, c7: float
) -> float:
    """Value of a Double."""
    return c0 + a * (c1 + a * (c3 + a * c6) + b * c5) + b * (c2 + b * (c4 + b * c7))


@kernel
def triple(
    a: float, b: float, d: float, c0: float, c1: float, c2: float, c3: float, c4: float, c5: float, c6: float,
    c7: float, c8: float, c9: float, c10: float, c11: float, c12: float, c13: float,
) -> float:  # fmt: skip
    """Value of a Triple."""
    return (
        c0
        + a * (c1 + a * (c4 + a * c11) + b * (c7 + d * c10) + d * c8)
        + b * (c2 + b * (c5 + b * c12) + d * c9)
        + d * (c3 + d * (c6 + d * c13))
    )


@kernel
def sigmoid(h: float) -> float:
    """Value of a sigmoid node from the sum of its terms."""
    return 1.0 / (1.0 + exp(-h))


@kernel
def ramp(h: float) -> float:
    """Value of a ramp from the sum of its terms."""
    return min(max(h, 0.0), 1.0)


@kernel
def evaluate(table: NetworkTable, k: int, work: np.ndarray) -> float:
    """Output of network `k`.

    Parameters
    ----------
    table : NetworkTable
    k : int
    work : (work_size,) array
        The inputs stand in its first places and are overwritten.
    """
    n_input = table.x_mean.shape[1]
    for i in range(table.n_read[k]):
        clamped = min(max(work[i], table.x_low[k, i]), table.x_high[k, i])
        work[i] = (clamped - table.x_mean[k, i]) * table.x_gain[k, i]
    y = 0.0
    slot = n_input
    for j in range(table.first[k], table.first[k + 1]):
        kind = table.kind[j]
        c = table.coef[j]
        a = work[table.inputs[j, 0]]
        if kind == SINGLE:
            y = single(a, c[0], c[1], c[2], c[3])
        elif kind == DOUBLE:
            b = work[table.inputs[j, 1]]
            y = double(a, b, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7])
        elif kind == TRIPLE:
            b = work[table.inputs[j, 1]]
            d = work[table.inputs[j, 2]]
            y = triple(
                a, b, d, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12], c[13]
            )  # fmt: skip
        elif kind == LINEAR:
            y = c[0] * a
            for i in range(1, table.n_in[j]):
                y = y + c[i] * work[table.inputs[j, i]]
        else:
            y = c[0]
            for i in range(table.n_in[j]):
                y = y + c[i + 1] * work[table.inputs[j, i]]
            y = sigmoid(y) if kind == SIGMOID else ramp(y)
        work[slot] = y
        slot = slot + 1
    return min(max(table.y_mean[k] + table.y_scale[k] * y, table.y_low[k]), table.y_high[k])


def used_slots(network: Network) -> tuple[list[int], list[int]]:
    """Inputs, and nodes in order, on which the output depends."""
    n = network.n_inputs
    needed = {n + len(network.nodes) - 1} if network.nodes else set()
    for number in reversed(range(len(network.nodes))):
        if n + number in needed:
            needed.update(network.nodes[number].inputs)
    return [slot for slot in sorted(needed) if slot < n], [slot - n for slot in sorted(needed) if slot >= n]
