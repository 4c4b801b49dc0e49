"""The networks of a model as tables in ONNX: each row gathers the numbers of the network that answers for it.

Nodes stand one behind the other, the first of all networks, then the second, and so on. A polynomial of fewer inputs is one of more with
zeros, which adds nothing, so that values are those of each network alone. The graph grows with the nodes of the longest network, not
with the number of networks.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.export.c.network import bounded, nested
from polydraulic.export.onnx.graph import Graph, GraphValue
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, RAMP, SIGMOID, SINGLE, TRIPLE, terms
from polydraulic.networks.model.partition import flatten
from polydraulic.networks.model.slopes import domain_gain
from polydraulic.networks.model.table import Network, Node, used_slots

_POLYNOMIALS = (SINGLE, DOUBLE, TRIPLE)
_NOTHING = Node(SINGLE, (0,), (0.0,) * 4)  # where a network has no more nodes
_SLOTS = ("a", "b", "d")


def answer_of_tables(graph: Graph, model: Model, columns: Sequence[str]) -> tuple[str, str]:
    """Output of a model with regions, and how far inputs lie outside of the domain of the network that answers.

    Parameters
    ----------
    graph : Graph
    model : Model
    columns : sequence of str
        Its inputs, (rows, 1) each.
    """
    rows = _Rows(graph, _region(graph, model, columns))
    networks = model.networks
    low, high = (np.array([getattr(n, end) for n in networks]) for end in ("x_low", "x_high"))
    share = domain_gain(low, high)
    slots, far = [], [graph.number(0.0)]
    for i, column in enumerate(columns):
        x, ends = GraphValue(graph, column), (rows.number(low[:, i]), rows.number(high[:, i]))
        width = rows.number(share[:, i])
        far += [((ends[0] - x) * width).name, ((x - ends[1]) * width).name]
        mean, gain = rows.number([n.x_mean[i] for n in networks]), rows.number([1.0 / n.x_scale[i] for n in networks])
        slots.append((x.between(*ends) - mean) * gain)
    used = [[_renumbered(n, k) for k in used_slots(n)[1]] for n in networks]
    for j in range(max(map(len, used))):
        slots.append(_node(rows, slots, [nodes[j] if j < len(nodes) else _NOTHING for nodes in used]))
    last = rows.slot(slots, [len(columns) + len(nodes) - 1 if nodes else 0 for nodes in used])
    scale = rows.number([n.y_scale if nodes else 0.0 for n, nodes in zip(networks, used, strict=True)])
    y = rows.number([n.y_mean for n in networks]) + scale * last
    if any(map(bounded, networks)):
        y = y.between(rows.number([n.y_low for n in networks]), rows.number([n.y_high for n in networks]))
    return y.name, graph.op("Max", *far)


class _Rows:
    """What each row gathers from tables of one value for each network."""

    def __init__(self, graph: Graph, region: str) -> None:
        self.graph, self.region = graph, region

    def number(self, values: Any) -> GraphValue:
        largest = float(np.finfo(self.graph.dtype).max)
        held = np.clip(np.asarray(values, dtype=np.float64), -largest, largest).astype(self.graph.dtype)
        return GraphValue(self.graph, self._gathered(held))

    def slot(self, slots: Sequence[GraphValue], places: Sequence[int]) -> GraphValue:
        """The slot whose number each network has in `places`."""
        graph = self.graph
        if len(set(places)) == 1:
            return slots[places[0]]
        side_by_side = graph.op("Concat", *(slot.name for slot in slots), axis=1)
        index = self._gathered(np.array(places, dtype=np.int64))
        return GraphValue(graph, graph.op("GatherElements", side_by_side, index, axis=1))

    def where(self, chosen: Sequence[bool], one: GraphValue, other: GraphValue) -> GraphValue:
        return GraphValue(self.graph, self.graph.op("Where", self._gathered(np.array(chosen)), one.name, other.name))

    def _gathered(self, values: np.ndarray) -> str:
        return self.graph.op("Gather", self.graph.constant(values), self.region, axis=0)


def _region(graph: Graph, model: Model, columns: Sequence[str]) -> str:
    """GraphValue (rows, 1) of the network that answers: down the tree, where networks follow the splits and lead to themselves."""
    tree = flatten(model.partition)
    n, networks = tree.axis.size, np.arange(len(model.networks))
    below, above = (
        np.concatenate([np.where(way < 0, n - 1 - way, way), n + networks]) for way in (tree.below, tree.above)
    )
    axis, at = (np.concatenate([part, np.zeros(networks.size, dtype=part.dtype)]) for part in (tree.axis, tree.at))
    side_by_side = graph.op("Concat", *columns, axis=1)
    tables = [graph.constant(table) for table in (axis, at.astype(graph.dtype), below, above)]
    root = int(tree.root)
    is_above = graph.op("Greater", columns[int(axis[root])], graph.number(float(at[root])))
    way = graph.op("Where", is_above, *(graph.constant(np.array(int(side[root]))) for side in (above, below)))
    for _ in range(tree.depth - 1):
        axes, edge, down, up = (graph.op("Gather", table, way, axis=0) for table in tables)
        is_above = graph.op("Greater", graph.op("GatherElements", side_by_side, axes, axis=1), edge)
        way = graph.op("Where", is_above, up, down)
    return graph.op("Sub", way, graph.constant(np.array(n)))


def _renumbered(network: Network, k: int) -> Node:
    """Node `k` with the slots that it reads counted without nodes that nobody reads."""
    n, used = network.n_inputs, used_slots(network)[1]
    node = network.nodes[k]
    return Node(node.kind, tuple(s if s < n else n + used.index(s - n) for s in node.inputs), node.coef)


def _node(rows: _Rows, slots: Sequence[GraphValue], nodes: Sequence[Node]) -> GraphValue:
    """Values of one node of each network."""
    found: GraphValue | None = None
    polynomials = [node if node.kind in _POLYNOMIALS else _NOTHING for node in nodes]
    if any(node.coef != _NOTHING.coef for node in polynomials):
        kind = max(node.kind for node in polynomials)
        exponents = terms(kind, kind + 1)
        coef = np.zeros((len(nodes), len(exponents)))
        for row, node in zip(coef, polynomials, strict=True):
            for c, powers in zip(node.coef, terms(node.kind, node.kind + 1), strict=True):
                row[exponents.index(powers + (0,) * (kind - node.kind))] = c
        names = {f"c{i}": rows.number(column) for i, column in enumerate(coef.T)}
        read = {name: rows.slot(slots, _places(polynomials, i)) for i, name in enumerate(_SLOTS[: kind + 1])}
        # the text of a node holds the names of its coefficients and slots
        found = eval(nested(kind, list(names), list(read)), {"__builtins__": {}}, {**names, **read})
    for kind in (LINEAR, SIGMOID, RAMP):
        if any(node.kind == kind for node in nodes):
            value = _sum(rows, slots, [node if node.kind == kind else None for node in nodes])
            value = value.sigmoid() if kind == SIGMOID else value.ramp() if kind == RAMP else value
            found = value if found is None else rows.where([node.kind == kind for node in nodes], value, found)
    return found if found is not None else rows.number([0.0] * len(nodes))


def _sum(rows: _Rows, slots: Sequence[GraphValue], nodes: Sequence[Node | None]) -> GraphValue:
    """A constant, which linear nodes have not, and the terms of the inputs in their order."""
    size = max(len(node.inputs) for node in nodes if node)
    coef, reads = np.zeros((len(nodes), 1 + size)), np.zeros((len(nodes), size), dtype=np.int64)
    for k, node in enumerate(nodes):
        if node:
            first = 1 if node.kind == LINEAR else 0
            coef[k, first : first + len(node.coef)] = node.coef
            reads[k, : len(node.inputs)] = node.inputs
    total = rows.number(coef[:, 0])
    for i in range(size):
        total = total + rows.number(coef[:, 1 + i]) * rows.slot(slots, reads[:, i].tolist())
    return total


def _places(nodes: Sequence[Node], i: int) -> list[int]:
    """The slots that nodes read as their input `i`; the first where they have none."""
    return [node.inputs[i] if i < len(node.inputs) else 0 for node in nodes]
