import numpy as np
import pytest

from polydraulic.networks.dynamic.joint_strength import Belief, StrengthNumbers, after_window
from polydraulic.networks.dynamic.rows import STATES, OutputLimits, answer, begin_strength, see_row, strength_of

LIMITS = OutputLimits(-0.5, 0.5, -2.0, 2.0)
NUMBERS = StrengthNumbers(spread=0.2, lean=0.1, kept=0.9, noise=0.002, rows=3.0)


@pytest.mark.parametrize(
    ("upwards", "downwards", "y", "last", "wanted"),
    [
        (1.0, 1.0, 0.2, 0.1, 0.2),
        (1.5, 0.5, 0.2, 0.1, 0.25),  # each way by its own strength
        (1.5, 0.5, 0.0, 0.1, 0.05),
        (1.0, 1.0, 1.0, 0.1, 0.6),  # largest change
        (1.0, 1.0, -1.0, 0.1, -0.4),
        (2.0, 1.0, 1.95, 1.8, 2.0),  # end of the range
    ],
)
def test_an_answer_is_as_strong_as_its_joint_and_within_its_limits(upwards, downwards, y, last, wanted):
    assert answer(LIMITS, upwards, downwards, y, last) == pytest.approx(wanted, abs=1e-15)


def test_rows_add_up_to_a_window_that_moves_the_belief():
    states = np.full(STATES, 7.0)
    begin_strength(states, NUMBERS)
    assert states.tolist() == [0.0, 0.0, 0.2 * 0.2, 0.0, 0.1 * 0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
    rows = [(0.1, 0.0, 0.08), (0.2, 0.08, 0.16), (0.1, 0.16, 0.12)]  # network, last, measured
    for y, last, measured in rows[:2]:
        see_row(states, LIMITS, NUMBERS, y, last, measured)
    assert states[:5].tolist() == [0.0, 0.0, 0.2 * 0.2, 0.0, 0.1 * 0.1]
    see_row(states, LIMITS, NUMBERS, *rows[2])
    net, path = 0.1 + 0.12 - 0.06, 0.1 + 0.12 + 0.06
    wanted = after_window(Belief(0.0, 0.0, 0.2 * 0.2, 0.0, 0.1 * 0.1), NUMBERS, net, path, 0.12)
    assert states[:5] == pytest.approx(np.array(wanted), abs=1e-12)
    assert not states[5:].any()
    assert strength_of(states[0], states[1]) < 1.0  # it moved by less than its network says


def test_a_joint_at_its_end_says_nothing_and_strengths_have_ends():
    states = np.zeros(STATES)
    begin_strength(states, NUMBERS)
    for y in (0.1, 2.0, 0.1):
        see_row(states, LIMITS, NUMBERS, y, 0.0, 0.0)
    assert states[:2].tolist() == [0.0, 0.0]
    assert (strength_of(0.1, 0.05), strength_of(0.1, -0.05)) == pytest.approx((1.15, 1.05))
    assert (strength_of(5.0, 0.0), strength_of(-5.0, 0.0)) == (2.0, 0.5)
