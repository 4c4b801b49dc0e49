"""Curves beyond the travel of a log: monotone, bounded, shut where they were known to shut."""

import numpy as np
import pytest

from polydraulic.identification.equations.fit.beyond import beyond, shutting

OLD_KNOTS = np.array([0.0, 4.0, 10.0, 15.0])
OLD = np.array([30.0, 12.0, 0.0, 0.0])


def whole(knots, bypass):
    turn, values = shutting(knots, bypass, OLD_KNOTS, OLD, 4.0)
    at = np.sort(np.append(OLD_KNOTS[knots[-1] < OLD_KNOTS], turn))
    return np.concatenate([knots, at]), np.concatenate([bypass, values])


@pytest.mark.parametrize("last", [0.0, 0.5, 2.0, 4.0, 7.9])
def test_a_bypass_keeps_its_slope_and_shuts_where_it_was_known_to(last):
    """At 8 mm it was 8 at 6 mm and is `last` now; the old curve is shut at 10 mm."""
    knots, bypass = np.array([0.0, 4.0, 6.0, 8.0]), np.array([30.0, 12.0, 8.0, last])
    if last == 0.0:
        assert shutting(knots, bypass, OLD_KNOTS, OLD, 4.0) is None
        return
    x, y = whole(knots, bypass)
    assert (np.diff(x) > 0.0).all()
    assert (np.diff(y) <= 1e-12).all()
    assert (y >= 0.0).all()
    assert np.interp([10.0, 15.0], x, y).tolist() == [0.0, 0.0]
    slope = (bypass[-1] - 8.0) / 2.0
    assert np.interp(8.3, x, y) == pytest.approx(
        max(bypass[-1] + 0.3 * slope, 0.0), abs=0.02 + 0.3 * abs(slope) * (last < 1.0)
    )


def test_a_bypass_that_stays_shuts_late():
    x, y = whole(np.array([0.0, 4.0, 6.0, 8.0]), np.array([30.0, 12.0, 5.0, 5.0]))
    assert np.interp(9.7, x, y) == 5.0
    assert y[-2:].tolist() == [0.0, 0.0]


def test_a_bypass_falls_as_over_the_last_quarter_of_its_travel_and_shuts_in_a_tenth_of_the_way():
    """From 4 to 8 mm the last quarter begins at 7 mm; from 8 to 10 mm the last tenth at 9.8 mm."""
    knots = np.array([0.0, 4.0, 7.0, 8.0])
    turn, values = shutting(knots, np.array([30.0, 12.0, 10.0, 7.0]), OLD_KNOTS, OLD, 4.0)
    assert (turn, values.tolist()) == (pytest.approx(9.8), [pytest.approx(7.0 - 3.0 * 1.8), 0.0, 0.0])
    turn, values = shutting(knots, np.array([30.0, 12.0, 10.0, 5.0]), OLD_KNOTS, OLD, 4.0)
    assert (turn, values.tolist()) == (pytest.approx(9.0), [pytest.approx(0.0), 0.0, 0.0])


def test_an_old_bypass_that_never_shuts_lends_its_shape():
    open_ = np.array([30.0, 12.0, 3.0, 1.0])
    knots, bypass = np.array([0.0, 4.0, 8.0]), np.array([30.0, 12.0, 3.0])
    assert shutting(knots, bypass, OLD_KNOTS, open_, 4.0) is None
    assert beyond(knots, bypass, OLD_KNOTS, open_, OLD_KNOTS[2:]) == pytest.approx([1.5, 0.5])
    shut = beyond(knots, np.array([0.0, 0.0, 4.0]), OLD_KNOTS, np.zeros(4), OLD_KNOTS[2:])
    assert shut.tolist() == [0.0, 0.0]  # a caller lets no inlet fall
