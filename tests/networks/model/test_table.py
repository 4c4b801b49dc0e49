import numpy as np
import pytest
from hypothesis import given

from helpers.random_networks import model_of, networks
from polydraulic.networks.model.nodes import RAMP, SIGMOID, design


def by_terms(network, X):
    """The network from its terms, row by row of the definition."""
    v = (np.clip(X, network.x_low, network.x_high) - network.x_mean) / np.array(network.x_scale)
    last = np.zeros(len(X))
    for node in network.nodes:
        last = design(node.kind, v[:, list(node.inputs)]) @ np.array(node.coef)
        if node.kind == SIGMOID:
            last = 0.5 + 0.5 * np.tanh(0.5 * last)
        elif node.kind == RAMP:
            last = np.clip(last, 0.0, 1.0)
        v = np.column_stack([v, last])
    return np.clip(network.y_mean + network.y_scale * last, network.y_low, network.y_high)


@given(networks())
def test_evaluation_is_the_sum_of_the_terms(network):
    X = np.random.default_rng(0).uniform(-2.0, 2.5, size=(20, network.n_inputs))
    expected = by_terms(network, X)
    with np.errstate(all="ignore"):
        size = 1.0 + np.abs(expected)
    assert np.all(np.abs(model_of(network).predict(X) - expected) < 1e-6 * size)


@given(networks(n_input=2), networks(n_input=2), networks(n_input=2))
def test_a_value_on_an_edge_belongs_below(a, b, c):
    model = model_of(a, b, c, edges={1: (0.0, 0.5)})
    X = np.array([[0.3, -0.1], [0.3, 0.0], [0.3, 0.25], [0.3, 0.5], [0.3, 0.51]])
    for row, network in zip(X, (a, a, b, b, c), strict=True):
        assert model.predict(row[None]) == pytest.approx(model_of(network).predict(row[None]))
