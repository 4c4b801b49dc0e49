"""Terms and outputs of nodes on rows, by compiled loops, against design matrices."""

import numpy as np
import pytest

from polydraulic.networks.growth.variables import (
    GrownVariable,
    count_before,
    fill_terms,
    node_output,
    steps_table,
    variable_values,
)
from polydraulic.networks.model.nodes import DOUBLE, LINEAR, SINGLE, TRIPLE, design, terms
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(5)
X = RNG.normal(size=(300, 4))  # more rows than terms are held of at a time
INPUTS = {SINGLE: (2,), DOUBLE: (3, 0), TRIPLE: (1, 3, 0), LINEAR: (0, 1, 3)}


def node(kind, slots):
    return Node(kind, slots, tuple(RNG.normal(size=len(terms(kind, len(slots)))).tolist()))


@pytest.mark.parametrize("kind", INPUTS)
def test_terms_are_those_of_the_design_matrix(kind):
    slots, root = np.array(INPUTS[kind]), RNG.uniform(size=300)
    n_term = len(terms(kind, len(slots)))
    columns = np.full((n_term + 1, 60), np.nan)
    fill_terms(X.T.copy(), root, slots, steps_table(kind, len(slots)), 200, 250, columns)
    expected = design(kind, X[200:250, slots]) * root[200:250, None]
    filled = columns[:n_term, :50].T
    assert filled == pytest.approx(expected, rel=1e-14)
    assert np.isnan(columns[n_term:]).all()
    assert np.isnan(columns[:, 50:]).all()


@pytest.mark.parametrize("kind", INPUTS)
def test_output_is_the_sum_of_its_terms(kind):
    one = node(kind, INPUTS[kind])
    expected = design(kind, X[:, one.inputs]) @ np.array(one.coef)
    assert node_output(one, X.T.copy(), np.empty(300)) == pytest.approx(expected, rel=1e-12, abs=1e-13)


def test_nodes_read_nodes_before_them():
    inputs = [GrownVariable(None, frozenset(), 0) for _ in range(4)]
    first, second = node(DOUBLE, (0, 2)), node(TRIPLE, (1, 3, 4))
    grown = [*inputs, GrownVariable(first, frozenset({4}), 8), GrownVariable(second, frozenset({4, 5}), 14)]
    values = variable_values(grown, X)
    assert np.array_equal(values[:4], X.T)
    assert np.array_equal(values[4], node_output(first, values, np.empty(300)))
    assert values[5] == pytest.approx(design(TRIPLE, values[[1, 3, 4]].T) @ np.array(second.coef), rel=1e-12, abs=1e-13)


def test_coefficients_of_nodes_that_several_inputs_need_count_once():
    needed = np.array([[False, False, False], [True, False, False], [True, True, False], [False, False, True]])
    inputs, k = np.array([[0, 1], [1, 2], [2, 3], [0, 0]]), np.full(4, 8)
    count_before(needed, np.array([3, 5, 14]), inputs, k)
    assert k.tolist() == [11, 16, 30, 8]
