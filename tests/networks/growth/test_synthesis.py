from itertools import combinations

import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.synthesis import _rising

RNG = np.random.default_rng(7)
X = RNG.uniform(-1.0, 1.0, size=(400, 3))


@pytest.mark.parametrize(
    "target",
    [
        lambda x, y, z: 1.0 + 2.0 * x - x**3,
        lambda x, y, z: x * y - y**2,
        lambda x, y, z: x * y * z + z**3,
    ],
)
def test_known_networks_are_found_again(target):
    y = target(*X.T)
    model = AbductiveRegressor().fit(X, y)
    assert np.abs(model.predict(X) - y).max() < 1e-6 * np.ptp(y)


@pytest.mark.parametrize("prior", ["adaptive", "half-variance", 0.3])
@pytest.mark.parametrize("carve", [False, True])
def test_pse_is_fse_plus_penalty(prior, carve):
    y = np.exp(X[:, 0]) * np.cos(3 * X[:, 1])
    settings = {"prior_variance": prior, "cpm": 1.5, "max_layers": 3, "carve": carve}
    model = AbductiveRegressor(refine=False, **settings).fit(X, y)
    chosen = [step for step in model.history_ if step.accepted][-1]
    if prior != "adaptive":  # that prior follows the network itself once it is chosen
        assert model.pse_ == pytest.approx(model.fse_ + chosen.penalty)
    assert model.fse_ == pytest.approx(np.mean((model.predict(X) - y) ** 2), rel=1e-9)
    assert chosen.n_coefficients == model.network_.n_coefficients
    if prior != "adaptive":
        s2 = np.var(y) / 2 if prior == "half-variance" else prior
        assert chosen.penalty == pytest.approx(1.5 * 2 * chosen.n_coefficients / len(y) * s2)


def test_penalty_multiplier_makes_networks_smaller():
    y = np.exp(X[:, 0]) * np.cos(3 * X[:, 1]) + 0.05 * RNG.normal(size=400)
    sizes = [AbductiveRegressor(cpm=cpm, max_layers=3).fit(X, y).network_.n_coefficients for cpm in (1.0, 30.0)]
    assert sizes[1] < sizes[0]


def test_pure_noise_gets_no_network():
    y = RNG.normal(size=400)
    model = AbductiveRegressor(prior_variance="half-variance", cpm=12.0).fit(X, y)
    assert model.network_.nodes == ()
    assert model.predict(X[:3]) == pytest.approx([y.mean()] * 3)


@pytest.mark.parametrize("n", [4, 5, 6, 8, 11, 12, 13, 20, 30])
def test_coefficients_stay_below_a_third_of_the_rows(n):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        model = AbductiveRegressor(cpm=0.0).fit(rng.uniform(size=(n, 3)), rng.normal(size=n))
        assert 3 * model.network_.n_coefficients <= n


def test_kinds_limit_the_search():
    y = X[:, 0] * X[:, 1]
    model = AbductiveRegressor(kinds=("single",)).fit(X, y)
    assert all(len(node.inputs) == 1 for node in model.network_.nodes)


def test_no_linear_node_reads_raw_inputs_only():
    """A linear node sums the outputs of a layer of nodes; the inputs are no such layer."""
    model = AbductiveRegressor(kinds=("linear",)).fit(X, X[:, 0] + X[:, 1])
    assert model.network_.nodes == ()


@pytest.mark.parametrize("size", [1, 2, 3])
@pytest.mark.parametrize("n_old", [0, 1, 4])
def test_every_choice_with_a_new_variable_is_a_candidate(size, n_old):
    expected = [c for c in combinations(range(6), size) if max(c) >= n_old]
    assert sorted(map(tuple, _rising(6, size, n_old).tolist())) == expected


def test_without_varying_inputs_there_is_no_network():
    model = AbductiveRegressor().fit(np.ones((20, 2)), np.arange(20.0))
    assert model.network_.nodes == ()
