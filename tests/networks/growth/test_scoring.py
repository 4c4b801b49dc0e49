"""Scores from moments against least squares on the rows."""

import numpy as np
import pytest

from polydraulic.networks.growth.moments import moments
from polydraulic.networks.growth.scoring import normal_equations, squared_errors
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE, design

RNG = np.random.default_rng(3)
V = RNG.normal(size=(300, 4))
T = np.sin(V[:, 0]) + V[:, 1] * V[:, 2] + 0.1 * RNG.normal(size=300)
W = RNG.uniform(0.0, 2.0, size=300)
CANDIDATES = {  # in any order
    SINGLE: np.array([[0], [3]]),
    DOUBLE: np.array([[0, 1], [3, 1], [2, 3]]),
    TRIPLE: np.array([[0, 1, 2], [3, 2, 0], [2, 1, 3]]),
    LINEAR: np.array([[0, 1, 2, 3]]),
}


@pytest.mark.parametrize("kind", CANDIDATES)
@pytest.mark.parametrize("weight", [None, W])
def test_every_entry_of_the_normal_equations(kind, weight):
    gram, right = normal_equations(moments(V, T, weight), kind, CANDIDATES[kind])
    for k, inputs in enumerate(CANDIDATES[kind]):
        matrix = design(kind, V[:, inputs])
        weighted = matrix if weight is None else matrix * weight[:, None]
        assert gram[k] == pytest.approx(weighted.T @ matrix, rel=1e-10, abs=1e-8)
        assert right[k] == pytest.approx(weighted.T @ T, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("kind", CANDIDATES)
def test_errors_are_those_of_least_squares(kind):
    found = squared_errors(moments(V, T), kind, CANDIDATES[kind])
    for error, inputs in zip(found, CANDIDATES[kind], strict=True):
        matrix = design(kind, V[:, inputs])
        residual = T - matrix @ np.linalg.lstsq(matrix, T)[0]
        assert error == pytest.approx(np.mean(residual**2), rel=1e-9)


def test_triples_of_many_variables_in_any_order():
    """So many that the moments are summed in parts."""
    v = RNG.normal(size=(300, 30))
    inputs = np.array([[29, 3, 17], [3, 17, 29], [17, 29, 3], [20, 28, 1], [0, 1, 2]])
    gram, right = normal_equations(moments(v, T), TRIPLE, inputs)
    for k, chosen in enumerate(inputs):
        matrix = design(TRIPLE, v[:, chosen])
        assert gram[k] == pytest.approx(matrix.T @ matrix, rel=1e-10, abs=1e-8)
        assert right[k] == pytest.approx(matrix.T @ T, rel=1e-10, abs=1e-8)


def test_many_candidates_are_scored_like_one():
    """More than are held at a time."""
    m = moments(V, T)
    inputs = np.tile(CANDIDATES[DOUBLE], (300, 1))
    assert np.array_equal(squared_errors(m, DOUBLE, inputs), np.tile(squared_errors(m, DOUBLE, inputs[:3]), 300))


def test_no_candidates_have_no_errors():
    assert squared_errors(moments(V, T), TRIPLE, np.zeros((0, 3), dtype=int)).shape == (0,)


def test_dependent_columns_do_no_harm():
    twin = np.column_stack([V[:, 0], V[:, 0], 2.0 * V[:, 0] + 1.0])
    single = squared_errors(moments(twin, T), SINGLE, np.array([[0]]))[0]
    double = squared_errors(moments(twin, T), DOUBLE, np.array([[0, 1], [0, 2]]))
    assert double == pytest.approx([single, single], rel=1e-6)
