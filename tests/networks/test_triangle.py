import numpy as np
import pytest

from polydraulic.networks.triangle import carve, grow, solve

RNG = np.random.default_rng(0)
A = RNG.normal(size=(90, 5))
Y = A @ np.array([1.0, -2.0, 0.0, 0.5, 0.0]) + 0.1 * RNG.normal(size=90)
W = RNG.uniform(0.1, 2.0, size=90)
ALL = np.arange(5)


def factor_of(matrix, y, weight, cuts=(30, 70)):
    factor = None
    for part in np.split(np.arange(len(y)), cuts):
        factor = grow(factor, matrix[part], y[part], weight[part])
    return factor


def test_blocks_give_least_squares():
    root = np.sqrt(W)
    expected = np.linalg.lstsq(A * root[:, None], Y * root)[0]
    fit = solve(factor_of(A, Y, W), ALL)
    assert fit.coef == pytest.approx(expected, rel=1e-12)
    assert fit.squares == pytest.approx(W @ (Y - A @ expected) ** 2, rel=1e-12)


def test_weights_are_repetitions():
    times = RNG.integers(1, 4, 90)
    again = np.repeat(np.arange(90), times)
    weighted = solve(factor_of(A, Y, times.astype(float)), ALL)
    repeated = solve(factor_of(A[again], Y[again], np.ones(len(again))), ALL)
    assert weighted.coef == pytest.approx(repeated.coef, rel=1e-10)


def test_dependent_columns_share_the_coefficient():
    twin = np.column_stack([A[:, :2], A[:, 0]])
    fit = solve(factor_of(twin, Y, W), np.arange(3))
    assert fit.coef[0] == pytest.approx(fit.coef[2])


def test_useless_terms_are_left_out():
    fit = carve(factor_of(A, Y, np.ones(90)), price=0.2)
    assert np.flatnonzero(fit.coef).tolist() == [0, 1, 3]
    kept = solve(factor_of(A, Y, np.ones(90)), np.array([0, 1, 3]))
    assert fit.coef == pytest.approx(kept.coef)


def test_free_terms_stay():
    assert np.count_nonzero(carve(factor_of(A, Y, W), price=0.0).coef) == 5


def test_one_term_always_stays():
    assert np.count_nonzero(carve(factor_of(A, Y, W), price=1e9).coef) == 1
