"""Synthesis: a network grown layer by layer until the predicted squared error stops falling (thesis 3.1).

PSE = FSE + CPM (2 K / N) s_p^2: the fitting squared error plus a penalty for K coefficients from N rows, with s_p^2 a
prior guess of the error variance of the true model. Each layer draws on the inputs and on the survivors of every
layer before it. A layer takes two passes over the rows: one for the moments from which all candidates are scored,
one in which the best are fitted as exactly as by orthogonal least squares.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import comb
from typing import Any, NamedTuple

import numpy as np

from polydraulic.networks.growth.least_squares import (
    LeastSquaresFit,
    TriangularFactor,
    add_rows,
    begin,
    carve,
    factor_of,
    solve_terms,
)
from polydraulic.networks.growth.moments import Moments, moments_of_blocks
from polydraulic.networks.growth.scoring import normal_equations, squared_errors
from polydraulic.networks.growth.training_rows import TrainingRows
from polydraulic.networks.growth.variables import GrownVariable, count_before, node_output, variable_values
from polydraulic.networks.model.history import GrowthStep
from polydraulic.networks.model.nodes import (
    DOUBLE,
    KIND_NAMES,
    LINEAR,
    SINGLE,
    TRIPLE,
    terms,
    without_idle_inputs,
)
from polydraulic.networks.model.table import Node

SMALLEST_VARIANCE = float(np.finfo(np.float64).smallest_normal)  # of a target of 1e-200 it is no number above zero
_REFIT = 30  # scored by moments, this many are fitted on the rows before the choice
_SAME = 1e-10  # outputs whose squared correlation is this close to 1 count as the same
_ROWS_A_COEFFICIENT = 3  # a network may have one coefficient for so many rows
FEWEST_ROWS = _ROWS_A_COEFFICIENT * len(terms(SINGLE, 1))  # of any network
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
        Maximum number of layers; nodes kept per layer.
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


class _Scored(NamedTuple):
    """Candidate nodes of one kind, scored from moments."""

    kind: int
    inputs: np.ndarray  # (n_candidate, n_input)
    n_coefficients: np.ndarray
    fse: np.ndarray


class _Fitted(NamedTuple):
    """A candidate node, fitted on the rows."""

    pse: float
    n_coefficients: int
    fse: float
    variable: GrownVariable


def penalty(settings: Settings, k: Any, weight: float, noise: float, variance: float) -> Any:
    """Complexity penalty CPM (2 K / N) s_p^2 of `k` coefficients (a number or an array), as a share of the target's variance.

    Parameters
    ----------
    settings : Settings
    k : int or array of int
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
        prior = float(settings.prior_variance) / max(variance, SMALLEST_VARIANCE)
    return settings.cpm * 2.0 * k / weight * prior


def residual_variance(fse: Any, k: Any, weight: float) -> Any:
    """Error variance that a fit with `k` coefficients leaves, corrected for their number; of numbers or arrays."""
    return fse * weight / np.maximum(weight - k, 1.0)


