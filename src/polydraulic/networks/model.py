"""A fitted model: one network, or one for each cell of a grid of edges, with names, units and domain.

This is what leaves training: it predicts, is written to a file, drawn, exported and put into a simulation, and knows
nothing of how it was fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.nodes import KIND_NAMES, terms
from polydraulic.networks.table import Network, NetworkTable, Regions, evaluate_rows, pack, work_size

Edges = dict[int, tuple[float, ...]]


@dataclass(frozen=True)
class Variable:
    """Name and unit of an input or output."""

    name: str
    unit: str = ""

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class Model:
    """Networks by region.

    Attributes
    ----------
    inputs : tuple of Variable
    output : Variable
    edges : dict from input index to rising edges
        Empty for a single network.
    networks : tuple of Network
        One a cell; the last cut input varies fastest.
    training : dict
        Summary of the fit: numbers and strings.
    """

    inputs: tuple[Variable, ...]
    output: Variable
    edges: Edges
    networks: tuple[Network, ...]
    training: dict[str, object] = field(default_factory=dict)

    def predict(self, X: np.ndarray) -> np.ndarray:
        """Outputs for inputs of shape (n_row, n_input); shape (n_row,).

        Raises
        ------
        InputError
            If the shape is wrong, or a value is not finite.
        """
        X = np.ascontiguousarray(X, dtype=np.float64)
        if X.ndim != 2 or X.shape[1] != len(self.inputs):
            raise InputError(f"X has shape {X.shape}; it must be (n_row, {len(self.inputs)})")
        if not np.all(np.isfinite(X)):
            row, column = np.argwhere(~np.isfinite(X))[0]
            raise InputError(f"{self.inputs[column].name} = {X[row, column]} in row {row}: must be finite")
        (regions,), table = pack_models([self])
        y = np.empty(len(X))
        evaluate_rows(table, regions, X, np.empty(work_size(table)), y)
        return y

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients of all networks."""
        return sum(network.n_coefficients for network in self.networks)

    def region_box(self, k: int) -> np.ndarray:
        """Box of inputs for which network `k` answers, infinite where nothing cuts; shape (n_input, 2)."""
        box = np.tile([-np.inf, np.inf], (len(self.inputs), 1))
        for axis, cuts in reversed(self.edges.items()):
            k, place = divmod(k, len(cuts) + 1)
            box[axis] = [cuts[place - 1] if place else -np.inf, cuts[place] if place < len(cuts) else np.inf]
        return box

    def domain(self) -> np.ndarray:
        """Smallest box around the domains of all networks; shape (n_input, 2)."""
        low = np.min([network.x_low for network in self.networks], axis=0)
        high = np.max([network.x_high for network in self.networks], axis=0)
        return np.column_stack([low, high])


def n_cells(edges: Edges) -> int:
    """Number of cells that the edges cut."""
    return int(np.prod([len(cuts) + 1 for cuts in edges.values()], dtype=int))


def cell_of(edges: Edges, X: np.ndarray) -> np.ndarray:
    """Cell of each row; the same rule as the compiled `table.region`."""
    cell = np.zeros(len(X), dtype=np.int64)
    for axis, cuts in edges.items():
        cell = cell * (len(cuts) + 1) + np.searchsorted(cuts, X[:, axis], side="left")
    return cell


def cell_name(edges: Edges, inputs: Sequence[Variable], cell: int) -> str:
    """A cell in words: ``x in (0.188, 0.376]``."""
    parts = []
    for axis, cuts in reversed(edges.items()):
        cell, place = divmod(cell, len(cuts) + 1)
        low = f"{cuts[place - 1]:g}" if place else "-inf"
        high = f"{cuts[place]:g}]" if place < len(cuts) else "inf)"
        parts.append(f"{inputs[axis].name} in ({low}, {high}")
    return " and ".join(reversed(parts)) or "everywhere"


def pack_models(models: Sequence[Model]) -> tuple[list[Regions], NetworkTable]:
    """All networks of several models in one table, and for each model which of them answers where."""
    table = pack([network for model in models for network in model.networks])
    regions, first = [], 0
    for model in models:
        axes, cuts, strides = [], [], []
        stride = len(model.networks)
        for axis, edges in model.edges.items():
            stride //= len(edges) + 1
            axes += [axis] * len(edges)
            cuts += list(edges)
            strides += [stride] * len(edges)
        ints = (np.array(values, dtype=np.int64) for values in (axes, strides))
        axis_array, stride_array = ints
        regions.append(Regions(first, axis_array, np.array(cuts, dtype=np.float64), stride_array))
        first += len(model.networks)
    return regions, table


def describe(network: Network, inputs: Sequence[Variable]) -> list[str]:
    """Equations of a network, one line a node, in normalized variables.

    Parameters
    ----------
    network : Network
    inputs : sequence of Variable
        Names of the network's inputs.
    """
    names = [f"n{i + 1}" for i in range(network.n_inputs)]
    lines = [
        f"n{i + 1} = ({v.name} - {network.x_mean[i]:.6g}) / {network.x_scale[i]:.6g}" for i, v in enumerate(inputs)
    ]
    for number, node in enumerate(network.nodes, start=1):
        parts = []
        for coef, exponents in zip(node.coef, terms(node.kind, len(node.inputs)), strict=True):
            if coef == 0.0:
                continue
            factors = [
                names[slot] + (f"^{e}" if e > 1 else "") for slot, e in zip(node.inputs, exponents, strict=True) if e
            ]
            parts.append(" ".join([f"{coef:+.6g}", *factors]))
        names.append(f"z{number}")
        lines.append(f"z{number} = {' '.join(parts)}    ({KIND_NAMES[node.kind]})")
    last = f" + {network.y_scale:.6g} {names[-1]}" if network.nodes else ""
    return [*lines, f"y = {network.y_mean:.6g}{last}"]
