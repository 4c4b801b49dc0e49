"""Synthesis: a network grown layer by layer until the predicted squared error stops falling (thesis 3.1).

PSE = FSE + CPM (2 K / N) s_p^2: the fitting squared error plus a penalty for K coefficients from N rows, with s_p^2 a
prior guess of the error variance of the true model. Each layer draws on the inputs and on the survivors of every
layer before it. All candidates are scored from moments; the best are fitted again on the rows themselves.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from polydraulic.networks.moments import moments, squared_errors
from polydraulic.networks.nodes import (
    DOUBLE,
    KIND_NAMES,
    LINEAR,
    SINGLE,
    TRIPLE,
    design,
    least_squares,
    terms,
)
from polydraulic.networks.table import Node

_REFIT = 30  # scored by moments, this many are fitted again by orthogonal least squares before the choice
_SAME = 1e-10  # outputs whose squared correlation is this close to 1 count as the same
_ROWS_A_COEFFICIENT = 3  # a network may have one coefficient for so many rows
_ALWAYS = 4  # coefficients that any data may have: one Single
_GAIN = 1e-9  # a PSE must fall by this share to count as better


@dataclass(frozen=True)
class Settings:
    """What steers the search.

    Attributes
    ----------
    kinds : tuple of str
        Node kinds allowed.
    max_layers, n_survivors : int
        Layers at most; nodes kept a layer.
    cpm : float
        Complexity penalty multiplier.
    prior_variance : "adaptive", "half-variance" or float
        s_p^2: estimated again as the network grows; var(y) / 2, the historical setting; or a value in units of y squared.
    """

    kinds: tuple[str, ...]
    max_layers: int
    n_survivors: int
    cpm: float
    prior_variance: str | float


@dataclass(frozen=True)
class Step:
    """One layer in the history of a synthesis; errors in squared units of y."""

    layer: int
    n_candidates: int
    n_coefficients: int
    fse: float
    penalty: float
    pse: float
    accepted: bool


@dataclass
class _Variable:
    """An input or a node's output while the network grows."""

    values: np.ndarray
    node: Node | None  # None for an input; its slots count variables, not the final network's slots
    ancestors: frozenset[int]  # nodes needed to compute it, itself included


class _Scored(NamedTuple):
    """A candidate node, scored from moments."""

    pse: float
    kind: int
    inputs: tuple[int, ...]


class _Fitted(NamedTuple):
    """A candidate node, fitted on the rows."""

    pse: float
    n_coefficients: int
    fse: float
    variable: _Variable


def synthesize(
    x: np.ndarray, y: np.ndarray, weight: np.ndarray | None, variance: float, settings: Settings
) -> tuple[list[Node], list[Step]]:
    """Grow a network on normalized data.

    Parameters
    ----------
    x : (n_row, n_input) array
        Normalized inputs.
    y : (n_row,) array
        Normalized target.
    weight : (n_row,) array or None
    variance : float
        Variance of the target in its own units: scales what the history and `prior_variance` report.
    settings : Settings

    Returns
    -------
    nodes : list of Node
        In order of evaluation, slots counted as in `NetworkTable`; empty if no node is worth its coefficients.
    history : list of Step
        The start and each layer tried.
    """
    rows = float(len(y)) if weight is None else float(weight.sum())
    variables = [_Variable(x[:, i], None, frozenset()) for i in range(x.shape[1])]
    fse = float(np.average(y * y, weights=weight))
    best, best_fse, best_k = None, fse, 0
    history = [Step(0, 0, 0, fse * variance, 0.0, fse * variance, True)]

    def penalty(k: int) -> float:
        if settings.prior_variance == "adaptive":
            prior = best_fse * rows / max(rows - best_k, 1.0)
        elif settings.prior_variance == "half-variance":
            prior = 0.5
        else:
            prior = float(settings.prior_variance) / variance if variance > 0.0 else 0.0
        return settings.cpm * 2.0 * k / rows * prior

    previous = list(range(len(variables)))
    for layer in range(1, settings.max_layers + 1):
        if best_fse <= 1e-24:
            break
        candidates = _candidates(variables, previous, layer, settings)
        scored = _score(variables, candidates, y, weight, penalty)
        n_candidates = sum(len(inputs) for _, inputs in candidates)
        survivors = _survivors(variables, scored, y, weight, penalty, settings.n_survivors)
        if not survivors:
            break
        pse, k, fse, variable = survivors[0]
        accepted = pse < (best_fse + penalty(best_k)) * (1.0 - _GAIN)
        history.append(Step(layer, n_candidates, k, fse * variance, penalty(k) * variance, pse * variance, accepted))
        if not accepted:
            break
        previous = list(range(len(variables), len(variables) + len(survivors)))
        for number, (_, _, _, survivor) in zip(previous, survivors, strict=True):
            survivor.ancestors = survivor.ancestors | {number}
            variables.append(survivor)
        best, best_fse, best_k = variable, fse, k
    return ([] if best is None else _extract(variables, best, x.shape[1])), history


