"""A fitted model: one network, or one for each region of a partition, with names, units and domain.

This is what leaves training: it predicts, is written to a file, drawn, exported and put into a simulation, and knows
nothing of how it was fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from polydraulic.errors import InputError
from polydraulic.names import checked_name, checked_text
from polydraulic.networks.model.lags import Dynamics
from polydraulic.networks.model.nodes import KIND_NAMES, RAMP, SIGMOID, terms
from polydraulic.networks.model.partition import (
    EVERYWHERE,
    Partition,
    Regions,
    box_name,
    flatten,
    region_boxes,
    region_of,
)
from polydraulic.networks.model.rows_table import evaluate_rows
from polydraulic.networks.model.table import Network, NetworkTable, pack


@dataclass(frozen=True)
class Variable:
    """Name and unit of an input or output.

    Raises
    ------
    InputError
        If the name is blank, or name or unit hold what files and other programs do not take, such as control characters.
    """

    name: str
    unit: str = ""

    def __post_init__(self) -> None:
        checked_name(self.name, "variable")
        checked_text(self.unit, f"unit of {self.name!r},")

    def __str__(self) -> str:
        return f"{self.name} [{self.unit}]" if self.unit else self.name


@dataclass(frozen=True)
class Model:
    """Networks by region.

    Attributes
    ----------
    inputs : tuple of Variable
    output : Variable
    networks : tuple of Network
    partition : Split or int
        Which network answers where; 0 for a single one.
    training : dict
        Summary of the fit: numbers and strings.
    dynamics : Dynamics or None
        Which signals the inputs are and how many steps ago, of a model that predicts the next row of a log.
    """

    inputs: tuple[Variable, ...]
    output: Variable
    networks: tuple[Network, ...]
    partition: Partition = EVERYWHERE
    training: dict[str, object] = field(default_factory=dict)
    dynamics: Dynamics | None = None

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
        with np.errstate(over="ignore", invalid="ignore"):
            suspicious = not np.isfinite(X.sum())  # quick; it may overflow, too
        if suspicious and not np.all(np.isfinite(X)):
            row, column = np.argwhere(~np.isfinite(X))[0]
            raise InputError(f"{self.inputs[column].name} = {X[row, column]} in row {row}: must be finite")
        return evaluate_rows(self._table, self.partition, X)

    @cached_property
    def _table(self) -> NetworkTable:
        return pack(list(self.networks))

    def inside(self, X: np.ndarray) -> np.ndarray:
        """Whether each row lies in the domain of the network that answers for it; (n_row,) array of bool."""
        return np.asarray(~self.beyond(X).any(axis=1))

    def beyond(self, X: np.ndarray) -> np.ndarray:
        """Which inputs of each row lie outside the domain of the network that answers for it; (n_row, n_input) array of bool."""
        low, high = (np.array([getattr(network, end) for network in self.networks]) for end in ("x_low", "x_high"))
        k = region_of(self.partition, X)
        return np.asarray(~((low[k] <= X) & (high[k] >= X)))

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients of all networks."""
        return sum(network.n_coefficients for network in self.networks)

    def region_boxes(self) -> list[np.ndarray]:
        """Box of inputs for which each network answers, infinite where nothing cuts; shapes (n_input, 2)."""
        boxes = region_boxes(self.partition, len(self.inputs))
        return [boxes[k] for k in range(len(self.networks))]

    def region_names(self) -> list[str]:
        """Regions in words, one per network."""
        return [box_name(box, [variable.name for variable in self.inputs]) for box in self.region_boxes()]

    def domain(self) -> np.ndarray:
        """Smallest box around the domains of all networks; shape (n_input, 2)."""
        low = np.min([network.x_low for network in self.networks], axis=0)
        high = np.max([network.x_high for network in self.networks], axis=0)
        return np.column_stack([low, high])


def pack_models(models: Sequence[Model]) -> tuple[list[Regions], NetworkTable]:
    """All networks of several models in one table, and for each model which of them answers where."""
    table = pack([network for model in models for network in model.networks])
    firsts = np.cumsum([0, *(len(model.networks) for model in models)])
    return [flatten(model.partition, int(first)) for model, first in zip(models, firsts, strict=False)], table


def describe(network: Network, inputs: Sequence[Variable]) -> list[str]:
    """Equations of a network, one line per node, in normalized variables.

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
        value = " ".join(parts)
        if node.kind == SIGMOID:
            value = f"1 / (1 + exp(-({value})))"
        elif node.kind == RAMP:
            value = f"min(max({value}, 0), 1)"
        lines.append(f"z{number} = {value}    ({KIND_NAMES[node.kind]})")
    last = f" + {network.y_scale:.6g} {names[-1]}" if network.nodes else ""
    return [*lines, f"y = {network.y_mean:.6g}{last}"]
