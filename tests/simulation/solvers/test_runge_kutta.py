import pytest

from helpers.smooth_run import (
    end_by_runge_kutta,
    order,
    smooth_start,
)


@pytest.mark.slow
def test_runge_kutta_is_of_fourth_order(machine):
    moving = smooth_start(machine)
    truth = end_by_runge_kutta(machine, moving, 1280)
    assert 3.9 < order(lambda n: end_by_runge_kutta(machine, moving, n), truth, [80, 160, 320]) < 4.3
