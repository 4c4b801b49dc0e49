"""The step, with one change at a time."""

import numpy as np
import pytest

from polydraulic.thesis.cache import Cache, Lab
from polydraulic.thesis.causes.step import PRINTED_ANGLE, step_causes
from polydraulic.thesis.three_links import three_link_study


@pytest.mark.slow
def test_a_stick_that_is_not_early_and_a_turned_machine_give_the_printed_kind_of_error(machine):
    found = step_causes(three_link_study(Lab(machine, Cache(None), Cache(None))))
    run, follows, turned, both = list(found.values())[:4]
    assert run.stops < 4.5
    assert run.time < 7.0
    assert abs(run.along_x) < 0.1
    assert follows.stops == pytest.approx(5.0, abs=0.1)
    assert follows.time == 13.0  # printed: the error is largest at the end
    assert turned.largest == pytest.approx(run.largest)  # nothing but the direction of X and Y has changed
    assert abs(both.along_x) > 0.95 * both.largest  # printed: X alone
    assert found["pump relief valve out of reach"].stick_flow > 10.0 > abs(run.stick_flow)
    reach = 1.4 / (2.0 * np.sin(np.radians(15.44) / 2.0))
    assert reach * abs(np.cos(PRINTED_ANGLE + np.radians(15.44)) - np.cos(PRINTED_ANGLE)) == pytest.approx(
        1.397, rel=0.1
    )
