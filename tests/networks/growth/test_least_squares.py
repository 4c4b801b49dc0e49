import numpy as np
import pytest

from polydraulic.networks.growth.least_squares import add_rows, begin, carve, factor_of, solve_terms
from polydraulic.networks.model.nodes import LINEAR, TRIPLE, design

RNG = np.random.default_rng(0)
A = RNG.normal(size=(90, 5))
Y = A @ np.array([1.0, -2.0, 0.0, 0.5, 0.0]) + 0.1 * RNG.normal(size=90)
W = RNG.uniform(0.1, 2.0, size=90)
ALL = np.arange(5)


def factor(matrix, y, weight, cuts=(30, 70)):
    w = np.ones(len(y)) if weight is None else weight
    weighted = matrix * w[:, None]
    triangle = begin(weighted.T @ matrix, weighted.T @ y, w @ y**2)
    inputs = np.arange(matrix.shape[1])
    for part in np.split(np.arange(len(y)), cuts):
        add_rows(triangle, LINEAR, inputs, np.ascontiguousarray(matrix[part].T), y[part], np.sqrt(w[part]))
    return factor_of(triangle)


def squares(matrix, y, terms):
    return np.linalg.lstsq(matrix[:, terms], y)[1][0]


def test_blocks_give_least_squares():
    root = np.sqrt(W)
    expected = np.linalg.lstsq(A * root[:, None], Y * root)[0]
    fit = solve_terms(factor(A, Y, W), ALL)
    assert fit.coef == pytest.approx(expected, rel=1e-12)
    assert fit.squares == pytest.approx(W @ (Y - A @ expected) ** 2, rel=1e-12)


def test_weights_are_repetitions():
    times = RNG.integers(1, 4, 90)
    again = np.repeat(np.arange(90), times)
    weighted = solve_terms(factor(A, Y, times.astype(float)), ALL)
    repeated = solve_terms(factor(A[again], Y[again], None), ALL)
    assert weighted.coef == pytest.approx(repeated.coef, rel=1e-10)


@pytest.mark.parametrize("apart", [1e-3, 1e-5, 1e-7, 1e-9])
def test_nearly_dependent_columns_are_as_exact_as_by_orthogonal_least_squares(apart):
    """Normal equations alone tell columns apart down to 1e-8 of their length, and those with errors."""
    near = np.column_stack([A, A[:, 0] + apart * RNG.normal(size=90), A @ np.ones(5) + apart * RNG.normal(size=90)])
    y = near @ np.array([1.0, 0.0, 2.0, 0.0, 1.0, 0.0, 0.0]) + apart * RNG.normal(size=90)
    exact = np.linalg.qr(np.column_stack([near, y]), mode="r")
    found = factor(near, y, None)
    signs = np.sign(np.diagonal(exact)) * np.sign(np.diagonal(found))
    assert np.abs(found - signs[:, None] * exact).max() < 1e-13 * np.abs(exact).max() / apart**0.5
    assert np.diagonal(found) == pytest.approx(np.abs(np.diagonal(exact)), rel=1e-13 / apart)


def test_an_exact_fit_leaves_rounding():
    y = A @ np.arange(1.0, 6.0)
    assert solve_terms(factor(A, y, None), ALL).squares < 1e-28 * (y @ y)


def test_dependent_columns_share_the_coefficient():
    twin = np.column_stack([A[:, :2], A[:, 0]])
    fit = solve_terms(factor(twin, Y, W), np.arange(3))
    assert fit.coef[0] == pytest.approx(fit.coef[2])


def test_dependent_columns_are_carved_first():
    twins = np.column_stack([A, A[:, 1], A.sum(axis=1), np.zeros(90)])
    fit, plain = carve(factor(twins, Y, None), price=0.2), carve(factor(A, Y, None), price=0.2)
    assert np.count_nonzero(fit.coef) == 3
    assert fit.squares == pytest.approx(plain.squares, rel=1e-9)


def test_useless_terms_are_left_out():
    fit = carve(factor(A, Y, None), price=0.2)
    assert np.flatnonzero(fit.coef).tolist() == [0, 1, 3]
    kept = solve_terms(factor(A, Y, None), np.array([0, 1, 3]))
    assert fit.coef == pytest.approx(kept.coef)


@pytest.mark.parametrize("price", [0.1, 1.0, 30.0, 100.0])
def test_the_least_useful_term_goes_first(price):
    """Against trying to leave out each term in turn."""
    mixed = A @ RNG.normal(size=(5, 5))
    terms = list(range(5))
    while len(terms) > 1:
        loss, worst = min((squares(mixed, Y, [k for k in terms if k != i]), i) for i in terms)
        if loss - squares(mixed, Y, terms) >= price:
            break
        terms.remove(worst)
    assert np.flatnonzero(carve(factor(mixed, Y, None), price).coef).tolist() == terms


def test_free_terms_stay():
    assert np.count_nonzero(carve(factor(A, Y, W), price=0.0).coef) == 5


def test_one_term_always_stays():
    assert np.count_nonzero(carve(factor(A, Y, W), price=1e9).coef) == 1


def test_terms_that_explain_no_more_than_rounding_are_left_out_however_cheap():
    rng = np.random.default_rng(2)
    columns = rng.normal(size=(200, 5))
    y = 2.0 * columns[:, 1] - columns[:, 3]
    factor = np.linalg.qr(np.column_stack([columns, y]), mode="r")
    factor *= np.where(np.diag(factor) < 0.0, -1.0, 1.0)[:, None]  # as `factor_of` has it
    assert np.flatnonzero(carve(factor, 0.0).coef).tolist() == [1, 3]


@pytest.mark.parametrize("weight", [False, True])
def test_more_rows_than_are_multiplied_at_a_time(weight):
    v, y = RNG.normal(size=(3, 2300)), RNG.normal(size=2300)
    w = RNG.uniform(0.1, 2.0, size=2300) if weight else np.ones(2300)
    matrix = design(TRIPLE, v.T)
    triangle = begin((matrix * w[:, None]).T @ matrix, (matrix * w[:, None]).T @ y, w @ y**2)
    add_rows(triangle, TRIPLE, np.arange(3), v, y, np.sqrt(w))
    exact = np.linalg.qr(np.column_stack([matrix, y]) * np.sqrt(w)[:, None], mode="r")
    signs = np.sign(np.diagonal(exact))
    assert factor_of(triangle) == pytest.approx(signs[:, None] * exact, rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("terms", [[0], [1, 3, 4], [0, 1, 2, 3, 4]])
def test_some_of_the_terms(terms):
    expected = np.linalg.lstsq(A[:, terms], Y)[0]
    fit = solve_terms(factor(A, Y, None), np.array(terms))
    assert fit.coef[terms] == pytest.approx(expected, rel=1e-12)
    assert np.count_nonzero(fit.coef) == len(terms)
    assert fit.squares == pytest.approx(squares(A, Y, terms), rel=1e-12)
