"""Tables of moments against sums written out."""

import numpy as np
import pytest

from polydraulic.networks.growth.moments import moments, moments_of_blocks, pair_row

RNG = np.random.default_rng(3)
V = RNG.normal(size=(300, 4))
T = np.sin(V[:, 0]) + V[:, 1] * V[:, 2] + 0.1 * RNG.normal(size=300)
W = RNG.uniform(0.0, 2.0, size=300)
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
        old = np.zeros(table.shape, dtype=bool)
        if name not in ("power", "pair_target"):
            old[: pair_row(0, n_old), :n_old] = True
        assert np.array_equal(np.isnan(table), old)
        assert table[~old] == pytest.approx(getattr(whole, name)[~old], rel=1e-12, abs=1e-10)


def test_without_triples_their_tables_are_empty():
    m = moments(V, T, triples=False)
    assert (m.triple.size, m.triple_target.size, m.square.size) == (0, 0, 0)
    assert m.power == pytest.approx(moments(V, T).power, rel=1e-12)
