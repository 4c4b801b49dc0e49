import numpy as np
import pytest

from polydraulic.networks.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE, design, least_squares

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


def test_weights_are_repetitions():
    target = np.sin(x) + y
    weight = np.random.default_rng(1).integers(0, 4, 50)
    matrix = design(DOUBLE, X[:, :2])
    repeated = np.repeat(np.arange(50), weight)
    weighted = least_squares(matrix, target, weight.astype(float))
    assert weighted == pytest.approx(least_squares(matrix[repeated], target[repeated], None), rel=1e-9)
