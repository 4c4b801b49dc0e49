"""Slopes against differences of predictions, and the distance outside of the domain."""

import numpy as np
import pytest

from helpers.exports import NAMES
from polydraulic.networks import Model, Network, Node, Variable, distance_outside, model_slopes


@pytest.fixture(scope="module")
def models():
    from helpers.exports import made

    return made()


@pytest.mark.parametrize("which", NAMES)
def test_slopes_are_those_of_differences(which, models):
    model = models[which][0]
    low, high = model.domain().T
    X = low + (high - low) * np.random.default_rng(0).uniform(-0.2, 1.2, size=(300, len(low)))
    slopes = model_slopes(model, X)
    assert np.abs(slopes).max() > 0.0 or which == "constant"
    for i in range(len(low)):
        step = np.zeros(len(low))
        step[i] = 1e-6 * (high[i] - low[i])
        change = (model.predict(X + step) - model.predict(X - step)) / 2e-6
        close = np.abs(slopes[:, i] * (high[i] - low[i]) - change) <= 1e-6 * np.abs(change).max() + 1e-9
        assert np.mean(close) > 0.99  # a border may lie between


def test_slopes_are_0_where_something_is_clamped_and_one_sided_on_borders():
    line = Network((Node(0, (0,), (0.0, 2.0, 0.0, 0.0)),), (0.0,), (1.0,), (-1.0,), (3.0,), 0.0, 1.0, -1.0, 4.0)
    model = Model((Variable("x"),), Variable("y"), (line,))
    X = np.array([[-2.0], [-1.0], [-0.5], [0.0], [2.0], [2.5], [3.0], [4.0]])
    assert model_slopes(model, X)[:, 0].tolist() == [0.0, 0.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0]


def test_distance_is_a_share_of_the_width_of_the_region_that_answers(models):
    model = models["regions"][0]
    X = np.random.default_rng(0).uniform(-1.5, 1.5, size=(500, 3))
    far = distance_outside(model, X)
    assert np.array_equal(far == 0.0, model.inside(X))
    assert 0.0 < far.max() < 1.5
    flat = Network((), (0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (2.0, 4.0), 0.0, 1.0)
    model = Model((Variable("a"), Variable("b")), Variable("y"), (flat,))
    X = np.array([[2.0, 1.0], [2.5, 1.0], [2.0, 5.0], [2.0, -2.0]])
    assert distance_outside(model, X).tolist() == [0.0, 0.5, 0.25, 0.5]
