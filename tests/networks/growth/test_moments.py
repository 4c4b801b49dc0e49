"""Tables of moments against sums written out."""

import numpy as np
import pytest

from polydraulic.networks.growth.moments import moments, moments_of_blocks, pair_row

RNG = np.random.default_rng(3)
V = RNG.normal(size=(300, 4))
T = np.sin(V[:, 0]) + V[:, 1] * V[:, 2] + 0.1 * RNG.normal(size=300)
W = RNG.uniform(0.0, 2.0, size=300)
SYMMETRIC = {"triple": np.s_[..., 0], "triple_target": np.s_[:], "square": np.s_[..., 1]}
TABLES = ("power", "pair_target", "triple", "triple_target", "square")


@pytest.mark.parametrize("weight", [None, W])
def test_every_entry_is_the_sum_it_stands_for(weight):
    m, w = moments(V, T, weight), np.ones(300) if weight is None else weight
    functions = np.column_stack([*(V[:, k] ** p for k in range(4) for p in (1, 2, 3, 4)), np.ones(300), T])
    assert m.weight == pytest.approx(w.sum())
    assert m.target_square == pytest.approx(w @ T**2)
    assert m.power == pytest.approx((functions * w[:, None]).T @ functions, rel=1e-10, abs=1e-9)
    assert m.pair_target == pytest.approx((V * (w * T)[:, None]).T @ V, rel=1e-10, abs=1e-9)
    for j in range(4):
        for i in range(j):
            pair, row = V[:, i] * V[:, j], pair_row(i, j)
            powers = np.stack([V, V**2, V**3, V**4], axis=2)
            assert m.triple[row] == pytest.approx(np.einsum("r,rkp->kp", w * pair, powers), rel=1e-10, abs=1e-9)
            assert m.triple_target[row] == pytest.approx((w * pair * T) @ V, rel=1e-10, abs=1e-9)
            assert m.square[row] == pytest.approx(np.einsum("r,rkp->kp", w * pair**2, powers[:, :, :2]), rel=1e-10)


def test_rows_are_cut_anywhere():
    whole = moments(V, T, W)
    parts = moments_of_blocks([(V[:100], T[:100], W[:100]), (V[100:], T[100:], W[100:])], 4)
    many = moments(np.tile(V, (9, 1)), np.tile(T, 9), np.tile(W, 9))  # more rows than are multiplied at a time
    for name in TABLES:
        assert getattr(parts, name) == pytest.approx(getattr(whole, name), rel=1e-11, abs=1e-9)
        assert getattr(many, name) == pytest.approx(9 * getattr(whole, name), rel=1e-11, abs=1e-8)


def test_weights_are_repetitions():
    times = RNG.integers(1, 4, 300)
    again = np.repeat(np.arange(300), times)
    weighted, repeated = moments(V, T, times.astype(float)), moments(V[again], T[again])
    assert weighted.weight == repeated.weight
    for name in TABLES:
        assert getattr(weighted, name) == pytest.approx(getattr(repeated, name), rel=1e-11, abs=1e-9)


@pytest.mark.parametrize("n_old", [1, 2, 3])
def test_only_triples_of_old_variables_are_left_out(n_old):
    whole, new = moments(V, T, W), moments_of_blocks([(V, T, W)], 4, n_old=n_old)
    for name in TABLES:
        table = getattr(new, name)
        old, same = np.zeros(table.shape, dtype=bool), np.zeros(table.shape, dtype=bool)
        if name not in ("power", "pair_target"):
            old[: pair_row(0, n_old), :n_old] = True
            for j in range(4):  # the same for all choices of the pair: known for one of them
                same[pair_row(0, j) : pair_row(0, j + 1), : j + 1][SYMMETRIC[name]] = True
        known = ~np.isnan(table)
        assert not known[old].any()
        assert known[~old & ~same].all()
        assert table[known] == pytest.approx(getattr(whole, name)[known], rel=1e-12, abs=1e-10)


@pytest.mark.parametrize("n_old", [0, 7, 17])
def test_of_many_variables_symmetric_entries_are_summed_for_one_choice_of_the_pair(n_old):
    v = RNG.normal(size=(500, 30))
    t = 1.0 + v[:, 0] - v[:, 1] * v[:, 2]
    m = moments_of_blocks([(v, t, None)], 30, n_old=n_old)
    for i, j, k in ((0, 1, 2), (3, 20, 29), (0, 28, 29), (5, 6, 17), (15, 16, 18), (2, 9, 18)):
        x, y, z = v[:, i], v[:, j], v[:, k]
        row = pair_row(i, j)
        known = [x @ (y * z**p) for p in (1, 2, 3, 4)] + [(x * y) @ (z * t)] + [(x * y) ** 2 @ z**p for p in (1, 2)]
        if k >= n_old:
            found = [*m.triple[row, k], m.triple_target[row, k], *m.square[row, k]]
            assert found == pytest.approx(known, rel=1e-9, abs=1e-9)
            other = pair_row(i, k)
            assert m.triple[other, j, 1:] == pytest.approx([(x * z) @ y**p for p in (2, 3, 4)], rel=1e-9, abs=1e-9)
            assert m.square[other, j, 0] == pytest.approx((x * z) ** 2 @ y, rel=1e-9, abs=1e-9)
        else:
            assert np.isnan(m.triple[row, k]).all()


def test_without_triples_their_tables_are_empty():
    m = moments(V, T, triples=False)
    assert (m.triple.size, m.triple_target.size, m.square.size) == (0, 0, 0)
    assert m.power == pytest.approx(moments(V, T).power, rel=1e-12)
