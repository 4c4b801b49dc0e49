import numpy as np
import pytest
from scipy.optimize import approx_fprime

from polydraulic.networks.perceptron.back_propagation import Task, descend, loss_and_gradient, starting_weights


def task(*, n_row=30, n_input=3, **changes):
    rng = np.random.default_rng(1)
    share = rng.uniform(size=n_row)
    inputs = np.column_stack([rng.uniform(size=(n_row, n_input)), np.ones(n_row)])
    plain = Task(inputs, rng.uniform(size=n_row), share / share.sum(), 4, 0.8, 0.0, 0.0, True)
    return plain._replace(**changes)


@pytest.mark.parametrize("sigmoid", [True, False])
@pytest.mark.parametrize("settings", [{}, {"weight_cost": 0.3}, {"zero_error_radius": 0.1}, {"beta": 2.0}])
def test_gradient_is_the_slope_of_the_loss(sigmoid, settings):
    problem = task(sigmoid=sigmoid, **settings)
    weights = starting_weights(np.random.RandomState(2), problem, np.array([True, True, False]))
    weights += 0.1  # the third input has weights too
    slope = approx_fprime(weights, lambda w: loss_and_gradient(w, problem)[0], 1e-7)
    assert loss_and_gradient(weights, problem)[1] == pytest.approx(slope, abs=2e-7)
    assert np.abs(slope).max() > 1e-4


def test_blocks_of_rows_add_up():
    long = task(n_row=10_000)
    share = np.zeros(10_000)
    weights = starting_weights(np.random.RandomState(2), long, np.ones(3, dtype=bool))
    total, slope = 0.0, np.zeros_like(weights)
    for start in range(0, 10_000, 2500):
        share[:] = 0.0
        share[start : start + 2500] = long.share[start : start + 2500]
        loss, gradient = loss_and_gradient(weights, long._replace(share=share))
        total, slope = total + loss, slope + gradient
    loss, gradient = loss_and_gradient(weights, long)
    assert loss == pytest.approx(total, rel=1e-12)
    assert gradient == pytest.approx(slope, rel=1e-9, abs=1e-12)


def test_gradient_descent_steps_by_the_printed_rule():
    problem = task()
    start = starting_weights(np.random.RandomState(0), problem, np.ones(3, dtype=bool))
    first = start - 0.3 * loss_and_gradient(start, problem)[1]
    second = first - 0.3 * loss_and_gradient(first, problem)[1] + 0.9 * (first - start)
    assert descend(start, problem, 0.3, 0.9, 2, 0.0).weights == pytest.approx(second, rel=1e-12)
