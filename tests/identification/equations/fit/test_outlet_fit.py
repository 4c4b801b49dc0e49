import numpy as np
import pytest

from polydraulic.identification.equations.fit.outlet_fit import (
    OutletPrior,
    OutletRows,
    bent_knots,
    fit_outlet,
    predicted_out,
)

KNOTS = np.array([0.0, 4.8e-3, 9.5e-3, 14e-3])
TRUE = np.array([0.0, 0.0, 1.8e-6, 1.6e-5])


PRIOR = OutletPrior(3e5, KNOTS, np.array([0.0, 0.0, 2.4e-6, 1.1e-5]), 1.0)


def made(knots, values, n, long=1, seed=3, least=4e5, most=1.2e7):
    rng = np.random.default_rng(seed)
    travel = rng.uniform(0.0, 13e-3, (n, 1)) + np.linspace(0.0, 1e-3 if long > 1 else 0.0, long)
    drop = np.repeat(rng.uniform(least, most, (n, 1)), long, axis=1)
    rows = OutletRows(travel, drop, np.zeros_like(drop), np.zeros(n), np.arange(n) * 20 // n, 5e-6, 1e5, 8e-6)
    q = predicted_out(rows, knots, values, 3e5)
    drop = drop + rng.normal(0.0, 1e5, drop.shape)
    rows = rows._replace(q_out=np.minimum(q, 3e-3) + rng.normal(0.0, 8e-6, n), drop=drop)
    return rows.some(q < 3e-3)


@pytest.mark.parametrize("long", [1, 11])
def test_a_curve_is_found_where_the_flow_needs_a_drop(long):
    found = fit_outlet(made(KNOTS, TRUE, 4000, long), KNOTS, PRIOR)
    assert found.values[:2] == pytest.approx(0.0, abs=2e-9)
    assert found.values[2] == pytest.approx(TRUE[2], rel=0.01)
    assert found.values[3] == pytest.approx(TRUE[3], rel=0.1)
    assert abs(found.values[2] - TRUE[2]) < 8.0 * found.errors[2]
    assert np.all(np.diff(found.values) >= 0.0)


@pytest.mark.parametrize("long", [1, 11])
def test_knots_are_added_where_the_outlet_bends_and_nowhere_else(long):
    bent = np.array([0.0, 0.0, 1.1e-6, 1.8e-6, 1.6e-5])
    at = np.array([0.0, 4.8e-3, 7.15e-3, 9.5e-3, 14e-3])
    found = bent_knots(made(at, bent, 4000, long), KNOTS, PRIOR, 16)
    assert 5 <= len(found) <= 7
    assert np.abs(found - 7.15e-3).min() < 3e-4
    assert np.array_equal(bent_knots(made(KNOTS, TRUE, 4000, long), KNOTS, PRIOR, 16), KNOTS)
    assert np.array_equal(bent_knots(made(at, bent, 4000, long), KNOTS, PRIOR, 4), KNOTS)


def test_noise_of_small_drops_does_not_bend_the_curve():
    off = []
    for seed in range(4):
        found = fit_outlet(made(KNOTS, TRUE, 4000, 1, seed, 3e5, 1.2e6), KNOTS, PRIOR)
        off.append((found.values[2] - TRUE[2]) / TRUE[2])
    assert abs(np.mean(off)) < 4e-3  # the root of the measured drop makes it 1 % too small


def test_a_pressure_sensor_that_is_late_is_none_of_the_curve():
    rows, late = made(KNOTS, TRUE, 4000), 0.005
    rate = np.random.default_rng(2).normal(2e7, 4e7, rows.drop.shape)  # Pa/s, mostly rising
    found = fit_outlet(rows._replace(drop=np.maximum(rows.drop - late * rate, 0.0), rate=rate), KNOTS, PRIOR)
    assert found.values[2] == pytest.approx(TRUE[2], rel=3e-3)


def test_a_bend_is_placed_where_the_rows_have_it():
    bent = np.array([0.0, 0.0, 1.1e-6, 1.8e-6, 1.6e-5])
    at = np.array([0.0, 4.8e-3, 7.15e-3, 9.5e-3, 14e-3])
    rows = made(at, bent, 4000)
    knots = bent_knots(rows, KNOTS, PRIOR, 5)
    assert np.abs(knots - 7.15e-3).min() < 5e-5
    own = np.where(np.isin(knots, KNOTS), 0.0, np.inf)
    found = fit_outlet(rows, knots, PRIOR, own)
    off = found.values - np.interp(knots, at, bent)
    assert np.all(np.abs(off[2:]) < 4.0 * found.errors[2:])


def test_travel_of_a_wrong_scale_is_an_error_of_the_curve():
    rows = made(KNOTS, TRUE, 4000)
    found, sure = fit_outlet(rows._replace(noise_scale=1e-2), KNOTS, PRIOR), fit_outlet(rows, KNOTS, PRIOR)
    steep = np.diff(TRUE) / np.diff(KNOTS)
    by_scale = 1e-2 * KNOTS[2] * np.sqrt(0.5 * (steep[1] ** 2 + steep[2] ** 2))
    assert found.errors[2] == pytest.approx(np.hypot(sure.errors[2], by_scale), rel=0.01)