def synthesize(
    rows: TrainingRows, inputs: np.ndarray, settings: Settings, few: TrainingRows | None = None
) -> tuple[list[list[Node]], list[GrowthStep]]:
    """Grow a network.

    Parameters
    ----------
    rows : TrainingRows
    inputs : (n_chosen,) array of int
        Inputs that nodes may read.
    settings : Settings
    few : TrainingRows, optional
        A sample from which candidates are scored; the best are fitted on all rows.

    Returns
    -------
    networks : list of list of Node
        The best network of each accepted step, first the empty one; nodes in order of evaluation, slots counted as in
        `NetworkTable`.
    history : list of GrowthStep
        The start and each layer tried.
    """
    n_input, weight = len(rows.scaling.x_mean), rows.scaling.weight
    variance = rows.scaling.y_scale**2
    variables = [GrownVariable(None, frozenset(), 0) for _ in range(n_input)]
    networks: list[list[Node]] = [[]]
    best_k = 0
    best_fse = sum(float(y @ y if w is None else w @ (y * y)) for _, y, w in rows) / weight
    history = [GrowthStep(0, 0, 0, best_fse * variance, 0.0, best_fse * variance, True)]
    noise = best_fse

    def cost(k: Any) -> Any:
        return penalty(settings, k, weight, noise, variance)

    old, new = np.zeros(0, dtype=np.int64), np.asarray(inputs, dtype=np.int64)
    for layer in range(1, settings.max_layers + 1):
        if best_fse <= _EXACT or not len(new):
            break
        drawn = np.concatenate([old, new])
        m = _moments(rows if few is None else few, variables, drawn, len(old))
        candidates = _candidates(len(old), len(drawn), settings)
        scored = [_score(m, variables, drawn, kind, chosen, weight) for kind, chosen in candidates]
        for kind in scored:
            noise = float(residual_variance(kind.fse, kind.n_coefficients, weight).min(initial=noise))
        survivors = _survivors(rows, variables, drawn, m, scored, cost, settings)
        if not survivors:
            break
        pse, k, fse, _ = survivors[0]
        accepted = pse < (best_fse + cost(best_k)) * (1.0 - _GAIN)
        n_candidates = sum(len(chosen) for _, chosen in candidates)
        history.append(GrowthStep(layer, n_candidates, k, fse * variance, cost(k) * variance, pse * variance, accepted))
        if not accepted:
            break
        old, new = drawn, np.arange(len(variables), len(variables) + len(survivors))
        for number, survivor in zip(new.tolist(), survivors, strict=True):
            variables.append(survivor.variable._replace(ancestors=survivor.variable.ancestors | {number}))
        networks.append(_extract(variables, variables[new[0]], n_input))
        best_fse, best_k = fse, k
    return networks, history


def _moments(rows: TrainingRows, variables: list[GrownVariable], drawn: np.ndarray, n_old: int) -> Moments:
    blocks = ((variable_values(variables, x)[drawn].T, y, w) for x, y, w in rows)
    return moments_of_blocks(blocks, len(drawn), n_old=n_old)


def _candidates(n_old: int, n: int, settings: Settings) -> list[tuple[int, np.ndarray]]:
    """Every choice of `n` variables that includes one of the newest, and so was not possible earlier, by kind."""
    found = [
        (kind, _rising(n, size, n_old))
        for kind, size in ((SINGLE, 1), (DOUBLE, 2), (TRIPLE, 3))
        if KIND_NAMES[kind] in settings.kinds and n >= size
    ]
    if KIND_NAMES[LINEAR] in settings.kinds and 0 < n_old < n - 1:
        found.append((LINEAR, np.arange(n_old, n)[None, :]))
    return found


def _rising(n: int, size: int, first: int) -> np.ndarray:
    """All rising choices of `size` numbers below `n`, one per row, sorted by the last, which is at least `first`."""
    if size == 1:
        return np.arange(first, n)[:, None]
    before = _rising(n, size - 1, 0)
    ends = range(max(first, size - 1), n)
    counts = [comb(end, size - 1) for end in ends]
    return np.column_stack([np.concatenate([before[:count] for count in counts]), np.repeat(ends, counts)])


def _score(
    m: Moments, variables: list[GrownVariable], drawn: np.ndarray, kind: int, inputs: np.ndarray, weight: float
) -> _Scored:
    """Fitting error, from moments, of every candidate of a kind that the data can carry."""
    needed = np.zeros((len(drawn), len(variables)), dtype=np.bool_)
    for row, number in enumerate(drawn.tolist()):
        needed[row, list(variables[number].ancestors)] = True
    sizes = np.array([variable.size for variable in variables])
    k = np.full(len(inputs), len(terms(kind, inputs.shape[1])))
    count_before(needed, sizes, inputs, k)
    carried = _ROWS_A_COEFFICIENT * k <= weight
    inputs, k = inputs[carried], k[carried]
    return _Scored(kind, inputs, k, squared_errors(m, kind, inputs))


