import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.parameters.signals import Constant, Piecewise, Sine

T = np.array([[0.0, 0.5], [1.0, 4.0]])


def test_signals_are_their_formulas_at_times_of_any_shape():
    assert Sine(0.3, 2.0)(T) == pytest.approx(0.3 * np.sin(2.0 * T))
    assert Constant(0.4)(T).tolist() == [[0.4, 0.4], [0.4, 0.4]]
    assert Constant()(T).sum() == 0.0


def test_between_points_lie_straight_lines_and_the_ends_hold():
    ramp = Piecewise(np.array([0.5, 1.5]), np.array([1.0, 3.0]))
    assert ramp(np.array([0.0, 0.5, 1.0, 1.5, 9.0])).tolist() == [1.0, 1.0, 2.0, 3.0, 3.0]


@pytest.mark.parametrize(
    ("time", "voltage", "message"),
    [
        ([0.0, 1.0], [1.0], "got 2 times, 1 voltages"),
        ([], [], "got 0 times"),
        ([0.0, 1.0, 1.0], [0.0, 0.0, 0.0], "time 2 is 1.0 after 1.0"),
    ],
)
def test_points_without_order_are_named(time, voltage, message):
    with pytest.raises(InputError, match=message):
        Piecewise(np.array(time), np.array(voltage))
