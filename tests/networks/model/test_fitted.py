import numpy as np
import pytest

from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.networks import Variable
from polydraulic.networks.model.fitted import checked_box, predictions, settings_of, variables

Y = np.array([[1.0, 10.0], [2.0, 20.0]])
INSIDE = np.array([True, False])


def test_outputs_come_alone_unless_more_is_asked_for():
    assert predictions(Y, None, None, single=False) is Y
    assert predictions(Y, None, None, single=True).tolist() == [1.0, 2.0]


def test_intervals_and_domain_stand_behind_the_outputs():
    y, low, high, inside = predictions(Y, np.array([0.5, 2.0]), INSIDE, single=False)
    assert (y.tolist(), inside.tolist()) == (Y.tolist(), [True, False])
    assert low.tolist() == [[0.5, 8.0], [1.5, 18.0]]
    assert high.tolist() == [[1.5, 12.0], [2.5, 22.0]]
    y, inside = predictions(Y, None, INSIDE, single=True)
    assert y.shape == inside.shape == (2,)


def test_variables_are_given_or_seen_or_numbered():
    estimator = AbductiveRegressor()
    estimator.n_features_in_ = 2
    assert variables(estimator, None) == (Variable("x0"), Variable("x1"))
    estimator.feature_names_in_ = np.array(["p", "q"])
    assert variables(estimator, None) == (Variable("p"), Variable("q"))
    assert variables(estimator, [Variable("a", "m"), Variable("b")]) == (Variable("a", "m"), Variable("b"))
    with pytest.raises(InputError, match="1 input names for a model with 2 inputs"):
        variables(estimator, [Variable("a")])


def test_settings_are_those_of_growth_and_not_of_the_data():
    kept = settings_of(AbductiveRegressor(max_layers=2, domain=[(0.0, 1.0)]))
    assert kept["max_layers"] == 2
    assert "domain" not in kept


@pytest.mark.parametrize("domain", [[(0.0, 1.0)], [(0.0, 1.0), (2.0, 1.0)], [(0.0, 1.0, 2.0)] * 2])
def test_a_domain_has_a_rising_range_for_each_input(domain):
    with pytest.raises(InputError, match="must give"):
        checked_box(domain, 2)
    low, high = checked_box([(0.0, 1.0), (-1.0, 3.0)], 2)
    assert (low.tolist(), high.tolist()) == ([0.0, -1.0], [1.0, 3.0])
