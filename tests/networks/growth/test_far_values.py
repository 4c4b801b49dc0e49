import warnings

import numpy as np
import pytest

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.networks.growth.far_values import FarTargetWarning, far_values

RNG = np.random.default_rng(6)
X = RNG.uniform(-1.0, 1.0, size=(300, 2))
Y = X[:, 0] * X[:, 1]


def with_far(values, rows):
    found = Y.copy()
    found[list(rows)] = values
    return found


def test_a_value_far_from_all_others_is_found_with_their_range():
    found = far_values(with_far([1e6], [41]))
    assert (found.rows.tolist(), found.values.tolist()) == ([41], [1e6])
    assert (found.low, found.high) == (np.delete(Y, 41).min(), np.delete(Y, 41).max())
    times = (1e6 - found.high) / (found.high - found.low)
    assert found.sentence("q", 1).startswith(
        f"q holds 1e+06 in row 42, {times:.3g} times the range of all others ({found.low:g} to {found.high:g}) away from them"
    )
    several = far_values(with_far([-3e5, 1e6, 1e6, 1e6], [5, 41, 2, 90]))
    assert several.rows.tolist() == [2, 5, 41, 90]
    assert (
        "y holds 1e+06 in row 2, -300000 in row 5, 1e+06 in row 41, counted from 0 and 1 more rows, "
        in several.sentence("y")
    )


@pytest.mark.parametrize(
    "y",
    [
        Y,
        np.exp(2.0 * RNG.normal(size=2000)),  # a long tail without a gap
        (np.arange(1000) == 7).astype(float),  # seldom on
        with_far([9.0], [3]),  # far, but not by ten times the range of the others
        np.r_[np.zeros(50), np.ones(50)],
        np.repeat(2.0, 9),
        np.array([0.0, 1.0, 1e9]),
    ],
)
def test_values_that_belong_to_the_others_are_not_far(y):
    assert far_values(y) is None


def test_values_without_a_number_count_for_nothing():
    y = np.insert(with_far([1e6], [41]), 10, np.nan)
    assert far_values(y).rows.tolist() == [42]
    assert far_values(np.full(5, np.nan)) is None


@pytest.mark.parametrize("scale", [1e-300, 1e300])
def test_scales_of_any_size(scale):
    assert far_values(with_far([1e6], [41]) * scale).rows.tolist() == [41]


def test_learners_warn_once_of_rows_as_they_were_given():
    y = with_far([1e6], [41])
    for learner in (
        AbductiveRegressor(max_layers=1),
        RegionRegressor(AbductiveRegressor(max_layers=1), edges={0: [0.0]}),
    ):
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            learner.fit(X, y)
        assert [str(w.message).split(" in ")[1].split(",")[0] for w in heard] == ["row 41"]
        assert issubclass(heard[0].category, FarTargetWarning)
        assert heard[0].filename == __file__
        assert learner.fit(X, y, np.where(y > 1e3, 0.0, 1.0)).score(X[y < 1e3], y[y < 1e3]) > 0.99
    with pytest.warns(FarTargetWarning, match="y1 holds 1e"):
        AbductiveRegressor(max_layers=1).fit(X, np.column_stack([Y, y]))
