"""Weighted moments of a set of variables: all that the least-squares fit of every possible node needs.

A triple of variables x, y, z has fourteen terms, and the products of two terms contain only moments of the forms
<x^a y^b>, <x y z^c>, <x^2 y^2 z^c>, each with c at most 4, 2. They come from three matrix products over the rows; after
that a candidate node costs no pass over the data. Moments of two blocks of rows add up to those of both.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE, terms

_PIVOT = 1e-11  # a column whose rest is smaller than this share of it depends on the columns before it
_BLOCK = 4096
_CHUNK = 4096  # candidates whose equations are held at a time


@dataclass
class Moments:
    """Weighted sums of products over rows, for n variables v and a target t.

    Attributes
    ----------
    weight : float
        Sum of the weights; the number of rows where there are none.
    power : (5, n, 5, n) array
        <v_i^a v_j^b> at [a, i, b, j].
    target : (5, n) array
        <v_i^a t> at [a, i].
    pair : (n, n, 5, n) array
        <v_i v_j v_k^c> at [i, j, c, k].
    pair_target : (n, n) array
        <v_i v_j t>.
    triple_target : (n, n, n) array
        <v_i v_j v_k t>.
    square : (n, n, 3, n) array
        <v_i^2 v_j^2 v_k^c> at [i, j, c, k].
    target_square : float
        <t^2>.
    """

    weight: float
    power: np.ndarray
    target: np.ndarray
    pair: np.ndarray
    pair_target: np.ndarray
    triple_target: np.ndarray
    square: np.ndarray
    target_square: float

    def __add__(self, other: "Moments") -> "Moments":
        return Moments(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))


def moments(v: np.ndarray, t: np.ndarray, weight: np.ndarray | None = None, *, triples: bool = True) -> Moments:
    """Moments of a set of rows.

    Parameters
    ----------
    v : (n_row, n) array
        Variables.
    t : (n_row,) array
        Target.
    weight : (n_row,) array, optional
    triples : bool
        Without them the tables with three variables stay empty, and only Singles, Doubles and Linears can be scored.
    """
    total: Moments | None = None
    for start in range(0, len(v), _BLOCK):
        rows = slice(start, start + _BLOCK)
        w = np.ones(len(t[rows])) if weight is None else weight[rows]
        part = _block_moments(v[rows], t[rows], w, triples)
        total = part if total is None else total + part
    assert total is not None
    return total


def _block_moments(v: np.ndarray, t: np.ndarray, w: np.ndarray, triples: bool) -> Moments:
    n_row, n = v.shape
    v2 = v * v
    powers = np.stack([np.ones_like(v), v, v2, v2 * v, v2 * v2], axis=1)  # (n_row, 5, n)
    flat = powers.reshape(n_row, 5 * n)
    weighted = flat * w[:, None]
    power, target = (weighted.T @ flat).reshape(5, n, 5, n), (weighted.T @ t).reshape(5, n)
    weight, target_square = float(w.sum()), float((w * t) @ t)
    if not triples:
        none = np.zeros(0)
        return Moments(weight, power, target, none, (v * (w * t)[:, None]).T @ v, none, none, target_square)
    i, j = np.triu_indices(n)
    pairs, weighted_pairs = _pairs(np.ascontiguousarray(v.T)), np.empty((len(i), n_row))
    np.multiply(pairs, w, out=weighted_pairs)
    right = np.hstack([flat, t[:, None], v * t[:, None]])
    from_pairs = weighted_pairs @ right
    weighted_pairs *= pairs
    squares = weighted_pairs @ flat[:, : 3 * n]

    def both_ways(half: np.ndarray, *shape: int) -> np.ndarray:
        full = np.empty((n, n, *shape))
        full[i, j] = full[j, i] = half.reshape(len(i), *shape)
        return full

    return Moments(
        weight=weight,
        power=power,
        target=target,
        pair=both_ways(from_pairs[:, : 5 * n], 5, n),
        pair_target=both_ways(from_pairs[:, 5 * n]),
        triple_target=both_ways(from_pairs[:, 5 * n + 1 :], n),
        square=both_ways(squares, 3, n),
        target_square=target_square,
    )


def _pairs(across: np.ndarray) -> np.ndarray:
    """Products v_i v_j for i <= j, one a row, from variables one a row; filled in place, as copies would cost most."""
    n, n_row = across.shape
    pairs = np.empty((n * (n + 1) // 2, n_row))
    start = 0
    for i in range(n):
        np.multiply(across[i], across[i:], out=pairs[start : start + n - i])
        start += n - i
    return pairs


def normal_equations(m: Moments, kind: int, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gram matrices and right-hand sides of many candidate nodes of one kind.

    Parameters
    ----------
    m : Moments
    kind : int
    inputs : (n_candidate, n_input) array of int
        Which variables each candidate reads.

    Returns
    -------
    gram : (n_candidate, n_term, n_term) array
    right : (n_candidate, n_term) array
    """
    if kind == LINEAR:
        a, b = inputs[:, :, None], inputs[:, None, :]
        return m.power[1, a, 1, b], m.target[1, inputs]
    of_product, of_target = _plan(kind)
    n_term = len(of_target)
    gram = np.empty((len(inputs), n_term, n_term))
    for (row, column), exponents in of_product:
        gram[:, row, column] = gram[:, column, row] = _moment(m, exponents, inputs)
    right = np.empty((len(inputs), n_term))
    for row, exponents in enumerate(of_target):
        right[:, row] = _target_moment(m, exponents, inputs)
    return gram, right


