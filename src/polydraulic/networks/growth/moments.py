"""Weighted moments of a set of variables: all that the least-squares fit of every possible node needs.

A triple of variables x, y, z has fourteen terms, and the products of two terms contain only moments of the forms
<x^a y^b>, <x y z^c>, <x^2 y^2 z^c>, each with c at most 4, 2. They come from a few matrix products over the rows, summed in
place block by block; after that a candidate node costs no pass over the data.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk

_FEWEST_ROWS, _MOST_ROWS = 256, 1024  # multiplied at a time
_CACHED = 1 << 18  # products of pairs held at a time, while that leaves enough rows

Block = tuple[np.ndarray, np.ndarray, np.ndarray | None]


class Moments(NamedTuple):
    """Weighted sums of products over rows, for n variables v and a target t.

    Tables with three variables have one row a pair i < j, at `pair_row`. Entries between variables that were scored
    before (`n_old`) are NaN there.
    """

    weight: float  # sum of the weights; the number of rows where there are none
    power: np.ndarray  # (4 n + 2, 4 n + 2): <a b> of v_k^p at 4 k + p - 1, p = 1 .. 4, then 1, then t
    pair_target: np.ndarray  # (n, n): <v_i v_j t>
    triple: np.ndarray  # (n_pair, n, 4): <v_i v_j v_k^p>, p = 1 .. 4
    triple_target: np.ndarray  # (n_pair, n): <v_i v_j v_k t>
    square: np.ndarray  # (n_pair, n, 2): <v_i^2 v_j^2 v_k^p>, p = 1, 2

    @property
    def target_square(self) -> float:
        """<t^2>."""
        return float(self.power[-1, -1])


def pair_row(i: int, j: int) -> int:
    """Row of the pair i < j in the tables with three variables; pairs with later variables come later."""
    return j * (j - 1) // 2 + i


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
    return moments_of_blocks([(v, t, weight)], v.shape[1], triples=triples)


def moments_of_blocks(blocks: Iterable[Block], n: int, *, n_old: int = 0, triples: bool = True) -> Moments:
    """Moments of rows that come block by block.

    Parameters
    ----------
    blocks : iterable of (v, t, weight)
        As in `moments`; the weight may be None.
    n : int
        Number of variables.
    n_old : int
        How many of the first variables were scored before: moments of three of them are left out.
    triples : bool
    """
    sums = _Sums(n, n_old, triples)
    for v, t, weight in blocks:
        for start in range(0, len(v), sums.n_row):
            rows = slice(start, start + sums.n_row)
            sums.add(v[rows].T, t[rows], None if weight is None else weight[rows])
    return sums.moments()


class _Sums:
    """Sums over the rows seen so far. A variable is a row here, so that all products run along memory."""

    def __init__(self, n: int, n_old: int, triples: bool) -> None:
        n_pair = pair_row(0, n) if triples else 0
        self.n, self.n_old = n, n_old
        self.n_row = int(np.clip(_CACHED // max(n_pair, 1), _FEWEST_ROWS, _MOST_ROWS))
        self.weight = 0.0
        self.power = np.zeros((4 * n + 2, 4 * n + 2))
        self.pair_target = np.zeros((n, n))
        self.triple = _PairTable(n, n_old, 4, triples)
        self.triple_target = _PairTable(n, n_old, 1, triples)
        self.square = _PairTable(n, n_old, 2, triples)
        self.pairs = np.empty((n_pair, self.n_row))

    def add(self, v: np.ndarray, t: np.ndarray, weight: np.ndarray | None) -> None:
        """Add rows; `v` is (n, n_row)."""
        n, n_row = self.n, t.size
        plain = np.empty((4 * n + 2, n_row))
        powers = plain[: 4 * n].reshape(n, 4, n_row)
        powers[:, 0] = v
        np.multiply(powers[:, 0], powers[:, 0], out=powers[:, 1])
        np.multiply(powers[:, 1], powers[:, 0], out=powers[:, 2])
        np.multiply(powers[:, 1], powers[:, 1], out=powers[:, 3])
        plain[-2], plain[-1] = 1.0, t
        first = np.ascontiguousarray(powers[:, 0])
        if weight is None:
            self.weight += n_row
            weighted = plain
            dsyrk(1.0, plain.T, 1.0, self.power.T, trans=True, lower=True, overwrite_c=True)
        else:
            self.weight += float(weight.sum())
            weighted = plain * weight
            _add_product(self.power, weighted, plain)
        with_target = first * weighted[-1]
        _add_product(self.pair_target, first, with_target)
        if not self.pairs.size:
            return
        pairs = self.pairs if n_row == self.n_row else np.empty((len(self.pairs), n_row))
        for j in range(n):
            np.multiply(first[:j], first[j], out=pairs[pair_row(0, j) : pair_row(0, j + 1)])
        self.triple.add(pairs, weighted[:-2])
        self.triple_target.add(pairs, with_target)
        np.multiply(pairs, pairs, out=pairs)
        self.square.add(pairs, weighted[:-2].reshape(n, 4, n_row)[:, :2].reshape(2 * n, n_row))

    def moments(self) -> Moments:
        """What has been summed; of symmetric tables only one half was."""
        power = np.triu(self.power) + np.triu(self.power, 1).T
        triple, square = self.triple.whole(), self.square.whole()
        return Moments(
            weight=self.weight,
            power=power,
            pair_target=self.pair_target,
            triple=triple.reshape(len(triple), self.n, 4),
            triple_target=self.triple_target.whole(),
            square=square.reshape(len(square), self.n, 2),
        )


class _PairTable:
    """Sums of pairs times some functions of each variable, without those of old pairs with old variables."""

    def __init__(self, n: int, n_old: int, n_function: int, used: bool) -> None:
        self.n_pair, self.n_old_pair = (pair_row(0, n), pair_row(0, n_old)) if used else (0, 0)
        self.n_column, self.n_old_column = n * n_function, n_old * n_function
        self.of_old = np.zeros((self.n_old_pair, self.n_column - self.n_old_column))
        self.of_new = np.zeros((self.n_pair - self.n_old_pair, self.n_column))

    def add(self, pairs: np.ndarray, functions: np.ndarray) -> None:
        _add_product(self.of_old, pairs[: self.n_old_pair], functions[self.n_old_column :])
        _add_product(self.of_new, pairs[self.n_old_pair :], functions)

    def whole(self) -> np.ndarray:
        table = np.full((self.n_pair, self.n_column), np.nan)
        table[: self.n_old_pair, self.n_old_column :] = self.of_old
        table[self.n_old_pair :] = self.of_new
        return table


def _add_product(total: np.ndarray, left: np.ndarray, right: np.ndarray) -> None:
    """Add left @ right.T to a total in place; BLAS counts columns first, hence the transposes."""
    if total.size:
        dgemm(1.0, right.T, left.T, 1.0, total.T, trans_a=True, overwrite_c=True)
