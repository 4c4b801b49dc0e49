"""Synthesis: a network grown layer by layer until the predicted squared error stops falling (thesis 3.1).

PSE = FSE + CPM (2 K / N) s_p^2: the fitting squared error plus a penalty for K coefficients from N rows, with s_p^2 a
prior guess of the error variance of the true model. Each layer draws on the inputs and on the survivors of every
layer before it. A layer takes two passes over the rows: one for the moments from which all candidates are scored,
one in which the best are fitted by orthogonal least squares.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from polydraulic.networks.moments import Moments, moments, squared_errors
from polydraulic.networks.nodes import DOUBLE, KIND_NAMES, LINEAR, SINGLE, TRIPLE, design, terms, without_idle_inputs
from polydraulic.networks.rows import Rows
from polydraulic.networks.table import Node
from polydraulic.networks.triangle import Fit, carve, grow, solve

_REFIT = 30  # scored by moments, this many are fitted again by orthogonal least squares before the choice
_SAME = 1e-10  # outputs whose squared correlation is this close to 1 count as the same
_ROWS_A_COEFFICIENT = 3  # a network may have one coefficient for so many rows
_ALWAYS = 4  # coefficients that any data may have: one Single
_GAIN = 1e-9  # a PSE must fall by this share to count as better
_EXACT = 1e-24  # of the variance; a smaller error is rounding


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
        s_p^2: estimated again as the network grows; var(y) / 2, the historical setting; or a value in squared units of y.
    carve : bool
        Whether terms that cost more than they explain are left out of a node.
    """

    kinds: tuple[str, ...]
    max_layers: int
    n_survivors: int
    cpm: float
    prior_variance: str | float
    carve: bool


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


class _Variable(NamedTuple):
    """An input (without node) or a node's output while the network grows."""

    node: Node | None  # its slots count variables, not the final network's slots
    ancestors: frozenset[int]  # nodes needed to compute it, itself included


class _Scored(NamedTuple):
    """A candidate node, scored from moments."""

    fse: float
    n_coefficients: int
    kind: int
    inputs: tuple[int, ...]


class _Fitted(NamedTuple):
    """A candidate node, fitted on the rows."""

    pse: float
    n_coefficients: int
    fse: float
    variable: _Variable


def penalty(settings: Settings, k: int, weight: float, noise: float, variance: float) -> float:
    """Complexity penalty CPM (2 K / N) s_p^2 of `k` coefficients, as a share of the target's variance.

    Parameters
    ----------
    settings : Settings
    k : int
    weight : float
        N, the sum of the weights.
    noise : float
        Residual variance of the best fit so far (`residual_variance`): the adaptive prior.
    variance : float
        Of the target, to which a prior given as a number is referred.
    """
    if settings.prior_variance == "adaptive":
        prior = noise
    elif settings.prior_variance == "half-variance":
        prior = 0.5
    else:
        prior = float(settings.prior_variance) / variance
    return settings.cpm * 2.0 * k / weight * prior


def residual_variance(fse: float, k: int, weight: float) -> float:
    """Error variance that a fit with `k` coefficients leaves, corrected for their number."""
    return fse * weight / max(weight - k, 1.0)


def synthesize(rows: Rows, inputs: np.ndarray, settings: Settings) -> tuple[list[Node], list[Step]]:
    """Grow a network.

    Parameters
    ----------
    rows : Rows
    inputs : (n_chosen,) array of int
        Inputs that nodes may read.
    settings : Settings

    Returns
    -------
    nodes : list of Node
        In order of evaluation, slots counted as in `NetworkTable`; empty if no node is worth its coefficients.
    history : list of Step
        The start and each layer tried.
    """
    n_input, weight = len(rows.scaling.x_mean), rows.scaling.weight
    variance = rows.scaling.y_scale**2
    variables = [_Variable(None, frozenset()) for _ in range(n_input)]
    best, best_k = None, 0
    best_fse = sum(float(w @ (y * y)) for _, y, w in rows) / weight
    history = [Step(0, 0, 0, best_fse * variance, 0.0, best_fse * variance, True)]

    noise = best_fse

    def cost(k: int) -> float:
        return penalty(settings, k, weight, noise, variance)

    drawn = [int(i) for i in inputs]
    previous = drawn
    for layer in range(1, settings.max_layers + 1):
        if best_fse <= _EXACT:
            break
        candidates = _candidates(drawn, previous, layer, settings)
        scored = _score(rows, variables, drawn, candidates)
        noise = min([noise, *(residual_variance(c.fse, c.n_coefficients, weight) for c in scored)])
        scored.sort(key=lambda c: c.fse + cost(c.n_coefficients))
        survivors = _survivors(rows, variables, scored, cost, settings)
        if not survivors:
            break
        pse, k, fse, _ = survivors[0]
        accepted = pse < (best_fse + cost(best_k)) * (1.0 - _GAIN)
        n_candidates = sum(len(chosen) for _, chosen in candidates)
        history.append(Step(layer, n_candidates, k, fse * variance, cost(k) * variance, pse * variance, accepted))
        if not accepted:
            break
        previous = list(range(len(variables), len(variables) + len(survivors)))
        for number, survivor in zip(previous, survivors, strict=True):
            variables.append(survivor.variable._replace(ancestors=survivor.variable.ancestors | {number}))
        drawn = drawn + previous
        best, best_fse, best_k = variables[previous[0]], fse, k
    return ([] if best is None else _extract(variables, best, n_input)), history


