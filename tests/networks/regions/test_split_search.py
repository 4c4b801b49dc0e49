import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.networks.regions.split_search import best_cut

RNG = np.random.default_rng(4)
X = RNG.uniform(size=(600, 3))
ONES = np.ones(600)


@given(st.floats(0.1, 0.9), st.integers(0, 2))
def test_the_border_of_two_polynomials_is_found(at, axis):
    above = X[:, axis] > at
    y = np.where(above, 1.0 + X[:, 0] * X[:, 2], X[:, 1] ** 2)[:, None]
    cut = best_cut(X, y, ONES, 20)
    assert cut.axis == axis
    assert X[~above, axis].max() < cut.at < X[above, axis].min()
    assert cut.squares < 1e-6


def test_the_error_is_that_of_two_fits():
    y = np.exp(3.0 * X[:, :1]) * X[:, 1:2]
    cut = best_cut(X, y, ONES, 100)
    squares = 0.0
    exponents = [(i, j, k) for i in range(4) for j in range(4 - i) for k in range(4 - i - j)]
    for side in (X[:, cut.axis] <= cut.at, X[:, cut.axis] > cut.at):
        assert side.sum() >= 100
        terms = np.column_stack([np.prod(X[side] ** e, axis=1) for e in exponents])
        squares += np.linalg.lstsq(terms, y[side])[1].sum()
    assert cut.squares == pytest.approx(squares, rel=1e-3)


def test_rows_of_weight_zero_do_not_matter():
    y = np.abs(X[:, :1] - 0.4)
    weight = (np.arange(600) < 500).astype(float)
    wild = np.where(weight[:, None] > 0.0, y, 1e3)
    assert best_cut(X, wild, weight, 50).at == pytest.approx(0.4, abs=0.01)


def test_nothing_can_be_cut_where_values_are_equal_or_rows_few():
    same = np.ones((50, 2))
    assert best_cut(same, np.arange(50.0)[:, None], np.ones(50), 5) is None
    assert best_cut(X[:50], X[:50, :1], np.ones(50), 26) is None
    steps = np.repeat([0.0, 1.0], 25)[:, None]
    assert best_cut(steps, steps, np.ones(50), 5).at == 0.5
