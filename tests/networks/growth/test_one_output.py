import numpy as np
import pytest

from polydraulic import AbductiveRegressor

FRESH = 2000


def fitted(X, y, n, **settings):
    """An estimator of the first rows, and its R2 on the others."""
    model = AbductiveRegressor(**settings).fit(X[:n], y[:n])
    error = np.mean((model.predict(X[n:]) - y[n:]) ** 2)
    return model, float(1.0 - error / np.mean((y[n:] - y[:n].mean()) ** 2))


@pytest.mark.parametrize("n_input", [3, 20])
@pytest.mark.parametrize("n", [20, 60, 300])
def test_noise_is_a_constant(n, n_input):
    found = []
    for seed in range(8):
        rng = np.random.default_rng([seed, n, n_input])
        X, y = rng.normal(size=(n, n_input)), (rng.normal(size=n), rng.standard_t(2, size=n))[seed % 2]
        found.append(len(AbductiveRegressor().fit(X, y).network_.nodes))
    assert np.count_nonzero(found) <= 2  # each with a probability of a twentieth at most: more in 1 of 170


@pytest.mark.slow
def test_of_tables_of_noise_fewer_than_one_in_twenty_are_left_with_a_network():
    found = []
    for n in (20, 50, 100, 200, 500, 2000):
        for n_input in (3, 10, 30, 60):
            for seed in range(10):
                rng = np.random.default_rng([seed, n, n_input])
                X, y = rng.normal(size=(n, n_input)), (rng.normal(size=n), rng.standard_t(3, size=n))[seed % 2]
                found.append(len(AbductiveRegressor().fit(X, y).network_.nodes))
    assert np.count_nonzero(found) < len(found) / 20


def test_noise_among_many_inputs_was_not_a_constant_by_the_predicted_squared_error_alone():
    rng = np.random.default_rng(1)
    X, y = rng.normal(size=(100 + FRESH, 20)), rng.normal(size=100 + FRESH)
    historical, its_r2 = fitted(X, y, 100, leave_one_out=False)
    assert historical.network_.nodes
    assert its_r2 < -0.2
    model, r2 = fitted(X, y, 100)
    assert model.network_.nodes == ()
    assert r2 == pytest.approx(0.0, abs=1e-9)
    assert model.fse_ == pytest.approx(np.var(y[:100]))
    assert len(model.history_) > 1  # the layers that were tried


def test_slow_noise_of_a_log_is_a_constant():
    found = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        kernel = np.exp(-np.arange(200) / 50.0)
        slow = np.column_stack([np.convolve(rng.normal(size=2199), kernel, "valid") for _ in range(11)])
        found.append(len(AbductiveRegressor().fit(slow[:, :10], slow[:, 10]).network_.nodes))
    assert np.count_nonzero(found) <= 1


def test_what_is_left_of_a_weak_relation_among_many_inputs_is_found():
    gained = []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        X = rng.normal(size=(100 + FRESH, 20))
        gained.append(fitted(X, X[:, 7] + rng.normal(size=100 + FRESH), 100)[1])
    assert np.median(gained) > 0.4  # of a half


def test_a_relation_in_few_rows_far_out_is_kept_if_it_helps_on_others():
    rng = np.random.default_rng(4)
    X = rng.standard_t(2, size=(300, 3))
    model = AbductiveRegressor().fit(X, 2.0 * X[:, 1] + 0.1 * rng.normal(size=300))
    assert {slot for node in model.network_.nodes for slot in node.inputs if slot < 3} >= {1}
