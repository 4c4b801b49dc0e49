"""Networks drawn: normalizers, nodes by layer, unitizer; the history of the predicted squared error; borders of regions."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from polydraulic.display import as_drawn
from polydraulic.networks.model.history import GrowthStep
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.nodes import KIND_NAMES, terms
from polydraulic.networks.model.table import Network, Node

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW = 0.4  # in, what a row of nodes needs of a figure's height
_FARTHEST = 3.0  # rows between nodes of a layer that is shorter than others
_BOX = {"boxstyle": "round,pad=0.35", "linewidth": 0.8}


def draw_network(axis: "Axes", network: Network, inputs: Sequence[Variable], output: Variable) -> None:
    """Draw a network from its inputs (left) to its output (right); a line is as wide as its coefficients are large.

    Below the kind of a node stands how many coefficients it has; terms that were left out do not count.

    Parameters
    ----------
    axis : matplotlib Axes
    network : Network
    inputs : sequence of Variable
        Of the network's model.
    output : Variable
    """
    layer = layers_of(network)
    last = max(layer) + 1
    place: dict[int, tuple[float, float]] = {}
    for column in range(last):
        members = [slot for slot, at in enumerate(layer) if at == column]
        apart = min(_FARTHEST, node_rows(network) / len(members))
        for row, slot in enumerate(members):
            place[slot] = (column, apart * ((len(members) - 1) / 2 - row))
    used = {slot for node in network.nodes for slot in node.inputs}
    for number, node in enumerate(network.nodes):
        x, y = place[network.n_inputs + number]
        for slot, share in zip(node.inputs, _shares(node), strict=True):
            width = 0.5 + 3.0 * share
            axis.plot([place[slot][0], x], [place[slot][1], y], color="0.6", linewidth=width, zorder=1)
    for slot, (x, y) in place.items():
        if slot < network.n_inputs:
            text, color = f"N{slot + 1}\n{as_drawn(str(inputs[slot]))}", "#dbe9f6" if slot in used else "#eeeeee"
        else:
            node = network.nodes[slot - network.n_inputs]
            text, color = f"{KIND_NAMES[node.kind]}\n{sum(c != 0.0 for c in node.coef)}", "#fde8c8"
        axis.text(x, y, text, ha="center", va="center", fontsize=7, bbox={**_BOX, "facecolor": color}, zorder=2)
    if network.nodes:
        axis.plot(
            [place[len(layer) - 1][0], last],
            [place[len(layer) - 1][1], 0.0],
            color="0.6",
            linewidth=0.8,
            zorder=1,
        )
    text = f"U\n{as_drawn(str(output))}" if network.nodes else f"constant\n{network.y_mean:.4g}"
    axis.text(last, 0.0, text, ha="center", va="center", fontsize=7, bbox={**_BOX, "facecolor": "#dff0d8"}, zorder=2)
    heights = [y for _, y in place.values()]
    axis.set_xlim(-0.6, last + 0.6)
    axis.set_ylim(min(heights) - 0.8, max(heights) + 0.8)
    axis.set_axis_off()


def layers_of(network: Network) -> list[int]:
    """In which layer each input and node stands: 0 for inputs, and for a node one behind the last of those that it reads."""
    layer = [0] * network.n_inputs
    for node in network.nodes:
        layer.append(1 + max(layer[slot] for slot in node.inputs))
    return layer


def node_rows(network: Network) -> int:
    """How many nodes, or inputs, stand above each other in the drawing of a network."""
    layer = layers_of(network)
    return max(layer.count(column) for column in set(layer))


def _shares(node: Node) -> list[float]:
    """Share of each input in the sizes of a node's coefficients; variables are normalized, so that sizes compare."""
    exponents = terms(node.kind, len(node.inputs))
    sizes = [
        sum(abs(c) for c, e in zip(node.coef, exponents, strict=True) if e[place]) for place in range(len(node.inputs))
    ]
    return [size / (sum(sizes) or 1.0) for size in sizes]


def draw_history(axis: "Axes", history: Sequence[GrowthStep], unit: str) -> None:
    """PSE, FSE and penalty against the number of coefficients, one point per layer.

    Parameters
    ----------
    axis : matplotlib Axes
    history : sequence of GrowthStep
        ``history_`` of a regressor.
    unit : str
        Of the output.
    """
    k = [step.n_coefficients for step in history[1:]]
    for values, label, style in (
        ([step.pse for step in history[1:]], "PSE", "o-"),
        ([step.fse for step in history[1:]], "FSE", "s--"),
        ([step.penalty for step in history[1:]], "penalty KP", "^:"),
    ):
        axis.plot(k, values, style, label=label, linewidth=1.2)
    best = [step for step in history if step.accepted][-1]
    axis.axvline(best.n_coefficients, color="0.7", linewidth=0.8)
    axis.set_xlabel("coefficients K")
    axis.set_ylabel(f"squared error [({as_drawn(unit)})²]")
    axis.grid(alpha=0.3)
    axis.legend(fontsize="small")


def draw_regions(axis: "Axes", model: Model, *, x: int = 0, y: int = 1) -> None:
    """Draw the borders of a model's regions over two of its inputs, within its domain.

    Parameters
    ----------
    axis : matplotlib Axes
    model : Model
    x, y : int
        Places of the two inputs.
    """
    low, high = model.domain().T
    for box in model.region_boxes():
        (left, right), (bottom, top) = (np.clip(box[i], low[i], high[i]) for i in (x, y))
        corners = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
        axis.plot(*corners, color="k", linewidth=0.6)
    axis.set_xlim(low[x], high[x])
    axis.set_ylim(low[y], high[y])
    axis.set_xlabel(as_drawn(str(model.inputs[x])))
    axis.set_ylabel(as_drawn(str(model.inputs[y])))
