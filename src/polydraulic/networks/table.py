"""A fitted network as data, and its compiled evaluation.

`Network` is what synthesis returns and what a file holds; `NetworkTable` packs any number of networks into plain arrays, so
that one compiled function evaluates them all. A node reads only earlier slots: inputs first, then one slot a node, so that a
table cannot contain a loop.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.networks.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE

UNBOUNDED = float(np.finfo(np.float64).max)


@dataclass(frozen=True)
class Node:
    """One polynomial node; `inputs` are slots, `coef` stand in the order of `nodes.terms`."""

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
        Normalizers, one an input: (x - mean) / scale.
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

    def padded(name: str, fill: float) -> np.ndarray:
        table = np.full((len(networks), n_input), fill)
        for k, network in enumerate(networks):
            table[k, : network.n_inputs] = getattr(network, name)
        return table

    def scalars(name: str) -> np.ndarray:
        return np.array([getattr(network, name) for network in networks], dtype=np.float64)

    return NetworkTable(
        first=np.cumsum([0, *(len(network.nodes) for network in networks)]).astype(np.int64),
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
    """Scratch that `evaluate` needs: one slot an input and one a node."""
    return table.x_mean.shape[1] + int(np.max(np.diff(table.first)))


@kernel
def evaluate(table: NetworkTable, k: int, work: np.ndarray) -> float:
    """Output of network `k`.

    Parameters
    ----------
    table : NetworkTable
    k : int
    work : (work_size,) array
        The inputs stand in its first places and are overwritten.

    Notes
    -----
    Polynomials are nested (Horner); `export.c` writes the same nesting, so that both give the same bits.
    """
    n_input = table.x_mean.shape[1]
    for i in range(n_input):
        clamped = min(max(work[i], table.x_low[k, i]), table.x_high[k, i])
        work[i] = (clamped - table.x_mean[k, i]) * table.x_gain[k, i]
    y = 0.0
    slot = n_input
    for j in range(table.first[k], table.first[k + 1]):
        kind = table.kind[j]
        c = table.coef[j]
        a = work[table.inputs[j, 0]]
        if kind == SINGLE:
            y = c[0] + a * (c[1] + a * (c[2] + a * c[3]))
        elif kind == DOUBLE:
            b = work[table.inputs[j, 1]]
            y = c[0] + a * (c[1] + a * (c[3] + a * c[6]) + b * c[5]) + b * (c[2] + b * (c[4] + b * c[7]))
        elif kind == TRIPLE:
            b = work[table.inputs[j, 1]]
            d = work[table.inputs[j, 2]]
            y = (
                c[0]
                + a * (c[1] + a * (c[4] + a * c[11]) + b * (c[7] + d * c[10]) + d * c[8])
                + b * (c[2] + b * (c[5] + b * c[12]) + d * c[9])
                + d * (c[3] + d * (c[6] + d * c[13]))
            )
        elif kind == LINEAR:
            y = c[0] * a
            for i in range(1, table.n_in[j]):
                y = y + c[i] * work[table.inputs[j, i]]
        work[slot] = y
        slot = slot + 1
    return min(max(table.y_mean[k] + table.y_scale[k] * y, table.y_low[k]), table.y_high[k])


class Regions(NamedTuple):
    """Which network answers where: the cells of a grid of edges; cell intervals are closed on the right."""

    first: int  # network of the first cell
    axis: np.ndarray  # (n_edge,) int64: which input an edge cuts
    edge: np.ndarray  # (n_edge,) float64
    stride: np.ndarray  # (n_edge,) int64: how many cells the edge skips


@kernel
def region(regions: Regions, work: np.ndarray) -> int:
    """Network that answers for the inputs in the first places of `work`."""
    k = regions.first
    for i in range(regions.edge.shape[0]):
        k += regions.stride[i] if work[regions.axis[i]] > regions.edge[i] else 0
    return k


@driver
def evaluate_rows(table: NetworkTable, regions: Regions, X: np.ndarray, work: np.ndarray, y: np.ndarray) -> None:
    """Outputs for many rows: `X` (n_row, n_input) -> `y` (n_row,)."""
    for row in range(X.shape[0]):
        for i in range(X.shape[1]):
            work[i] = X[row, i]
        y[row] = evaluate(table, region(regions, work), work)
