"""The whole scikit-learn contract, for both estimators."""

import pytest
from sklearn.utils.estimator_checks import parametrize_with_checks

from polydraulic import AbductiveRegressor, RegionRegressor


@pytest.mark.slow
@parametrize_with_checks([AbductiveRegressor(), RegionRegressor()])
def test_estimator_contract(estimator, check):
    check(estimator)
