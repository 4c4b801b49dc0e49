import pytest

from polydraulic.machine.joints import passes_stop, turned_joint
from polydraulic.parameters.schema import Stops

STOPS, DT = Stops(-0.5, 1.0), 0.01


@pytest.mark.parametrize(
    ("angle", "rate", "passes", "after"),
    [
        (0.0, 2.0, False, 0.02),
        (0.99, 2.0, True, 1.0),
        (-0.495, -1.0, True, -0.5),
        (1.0, -1.0, False, 0.99),  # leaves its stop
        (1.0, 0.0, False, 1.0),
    ],
)
def test_a_joint_ends_at_its_stops(angle, rate, passes, after):
    assert passes_stop(angle, rate, STOPS, DT) == passes
    assert turned_joint(angle, rate, False, STOPS, DT) == pytest.approx(after)


def test_a_joint_that_stands_there_is_at_its_nearer_stop():
    assert turned_joint(0.3, 0.0, True, STOPS, DT) == STOPS.high
    assert turned_joint(0.2, 0.0, True, STOPS, DT) == STOPS.low
