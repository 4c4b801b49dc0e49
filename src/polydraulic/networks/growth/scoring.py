"""Candidate nodes scored from moments: a small least-squares problem each, none of which looks at the rows."""

from functools import cache
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.networks.growth.moments import Moments
from polydraulic.networks.model.nodes import terms

_PIVOT = 1e-11  # a column whose rest is smaller than this share of it depends on the columns before it
_CHUNK = 512  # candidates whose moments are held at a time, whole lanes of them
_LANES = 32  # candidates solved side by side
_POWERS, _TRIPLE, _SQUARE, _PAIR_TARGET, _TRIPLE_TARGET = range(5)
_TARGET = -1  # in place of an exponent: the target


class _Plan(NamedTuple):
    """Which moments a kind of node needs, and where they stand in its equations."""

    where: np.ndarray  # (n_moment, 5): table, then places of inputs and exponents as `_look_up` takes them
    product: np.ndarray  # (n_term, n_term): moment of the product of two terms
    target: np.ndarray  # (n_term,): moment of a term and the target


@cache
def _plan(kind: int, n_inputs: int) -> _Plan:
    exponents = terms(kind, n_inputs)
    products = [[tuple(a + b for a, b in zip(one, two, strict=True)) for two in exponents] for one in exponents]
    distinct = sorted({e for row in products for e in row})
    place = {e: k for k, e in enumerate(distinct)}
    return _Plan(
        where=np.array([_product(e) for e in distinct] + [_with_target(e) for e in exponents]),
        product=np.array([[place[e] for e in row] for row in products]),
        target=len(distinct) + np.arange(len(exponents)),
    )


def _product(exponents: tuple[int, ...]) -> tuple[int, ...]:
    """Which table holds <x^a y^b z^c>, and where."""
    used = sorted(((e, k) for k, e in enumerate(exponents) if e), reverse=True)
    (a, p), (b, q), (c, r) = (*used, (0, 0), (0, 0), (0, 0))[:3]
    if not b:
        half = min(a, 3)  # the table holds powers up to the fourth on either side
        return (_POWERS, p, p, half, a - half)
    if not c:
        return (_POWERS, p, q, a, b)
    return (_TRIPLE, q, r, p, a) if b == 1 else (_SQUARE, p, q, r, c)


def _with_target(exponents: tuple[int, ...]) -> tuple[int, ...]:
    used = [(e, k) for k, e in enumerate(exponents) if e]
    if len(used) < 2:
        e, p = used[0] if used else (0, 0)
        return (_POWERS, p, p, e, _TARGET)
    places = [k for _, k in used]
    return (_PAIR_TARGET, *places, 0, 0) if len(used) == 2 else (_TRIPLE_TARGET, *places, 0)


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
    plan = _plan(kind, inputs.shape[1])
    found = np.empty((len(plan.where), len(inputs)))
    _look_up(m, plan.where, inputs, found)
    return np.moveaxis(found[plan.product], 2, 0), found[plan.target].T


def squared_errors(m: Moments, kind: int, inputs: np.ndarray) -> np.ndarray:
    """Fitting squared error, averaged over rows, of each candidate's least-squares fit; shape (n_candidate,)."""
    plan = _plan(kind, inputs.shape[1])
    n_term = len(plan.target)
    explained = np.empty(-(-len(inputs) // _LANES) * _LANES)
    work = np.empty((n_term + 3, n_term, _LANES))
    for start in range(0, len(inputs), _CHUNK):
        part = inputs[start : start + _CHUNK]
        found = np.zeros((len(plan.where), -(-len(part) // _LANES) * _LANES))
        _look_up(m, plan.where, part, found)
        _explain(found, plan.product, plan.target, work, explained[start : start + _CHUNK])
    return np.maximum(m.target_square - explained[: len(inputs)], 0.0) / m.weight


@driver
def _look_up(m: Moments, where: np.ndarray, inputs: np.ndarray, found: np.ndarray) -> None:
    """Moments of every candidate, one moment per row."""
    one = 4 * m.pair_target.shape[0]
    for row in range(where.shape[0]):
        table, p, q, r, e = where[row, 0], where[row, 1], where[row, 2], where[row, 3], where[row, 4]
        for k in range(inputs.shape[0]):
            x, y = inputs[k, p], inputs[k, q]
            if table == _POWERS:
                left = one if r == 0 else 4 * x + r - 1
                right = one if e == 0 else (one + 1 if e == _TARGET else 4 * y + e - 1)
                found[row, k] = m.power[left, right]
            elif table == _PAIR_TARGET:
                found[row, k] = m.pair_target[x, y]
            else:
                z = inputs[k, r]
                low, high = min(x, y), max(x, y)
                # the same for all choices of the pair: summed for one
                if z < high and (table == _TRIPLE_TARGET or e == (1 if table == _TRIPLE else 2)):
                    low, high, z = min(low, z), max(low, z), high
                pair = high * (high - 1) // 2 + low
                if table == _TRIPLE:
                    found[row, k] = m.triple[pair, z, e - 1]
                elif table == _SQUARE:
                    found[row, k] = m.square[pair, z, e - 1]
                else:
                    found[row, k] = m.triple_target[pair, z]


@driver
def _explain(
    found: np.ndarray, product: np.ndarray, target: np.ndarray, work: np.ndarray, explained: np.ndarray
) -> None:
    """Squared target that each candidate explains: b' G^-1 b by Cholesky, skipping dependent columns.

    Candidates are solved side by side, so that the innermost loops are vectors; `work` is (n_term + 3, n_term, n_lane).
    """
    n, n_lane = product.shape[0], work.shape[2]
    lanes = range(n_lane)
    z, inverse, rest = work[n], work[n + 1], work[n + 2]
    for first in range(0, found.shape[1], n_lane):
        end = first + n_lane
        for i in range(n):
            whole, right = found[product[i, i], first:end], found[target[i], first:end]
            for k in lanes:
                rest[i, k] = whole[k]
                z[i, k] = right[k]
            for j in range(i):
                entry, moment = work[i, j], found[product[i, j], first:end]
                for k in lanes:
                    entry[k] = moment[k]
                for l in range(j):  # noqa: E741
                    for k in lanes:
                        entry[k] -= work[i, l, k] * work[j, l, k]
                for k in lanes:
                    entry[k] *= inverse[j, k]
                    rest[i, k] -= entry[k] * entry[k]
                    z[i, k] -= entry[k] * z[j, k]
            for k in lanes:
                inverse[i, k] = 1.0 / np.sqrt(rest[i, k]) if rest[i, k] > _PIVOT * whole[k] else 0.0
                z[i, k] *= inverse[i, k]
        total = explained[first:end]
        for k in lanes:
            total[k] = 0.0
            for i in range(n):
                total[k] += z[i, k] * z[i, k]