@cache
def _plan(kind: int) -> tuple[list[tuple[tuple[int, int], tuple[int, ...]]], list[tuple[int, ...]]]:
    exponents = terms(kind, {SINGLE: 1, DOUBLE: 2, TRIPLE: 3}[kind])
    products = [
        ((row, column), tuple(a + b for a, b in zip(exponents[row], exponents[column], strict=True)))
        for row in range(len(exponents))
        for column in range(row + 1)
    ]
    return products, list(exponents)


def _moment(m: Moments, exponents: tuple[int, ...], inputs: np.ndarray) -> np.ndarray:
    """<x^a y^b z^c> for each candidate, from whichever table holds it."""
    used = sorted(((e, k) for k, e in enumerate(exponents) if e), reverse=True)
    at = [inputs[:, k] for _, k in used]
    power = [e for e, _ in used]
    if len(used) == 0:
        return np.full(len(inputs), m.weight)
    if len(used) == 1:
        half = min(power[0], 3)
        return m.power[half, at[0], power[0] - half, at[0]]
    if len(used) == 2:
        return m.power[power[0], at[0], power[1], at[1]]
    if power[1] == 1:  # x^a y z
        return m.pair[at[1], at[2], power[0], at[0]]
    return m.square[at[0], at[1], power[2], at[2]]  # x^2 y^2 z^c


def _target_moment(m: Moments, exponents: tuple[int, ...], inputs: np.ndarray) -> np.ndarray:
    used = [(e, inputs[:, k]) for k, e in enumerate(exponents) if e]
    if not used:
        return m.target[0, inputs[:, 0]]
    if len(used) == 1:
        return m.target[used[0][0], used[0][1]]
    if len(used) == 2:
        return m.pair_target[used[0][1], used[1][1]]
    return m.triple_target[used[0][1], used[1][1], used[2][1]]


def squared_errors(m: Moments, kind: int, inputs: np.ndarray) -> np.ndarray:
    """Fitting squared error, averaged over rows, of each candidate's least-squares fit; shape (n_candidate,)."""
    explained = np.empty(len(inputs))
    for start in range(0, len(inputs), _CHUNK):
        part = slice(start, start + _CHUNK)
        gram, right = normal_equations(m, kind, inputs[part])
        _explain(gram, right, np.empty(gram.shape[1:]), np.empty(gram.shape[1]), explained[part])
    return np.maximum(m.target_square - explained, 0.0) / m.weight


@driver
def _explain(gram: np.ndarray, right: np.ndarray, factor: np.ndarray, z: np.ndarray, explained: np.ndarray) -> None:
    """Squared target that each candidate explains: b' G^-1 b by Cholesky, skipping dependent columns."""
    n = right.shape[1]
    for k in range(right.shape[0]):
        total = 0.0
        for i in range(n):
            rest = gram[k, i, i]
            b = right[k, i]
            for j in range(i):
                entry = gram[k, i, j]
                for l in range(j):  # noqa: E741
                    entry -= factor[i, l] * factor[j, l]
                entry = entry / factor[j, j] if factor[j, j] > 0.0 else 0.0
                factor[i, j] = entry
                rest -= entry * entry
                b -= entry * z[j]
            independent = rest > _PIVOT * gram[k, i, i]
            factor[i, i] = np.sqrt(rest) if independent else 0.0
            z[i] = b / factor[i, i] if independent else 0.0
            total += z[i] * z[i]
        explained[k] = total
