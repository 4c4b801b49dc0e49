from types import SimpleNamespace

import numpy as np
import pytest

from polydraulic.identification.equations.fit.uncertainty import _pairs, at_travel

KNOTS = np.array([0.0, 4e-3, 9e-3])
NONE = np.zeros((3, 3))


def test_a_knot_that_slides_along_its_curve_is_no_error():
    line, places = np.array([0.0, 4.0, 9.0]), np.diag([0.0, 1e-10, 0.0])
    slope = 1e3
    found = at_travel(slope**2 * places, slope * places, places, KNOTS, line, np.zeros(3))
    assert found == pytest.approx(0.0, abs=1e-12)


def test_where_a_curve_bends_the_place_of_the_knot_counts():
    bent, places = np.array([0.0, 0.0, 10.0]), np.diag([0.0, 1e-10, 0.0])
    found = at_travel(NONE, NONE, places, KNOTS, bent, np.zeros(3))
    assert found[1] == pytest.approx(
        2e3 * 1e-5 * np.sqrt(0.5)
    )  # behind it on the steep side, before it on the flat one


def test_the_scale_of_travel_counts_by_the_slope():
    line = np.array([0.0, 4.0, 9.0])
    assert at_travel(NONE, NONE, NONE, KNOTS, line, 1e-2 * KNOTS) == pytest.approx(1e3 * 1e-2 * KNOTS)


def test_numbers_with_hardly_any_error_have_no_partner_and_divide_nothing():
    model = SimpleNamespace(valves=[SimpleNamespace(knots=())])
    errors = np.array([1.0, 1.0, 1e-200])
    covariance = np.outer(errors, errors)
    covariance[0, 1] = covariance[1, 0] = 0.999
    with np.errstate(all="raise", under="ignore"):
        assert _pairs(model, covariance) == [(0, 1, 0.999)]
