"""Weighted moments of a set of variables: all that the least-squares fit of every possible node needs.

A triple of variables x, y, z has fourteen terms, and the products of two terms contain only moments of the forms
<x^a y^b>, <x y z^c>, <x^2 y^2 z^c>, each with c at most 4, 2. They come from a few matrix products over the rows, summed in
place block by block; after that a candidate node costs no pass over the data.
"""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk

_ROWS = 384  # multiplied at a time: enough for matrix products, and few enough for the cache
_PAIRS = 128  # multiplied at a time, at least, and hardly more

Block = tuple[np.ndarray, np.ndarray, np.ndarray | None]


class Moments(NamedTuple):
    """Weighted sums of products over rows, for n variables v and a target t.

    Tables with three variables have one row a pair i < j, at `pair_row`. Entries between variables that were scored
    before (`n_old`) are NaN there. Entries that are the same for all three choices of the pair may be NaN unless k > j.
    """

    weight: float  # sum of the weights; the number of rows where there are none
    power: np.ndarray  # (4 n + 2, 4 n + 2): <a b> of v_k^p at 4 k + p - 1, p = 1 .. 4, then 1, then t
    pair_target: np.ndarray  # (n, n): <v_i v_j t>
    triple: np.ndarray  # (n_pair, n, 4): <v_i v_j v_k^p>, p = 1 .. 4; of p = 1 the same for all choices
    triple_target: np.ndarray  # (n_pair, n): <v_i v_j v_k t>, the same
    square: np.ndarray  # (n_pair, n, 2): <v_i^2 v_j^2 v_k^p>, p = 1, 2; of p = 2 the same

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
        for start in range(0, len(v), _ROWS):
            rows = slice(start, start + _ROWS)
            sums.add(v[rows].T, t[rows], None if weight is None else weight[rows])
    return sums.moments()


class _Sums:
    """Sums over the rows seen so far. A variable is a row here, so that all products run along memory."""

    def __init__(self, n: int, n_old: int, triples: bool) -> None:
        self.n = n
        self.weight = 0.0
        self.power = np.zeros((4 * n + 2, 4 * n + 2))
        self.pair_target = np.zeros((n, n))
        self.parts = _parts(n, n_old) if triples else []
        most = max((part.n_pair for part in self.parts), default=0)
        # used again for all rows: memory that is new to the process takes longer than what is done in it
        self.memory = [np.empty(rows * _ROWS) for rows in (4 * n + 2, 5 * n, 2 * n, most)]

    def add(self, v: np.ndarray, t: np.ndarray, weight: np.ndarray | None) -> None:
        """Add rows; `v` is (n, n_row)."""
        n, n_row = self.n, t.size
        plain, for_pairs, for_squares, products = (
            memory[: len(memory) // _ROWS * n_row].reshape(-1, n_row) for memory in self.memory
        )
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
        if not self.parts:
            return
        powers = weighted[: 4 * n].reshape(n, 4, n_row)
        for_pairs[: 2 * n : 2], for_pairs[1 : 2 * n : 2] = powers[:, 0], with_target
        for_pairs[2 * n :].reshape(n, 3, n_row)[:] = powers[::-1, 1:]
        for_squares[:n], for_squares[n:] = powers[:, 1], powers[::-1, 0]
        for part in self.parts:
            pairs = products[: part.n_pair]
            for j in range(part.first, part.end):
                row = pair_row(0, j) - pair_row(0, part.first)
                np.multiply(first[:j], first[j], out=pairs[row : row + j])
            _add_product(part.pair, pairs, for_pairs[2 * part.rising : 5 * n - 3 * part.old])
            np.multiply(pairs, pairs, out=pairs)
            _add_product(part.square, pairs, for_squares[part.rising : 2 * n - part.old])

    def moments(self) -> Moments:
        """What has been summed; of symmetric tables only one half was."""
        power = np.triu(self.power) + np.triu(self.power, 1).T
        n, n_pair = self.n, pair_row(0, self.n) if self.parts else 0
        triple, triple_target = np.full((n_pair, n, 4), np.nan), np.full((n_pair, n), np.nan)
        square = np.full((n_pair, n, 2), np.nan)
        for part in self.parts:
            rows = slice(pair_row(0, part.first), pair_row(0, part.end))
            n_rising, n_all = n - part.rising, n - part.old
            triple[rows, part.rising :, 0] = part.pair[:, : 2 * n_rising : 2]
            triple_target[rows, part.rising :] = part.pair[:, 1 : 2 * n_rising : 2]
            triple[rows, part.old :, 1:] = part.pair[:, 2 * n_rising :].reshape(-1, n_all, 3)[:, ::-1]
            square[rows, part.rising :, 1] = part.square[:, :n_rising]
            square[rows, part.old :, 0] = part.square[:, : n_rising - 1 : -1]
        return Moments(self.weight, power, self.pair_target, triple, triple_target, square)


class _Part(NamedTuple):
    """Sums of the pairs i < j of first <= j < end, with functions of each variable k, those first that are the same whichever two are the pair.

    These are summed for variables from `rising` on, in rising order, and all others from `old` on, in falling order, so that
    what a part needs stands together in the functions of all variables.
    """

    first: int
    end: int
    rising: int
    old: int
    pair: np.ndarray  # (n_pair, n_function): pairs with v_k, v_k t; and v_k^2, v_k^3, v_k^4
    square: np.ndarray  # (n_pair, n_function): squares of pairs with v_k^2; and v_k

    @property
    def n_pair(self) -> int:
        return len(self.pair)


def _parts(n: int, n_old: int) -> list[_Part]:
    """All pairs of `n` variables, without old pairs with old variables."""
    parts, first = [], 0
    for end in range(1, n + 1):
        n_pair = pair_row(0, end) - pair_row(0, first)
        if end in (n_old, n) or n_pair >= _PAIRS:
            rising, old = max(first, n_old), n_old if end <= n_old else 0
            sizes = (2 * (n - rising) + 3 * (n - old), 2 * n - rising - old)
            parts.append(_Part(first, end, rising, old, *(np.zeros((n_pair, size)) for size in sizes)))
            first = end
    return parts


def _add_product(total: np.ndarray, left: np.ndarray, right: np.ndarray) -> None:
    """Add left @ right.T to a total in place; BLAS counts columns first, hence the transposes."""
    if total.size:
        dgemm(1.0, right.T, left.T, 1.0, total.T, trans_a=True, overwrite_c=True)