def _survivors(
    rows: TrainingRows,
    variables: list[GrownVariable],
    drawn: np.ndarray,
    m: Moments,
    scored: list[_Scored],
    cost: Callable[[Any], Any],
    settings: Settings,
) -> list[_Fitted]:
    """Fit the best candidates on the rows, rank them again, and keep those that differ from each other."""
    weight = rows.scaling.weight
    tried = _promising(drawn, m, scored, cost, max(_REFIT, 3 * settings.n_survivors))
    sample: np.ndarray | None = None  # the first block shows well enough whether two outputs differ
    for x, y, w in rows:
        values = variable_values(variables, x)
        sample = values if sample is None else sample
        root = np.ones(len(y)) if w is None else np.sqrt(w)
        for kind, inputs, triangle in tried:
            add_rows(triangle, kind, inputs, values, y, root)
    assert sample is not None
    fitted = []
    for kind, inputs, triangle in tried:
        factor = factor_of(triangle)
        fit = carve(factor, cost(1) * weight) if settings.carve else solve_terms(factor, np.arange(len(factor) - 1))
        fitted.append(_fitted(variables, kind, inputs, fit, weight, cost))
    fitted.sort(key=_rank)
    return _different(fitted, sample, settings.n_survivors)


def _promising(
    drawn: np.ndarray, m: Moments, scored: list[_Scored], cost: Callable[[Any], Any], n: int
) -> list[tuple[int, np.ndarray, TriangularFactor]]:
    """Kind, variables and first factor of the `n` candidates with the least predicted squared error."""
    pse = [kind.fse + cost(kind.n_coefficients) for kind in scored]
    worst = np.sort(np.concatenate([np.zeros(0), *pse]))[:n].max(initial=0.0)
    found = []
    for kind, errors in zip(scored, pse, strict=True):
        best = kind.inputs[np.argsort(errors, kind="stable")[: np.count_nonzero(errors <= worst)][:n]]
        for inputs, gram, right in zip(best, *normal_equations(m, kind.kind, best), strict=True):
            found.append((kind.kind, drawn[inputs], begin(gram, right, m.target_square)))
    return found


def _fitted(
    variables: list[GrownVariable],
    kind: int,
    inputs: np.ndarray,
    fit: LeastSquaresFit,
    weight: float,
    cost: Callable[[Any], Any],
) -> _Fitted:
    kind, kept, coef = without_idle_inputs(kind, fit.coef)
    node = Node(kind, tuple(inputs[kept].tolist()), tuple(coef.tolist()))
    ancestors = frozenset().union(*(variables[i].ancestors for i in node.inputs))
    size = int(np.count_nonzero(coef))
    k, fse = sum(variables[i].size for i in ancestors) + size, fit.squares / weight
    return _Fitted(fse + cost(k), k, fse, GrownVariable(node, ancestors, size))


def _rank(candidate: _Fitted) -> tuple[float, tuple[int, ...]]:
    """Order by the error; of errors that differ by no more than rounding, by which variables were there first."""
    node = candidate.variable.node
    assert node is not None
    return float(f"{candidate.pse:.12g}"), node.inputs


def _different(fitted: list[_Fitted], sample: np.ndarray, n: int) -> list[_Fitted]:
    """The first `n` whose outputs on the sample are not the same but for a straight line."""
    kept: list[_Fitted] = []
    outputs = np.empty((n, sample.shape[1]))
    squares = np.empty(n)
    for candidate in fitted:
        if len(kept) == n:
            break
        node = candidate.variable.node
        assert node is not None
        output = node_output(node, sample, np.empty(sample.shape[1]))
        output -= output.mean()
        square, known = output @ output, len(kept)
        if np.all((outputs[:known] @ output) ** 2 < (1.0 - _SAME) * square * squares[:known]):
            outputs[known], squares[known] = output, square
            kept.append(candidate)
    return kept


def _extract(variables: list[GrownVariable], best: GrownVariable, n_input: int) -> list[Node]:
    """Only the nodes that the best one needs, with slots renumbered."""
    needed = sorted(best.ancestors)
    slot = {i: i for i in range(n_input)} | {number: n_input + place for place, number in enumerate(needed)}
    nodes = []
    for number in needed:
        node = variables[number].node
        assert node is not None
        nodes.append(Node(node.kind, tuple(slot[i] for i in node.inputs), node.coef))
    return nodes