def _values(variables: list[_Variable], x: np.ndarray) -> np.ndarray:
    """All variables on a block of rows, one column each."""
    columns = np.empty((len(x), len(variables)), order="F")
    columns[:, : x.shape[1]] = x
    for place, variable in enumerate(variables):
        if variable.node is not None:
            node = variable.node
            columns[:, place] = design(node.kind, columns[:, list(node.inputs)]) @ np.array(node.coef)
    return columns


def _candidates(drawn: list[int], previous: list[int], layer: int, settings: Settings) -> list[tuple[int, np.ndarray]]:
    """Every choice of variables that includes one of the layer before, and so was not possible earlier."""
    newest = set(previous)
    found = []
    for kind, size in ((SINGLE, 1), (DOUBLE, 2), (TRIPLE, 3)):
        if KIND_NAMES[kind] in settings.kinds:
            chosen = [c for c in combinations(drawn, size) if layer == 1 or newest.intersection(c)]
            if chosen:
                found.append((kind, np.array(chosen)))
    if KIND_NAMES[LINEAR] in settings.kinds and layer > 1 and len(previous) > 1:
        found.append((LINEAR, np.array([previous])))
    return found


def _ancestors(variables: list[_Variable], inputs: tuple[int, ...]) -> frozenset[int]:
    return frozenset().union(*(variables[i].ancestors for i in inputs))


def _count(variables: list[_Variable], nodes: frozenset[int]) -> int:
    """Coefficients of some nodes."""
    total = 0
    for i in nodes:
        node = variables[i].node
        assert node is not None
        total += sum(c != 0.0 for c in node.coef)
    return total


def _affordable(k: int, weight: float) -> bool:
    return _ROWS_A_COEFFICIENT * k <= weight or k <= _ALWAYS


def _score(
    rows: Rows,
    variables: list[_Variable],
    drawn: list[int],
    candidates: list[tuple[int, np.ndarray]],
) -> list[_Scored]:
    """Fitting error, from moments, of every candidate that the data can carry."""
    m: Moments | None = None
    for x, y, w in rows:
        part = moments(_values(variables, x)[:, drawn], y, w)
        m = part if m is None else m + part
    assert m is not None
    column = np.zeros(len(variables), dtype=np.int64)
    column[drawn] = np.arange(len(drawn))
    known: dict[frozenset[int], int] = {}
    scored = []
    for kind, inputs in candidates:
        errors = squared_errors(m, kind, column[inputs])
        for error, chosen in zip(errors.tolist(), map(tuple, inputs.tolist()), strict=True):
            nodes = _ancestors(variables, chosen)
            if nodes not in known:
                known[nodes] = _count(variables, nodes)
            k = known[nodes] + len(terms(kind, len(chosen)))
            if _affordable(k, m.weight):
                scored.append(_Scored(error, k, kind, chosen))
    return scored


def _survivors(
    rows: Rows,
    variables: list[_Variable],
    scored: list[_Scored],
    penalty: Callable[[int], float],
    settings: Settings,
) -> list[_Fitted]:
    """Fit the best candidates on the rows, rank them again, and keep those that differ from each other."""
    chosen = scored[: max(_REFIT, 3 * settings.n_survivors)]
    factors: list[np.ndarray | None] = [None] * len(chosen)
    sample = np.empty((0, len(variables)))  # the first block shows well enough whether two outputs differ
    for x, y, w in rows:
        values = _values(variables, x)
        sample = values if not len(sample) else sample
        for place, (_, _, kind, inputs) in enumerate(chosen):
            factors[place] = grow(factors[place], design(kind, values[:, inputs]), y, w)
    weight = rows.scaling.weight
    fitted = []
    for (_, _, kind, inputs), factor in zip(chosen, factors, strict=True):
        assert factor is not None
        fit = carve(factor, penalty(1) * weight) if settings.carve else solve(factor, np.arange(factor.shape[1] - 1))
        fitted.append(_fitted(variables, kind, inputs, fit, weight, penalty))
    kept: list[_Fitted] = []
    outputs: list[np.ndarray] = []
    for candidate in sorted(fitted, key=lambda candidate: candidate.pse):
        node = candidate.variable.node
        assert node is not None
        output = design(node.kind, sample[:, list(node.inputs)]) @ np.array(node.coef)
        if len(kept) < settings.n_survivors and all(_differ(output, other) for other in outputs):
            kept.append(candidate)
            outputs.append(output)
    return kept


def _fitted(
    variables: list[_Variable],
    kind: int,
    inputs: tuple[int, ...],
    fit: Fit,
    weight: float,
    penalty: Callable[[int], float],
) -> _Fitted:
    kind, kept, coef = without_idle_inputs(kind, fit.coef)
    inputs = tuple(inputs[place] for place in kept)
    ancestors = _ancestors(variables, inputs)
    k = _count(variables, ancestors) + int(np.count_nonzero(coef))
    fse = fit.squares / weight
    node = Node(kind, inputs, tuple(coef.tolist()))
    return _Fitted(fse + penalty(k), k, fse, _Variable(node, ancestors))


def _differ(a: np.ndarray, b: np.ndarray) -> bool:
    a, b = a - a.mean(), b - b.mean()
    return bool((a @ b) ** 2 < (1.0 - _SAME) * (a @ a) * (b @ b))


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
