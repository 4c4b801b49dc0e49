import numpy as np
import pytest

from polydraulic.networks.proof.branch_and_bound import Ends, close_to_found, search

BOX = np.array([[-1.0, 2.0]])


def square(low, high):
    """x^2 - x over boxes, by interval arithmetic, which is too wide; values at their middles."""
    least, most = np.where((low < 0.0) & (high > 0.0), 0.0, np.minimum(low**2, high**2)), np.maximum(low**2, high**2)
    middle = 0.5 * (low + high)
    value = middle**2 - middle
    return Ends(least - high, most - low, value, value, middle[None], middle[None])


@pytest.mark.parametrize("tolerance", [0.1, 1e-3, 1e-6])
def test_the_range_is_proved_and_as_close_as_asked_for(tolerance):
    ends, n_boxes, converged = search(square, BOX, close_to_found(tolerance), 100_000)
    assert converged
    assert ends.low[0] <= -0.25 <= ends.inner_low[0]
    assert ends.inner_high[0] <= 2.0 <= ends.high[0]
    width = ends.inner_high[0] - ends.inner_low[0]
    assert ends.high[0] - ends.inner_high[0] <= 1.001 * tolerance * width + 1e-11
    assert ends.inner_low[0] - ends.low[0] <= 1.001 * tolerance * width + 1e-11
    assert n_boxes > 1
    assert ends.at_low[0, 0] == pytest.approx(0.5, abs=np.sqrt(3.0 * tolerance) + 1e-3)


def test_the_budget_ends_the_search_and_the_range_is_still_proved():
    ends, n_boxes, converged = search(square, BOX, close_to_found(1e-9), 21)
    assert not converged
    assert n_boxes <= 21
    assert ends.low[0] <= -0.25
    assert ends.high[0] >= 2.0


def test_a_fixed_goal_is_kept_or_a_value_outside_ends_the_search_at_once():
    kept = search(square, BOX, lambda low, high: (-0.3, 2.3), 10_000)
    assert kept[2]
    assert -0.3 <= kept[0].low[0] <= -0.25
    missed = search(square, BOX, lambda low, high: (-0.2, 2.3), 10_000)
    assert not missed[2]
    assert missed[0].inner_low[0] < -0.2
    assert missed[1] < kept[1]


def test_a_point_cannot_be_halved():
    ends, n_boxes, converged = search(square, np.array([[1.0, 1.0]]), close_to_found(1e-3), 100)
    assert (ends.low[0], ends.high[0], n_boxes, converged) == (0.0, 0.0, 1, True)
