import numpy as np
import pytest
from sklearn.datasets import load_iris
from sklearn.model_selection import cross_val_score
from sklearn.utils.estimator_checks import parametrize_with_checks

from polydraulic import AbductiveRegressor
from polydraulic.networks import AbductiveClassifier

RNG = np.random.default_rng(0)
X = RNG.uniform(-1.0, 1.0, size=(600, 2))


@pytest.mark.slow
@parametrize_with_checks([AbductiveClassifier()])
def test_estimator_contract(estimator, check):
    check(estimator)


def test_a_curved_border_is_learnt():
    y = np.where(X[:, 0] ** 2 + X[:, 1] ** 2 < 0.5, "in", "out")
    model = AbductiveClassifier(AbductiveRegressor(max_layers=2)).fit(X[:400], y[:400])
    assert model.score(X[400:], y[400:]) > 0.95
    assert model.classes_.tolist() == ["in", "out"]


def test_probabilities_are_probabilities():
    chance = 1.0 / (1.0 + np.exp(-3.0 * X[:, 0]))
    y = RNG.uniform(size=600) < chance
    model = AbductiveClassifier(AbductiveRegressor(max_layers=1)).fit(X, y)
    found = model.predict_proba(X)
    assert found.sum(axis=1) == pytest.approx(1.0)
    assert np.abs(found[:, 1] - chance).mean() < 0.06


@pytest.mark.slow
def test_three_classes():
    data, target = load_iris(return_X_y=True)
    assert cross_val_score(AbductiveClassifier(), data, target, cv=5).mean() > 0.93


def test_one_class_is_refused():
    with pytest.raises(ValueError, match="1 class"):
        AbductiveClassifier().fit(X, np.ones(600, dtype=int))