def _candidates(
    variables: list[_Variable], previous: list[int], layer: int, settings: Settings
) -> list[tuple[int, np.ndarray]]:
    """Every choice of inputs that includes a variable of the layer before, and so was not possible earlier."""
    newest = set(previous)
    found = []
    for kind, size in ((SINGLE, 1), (DOUBLE, 2), (TRIPLE, 3)):
        if KIND_NAMES[kind] in settings.kinds:
            chosen = [c for c in combinations(range(len(variables)), size) if layer == 1 or newest.intersection(c)]
            if chosen:
                found.append((kind, np.array(chosen)))
    if KIND_NAMES[LINEAR] in settings.kinds and layer > 1 and len(previous) > 1:
        found.append((LINEAR, np.array([previous])))
    return found


def _count(variables: list[_Variable], kind: int, inputs: tuple[int, ...]) -> int:
    """K of the network that ends in this candidate."""
    nodes = frozenset().union(*(variables[i].ancestors for i in inputs))
    total = len(terms(kind, len(inputs)))
    for i in nodes:
        node = variables[i].node
        assert node is not None
        total += len(node.coef)
    return total


def _score(
    variables: list[_Variable],
    candidates: list[tuple[int, np.ndarray]],
    y: np.ndarray,
    weight: np.ndarray | None,
    penalty: Callable[[int], float],
) -> list[_Scored]:
    """PSE from moments of every candidate that the data can carry, best first."""
    m = moments(np.column_stack([v.values for v in variables]), y, weight)
    scored = []
    for kind, inputs in candidates:
        errors = squared_errors(m, kind, inputs)
        for error, chosen in zip(errors.tolist(), map(tuple, inputs.tolist()), strict=True):
            k = _count(variables, kind, chosen)
            if _ROWS_A_COEFFICIENT * k <= m.weight or k <= _ALWAYS:
                scored.append(_Scored(error + penalty(k), kind, chosen))
    return sorted(scored, key=lambda candidate: candidate.pse)


def _survivors(
    variables: list[_Variable],
    scored: list[_Scored],
    y: np.ndarray,
    weight: np.ndarray | None,
    penalty: Callable[[int], float],
    n_survivors: int,
) -> list[_Fitted]:
    """Fit the best candidates on the rows, rank them again, and keep those that differ from each other."""
    fitted = []
    for _, kind, inputs in scored[: max(_REFIT, 3 * n_survivors)]:
        matrix = design(kind, np.column_stack([variables[i].values for i in inputs]))
        coef = least_squares(matrix, y, weight)
        values = matrix @ coef
        fse = float(np.average((y - values) ** 2, weights=weight))
        k = _count(variables, kind, inputs)
        ancestors = frozenset().union(*(variables[i].ancestors for i in inputs))
        node = Node(kind, inputs, tuple(coef.tolist()))
        fitted.append(_Fitted(fse + penalty(k), k, fse, _Variable(values, node, ancestors)))
    kept: list[_Fitted] = []
    for candidate in sorted(fitted, key=lambda candidate: candidate.pse):
        if len(kept) < n_survivors and all(
            _differ(candidate.variable.values, other.variable.values, weight) for other in kept
        ):
            kept.append(candidate)
    return kept


def _differ(a: np.ndarray, b: np.ndarray, weight: np.ndarray | None) -> bool:
    a = a - np.average(a, weights=weight)
    b = b - np.average(b, weights=weight)
    ab, aa, bb = (np.average(product, weights=weight) for product in (a * b, a * a, b * b))
    return bool(ab * ab < (1.0 - _SAME) * aa * bb)


def _extract(variables: list[_Variable], best: _Variable, n_input: int) -> list[Node]:
    """Only the nodes that the best one needs, with slots renumbered."""
    needed = sorted(best.ancestors)
    slot = {i: i for i in range(n_input)} | {number: n_input + place for place, number in enumerate(needed)}
    nodes = []
    for number in needed:
        node = variables[number].node
        assert node is not None
        nodes.append(Node(node.kind, tuple(slot[i] for i in node.inputs), node.coef))
    return nodes
