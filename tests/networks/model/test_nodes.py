import numpy as np
import pytest

from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE, design, slopes, terms, without_idle_inputs

X = np.random.default_rng(0).normal(size=(50, 3))
ONE = np.ones(50)
x, y, z = X.T


@pytest.mark.parametrize(
    ("kind", "inputs", "expected"),
    [
        (SINGLE, X[:, :1], [ONE, x, x**2, x**3]),
        (DOUBLE, X[:, :2], [ONE, x, y, x**2, y**2, x * y, x**3, y**3]),
        (
            TRIPLE,
            X,
            [ONE, x, y, z, x**2, y**2, z**2, x * y, x * z, y * z, x * y * z, x**3, y**3, z**3],
        ),
        (LINEAR, X, [x, y, z]),
    ],
)
def test_terms_are_those_printed_in_the_thesis(kind, inputs, expected):
    assert design(kind, inputs) == pytest.approx(np.column_stack(expected), rel=1e-14)


@pytest.mark.parametrize(("kind", "size"), [(DOUBLE, 2), (TRIPLE, 3), (LINEAR, 3)])
@pytest.mark.parametrize("idle", [0, 1])
def test_inputs_that_no_term_reads_are_left_out(kind, size, idle):
    coef = np.random.default_rng(4).normal(size=design(kind, X[:, :size]).shape[1])
    coef[[bool(exponents[idle]) for exponents in terms(kind, size)]] = 0.0
    smaller, kept, values = without_idle_inputs(kind, coef)
    assert kept == [j for j in range(size) if j != idle]
    assert design(smaller, X[:, kept]) @ values == pytest.approx(design(kind, X[:, :size]) @ coef)


def test_a_constant_is_a_single():
    assert without_idle_inputs(DOUBLE, np.array([2.0, 0, 0, 0, 0, 0, 0, 0]))[:2] == (SINGLE, [0])


@pytest.mark.parametrize(("kind", "size"), [(SINGLE, 1), (DOUBLE, 2), (TRIPLE, 3), (LINEAR, 3)])
def test_slopes_are_derivatives(kind, size):
    coef = np.random.default_rng(2).normal(size=design(kind, X[:, :size]).shape[1])
    found = slopes(kind, X[:, :size], coef)
    for j in range(size):
        step = np.zeros(size)
        step[j] = 1e-6
        ahead, behind = (design(kind, X[:, :size] + sign * step) @ coef for sign in (1, -1))
        assert found[:, j] == pytest.approx((ahead - behind) / 2e-6, rel=1e-6, abs=1e-7)
