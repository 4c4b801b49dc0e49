"""Many rows through a table of networks, in blocks of lanes: the compiler turns each loop over lanes into vector instructions.

Rows are sorted by the network that answers for them; a block then runs node by node, each value a row of 64 lanes. The
bits are those of `table.evaluate`.
"""

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SIGMOID, SINGLE, TRIPLE
from polydraulic.networks.model.partition import Partition, networks_of, region_of
from polydraulic.networks.model.table import NetworkTable, double, ramp, sigmoid, single, triple, work_size

LANES = 64


def evaluate_rows(table: NetworkTable, partition: Partition, X: np.ndarray) -> np.ndarray:
    """Outputs for rows `X` (n_row, n_input) of the model whose networks are the table's; shape (n_row,)."""
    count, y = len(networks_of(partition)), np.empty(len(X))
    work = np.zeros((work_size(table), LANES))
    if count == 1:
        _evaluate_sorted(table, np.array([0, len(X)]), X, work, y)
        return y
    network = region_of(partition, X)
    order = np.argsort(network.astype(np.min_scalar_type(count)), kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(network, minlength=count))])
    in_order = np.empty(len(X))
    _evaluate_sorted(table, first, X[order], work, in_order)
    y[order] = in_order
    return y


@driver
def _evaluate_sorted(table: NetworkTable, first: np.ndarray, X: np.ndarray, work: np.ndarray, y: np.ndarray) -> None:
    """Rows first[k] to first[k + 1] through network k."""
    n_input = table.x_mean.shape[1]
    for k in range(first.shape[0] - 1):
        for start in range(first[k], first[k + 1], LANES):
            n = min(LANES, first[k + 1] - start)
            for i in range(table.n_read[k]):
                low, high = table.x_low[k, i], table.x_high[k, i]
                mean, gain = table.x_mean[k, i], table.x_gain[k, i]
                for lane in range(n):
                    work[i, lane] = X[start + lane, i]
                for lane in range(LANES):
                    work[i, lane] = (min(max(work[i, lane], low), high) - mean) * gain
            last = n_input
            for j in range(table.first[k], table.first[k + 1]):
                _node_lanes(table, j, work, last)
                last += 1
            last -= 1
            mean, scale, low, high = table.y_mean[k], table.y_scale[k], table.y_low[k], table.y_high[k]
            constant = table.first[k] == table.first[k + 1]
            for lane in range(n):
                value = 0.0 if constant else work[last, lane]
                y[start + lane] = min(max(mean + scale * value, low), high)


@kernel
def _node_lanes(table: NetworkTable, j: int, work: np.ndarray, slot: int) -> None:
    """Node `j` on all lanes. Coefficients are read first: the compiler cannot know that `work` does not hold them."""
    kind = table.kind[j]
    c = table.coef[j]
    ia = table.inputs[j, 0]
    c0, c1, c2, c3 = c[0], c[1], c[2], c[3]
    c4, c5, c6, c7 = c[4], c[5], c[6], c[7]
    if kind == SINGLE:
        for lane in range(LANES):
            work[slot, lane] = single(work[ia, lane], c0, c1, c2, c3)
    elif kind == DOUBLE:
        ib = table.inputs[j, 1]
        for lane in range(LANES):
            work[slot, lane] = double(work[ia, lane], work[ib, lane], c0, c1, c2, c3, c4, c5, c6, c7)
    elif kind == TRIPLE:
        ib, id_ = table.inputs[j, 1], table.inputs[j, 2]
        c8, c9, c10, c11, c12, c13 = c[8], c[9], c[10], c[11], c[12], c[13]
        for lane in range(LANES):
            a, b, d = work[ia, lane], work[ib, lane], work[id_, lane]
            work[slot, lane] = triple(a, b, d, c0, c1, c2, c3, c4, c5, c6, c7, c8, c9, c10, c11, c12, c13)
    elif kind == LINEAR:
        for lane in range(LANES):
            work[slot, lane] = c0 * work[ia, lane]
        for i in range(1, table.n_in[j]):
            _add_lanes(work, slot, table.inputs[j, i], c[i])
    else:
        for lane in range(LANES):
            work[slot, lane] = c0
        for i in range(table.n_in[j]):
            _add_lanes(work, slot, table.inputs[j, i], c[i + 1])
        if kind == SIGMOID:
            for lane in range(LANES):
                work[slot, lane] = sigmoid(work[slot, lane])
        else:
            for lane in range(LANES):
                work[slot, lane] = ramp(work[slot, lane])


@kernel
def _add_lanes(work: np.ndarray, slot: int, other: int, factor: float) -> None:
    for lane in range(LANES):
        work[slot, lane] = work[slot, lane] + factor * work[other, lane]
