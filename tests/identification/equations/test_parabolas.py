"""Local parabolas are those of Savitzky and Golay, ends of segments included."""

import numpy as np
import pytest
from scipy.signal import savgol_filter

from polydraulic.identification.equations.parabolas import ROWS, local_parabolas


def test_each_segment_is_smoothed_by_itself():
    values, segment = np.random.default_rng(0).normal(size=40), np.repeat([0, 1, 2, 3], [6, 5, 20, 9])
    smooth, change = local_parabolas(values, segment)
    for rows in (segment == 0, segment == 2, segment == 3):
        assert smooth[rows] == pytest.approx(savgol_filter(values[rows], ROWS, 2), abs=1e-12)
        assert change[rows] == pytest.approx(savgol_filter(values[rows], ROWS, 2, deriv=1), abs=1e-12)
    assert np.array_equal(smooth[segment == 1], values[segment == 1])
    assert not change[segment == 1].any()


def test_a_log_without_a_long_segment_stays_as_it_is():
    values = np.arange(8.0) ** 3
    smooth, change = local_parabolas(values, np.repeat([0, 1], 4))
    assert np.array_equal(smooth, values)
    assert not change.any()
