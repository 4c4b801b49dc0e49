import numpy as np
import pytest

from polydraulic import random_operator
from polydraulic.identification.equations.pilot_fit import (
    driven_spool,
    fit_pilot,
    moves_against,
    pieces_of,
    raster_within,
    smooth_spool,
    told_dead_time,
)
from polydraulic.parameters.schema import Pilot

TRUE = Pilot(0.014, 0.2, 0.06)
TRAVEL, RASTER = 0.0143, 0.02


@pytest.fixture(scope="module")
def log():
    time = np.arange(6000) * RASTER
    segment = (time > 70.0).astype(int)
    voltage = np.ascontiguousarray(random_operator(3, 130.0, limit=1.1).voltages(time)[:, 1])
    exact = driven_spool(TRUE, TRAVEL, time, pieces_of(np.zeros(len(time))), voltage, np.zeros(len(time)), RASTER)
    measured = exact + np.random.default_rng(1).normal(0.0, 4e-5, len(time))
    return time, segment, voltage, exact, measured


def test_a_pilot_is_found_with_its_dead_time(log):
    time, segment, voltage, _, measured = log
    found = fit_pilot(time, segment, voltage, measured, TRAVEL, Pilot(0.02, 0.1, 0.0))
    assert found.pilot.gain == pytest.approx(TRUE.gain, rel=1e-3)
    assert found.pilot.time_constant == pytest.approx(TRUE.time_constant, rel=5e-3)
    assert found.pilot.dead_time == pytest.approx(TRUE.dead_time, abs=1e-3)
    assert found.rms == pytest.approx(4e-5, rel=0.1)
    assert all(abs(a - b) < 6.0 * e for a, b, e in zip(found.pilot, TRUE, found.errors, strict=True))


@pytest.mark.parametrize("dead_time", [0.0, 0.003, 0.02, 0.027, 0.06])
def test_a_voltage_that_is_late_bends_between_rows(log, dead_time):
    time, _, voltage, _, _ = log
    fine = np.arange(0.0, time[-1], 1e-4)
    late = TRUE.gain * np.interp(fine - dead_time, time, voltage)
    exact, keep = np.zeros(len(fine)), np.exp(-1e-4 / TRUE.time_constant)
    for k in range(1, len(fine)):
        exact[k] = keep * exact[k - 1] + (1.0 - keep) * 0.5 * (late[k - 1] + late[k])
    pilot = TRUE._replace(dead_time=dead_time)
    found = driven_spool(pilot, 1.0, time, pieces_of(np.zeros(len(time))), voltage, np.zeros(len(time)), RASTER)
    assert np.abs(found - np.interp(time, fine, exact))[time < 100.0].max() < 2e-7


def test_a_spool_is_smoothed_by_its_pilot(log):
    time, segment, voltage, exact, measured = log
    smooth, sigma = smooth_spool(TRUE, TRAVEL, time, segment, voltage, measured, 4e-5)
    assert np.std(smooth - exact) < 1.2e-5
    assert sigma < 1.2e-5


def test_what_the_pilot_does_not_explain_is_left_to_the_sensor(log):
    time, segment, voltage, exact, measured = log
    shift = 3e-4 * np.sin(time)  # as of a flow force
    smooth, _ = smooth_spool(TRUE, TRAVEL, time, segment, voltage, measured + shift, 4e-5)
    assert np.std(smooth - exact - shift) < 2.5e-5


def test_a_spool_that_rests_tells_nothing(log):
    time, segment, voltage, _, _ = log
    assert fit_pilot(time, segment, voltage, np.zeros(len(time)), TRAVEL, TRUE) is None
    assert fit_pilot(time, segment, 0.0 * voltage, np.zeros(len(time)), TRAVEL, TRUE) is None


def test_a_spool_that_goes_against_its_voltage_tells_nothing(log):
    time, segment, voltage, _, measured = log
    assert fit_pilot(time, segment, -voltage, measured, TRAVEL, TRUE) is None


def test_a_voltage_of_the_wrong_sign_is_told_from_others(log):
    time, segment, voltage, _, measured = log
    noise = np.random.default_rng(2).normal(0.0, 1e-3, len(time))
    for start in (TRUE, Pilot(0.02, 0.1, 0.0), Pilot(0.008, 0.5, 0.2)):
        assert moves_against(time, segment, -voltage, measured, TRAVEL, start)
        assert not moves_against(time, segment, voltage, measured, TRAVEL, start)
    for other in (noise, np.zeros(len(time)), -np.abs(noise)):
        assert not moves_against(time, segment, voltage, other, TRAVEL, TRUE)
        assert not moves_against(time, segment, -voltage, other, TRAVEL, TRUE)


def test_rasters_and_pieces():
    assert pieces_of(np.array([0, 0, 1, 1, 1])).tolist() == [[0, 2], [2, 5]]
    assert raster_within(np.array([0.0, 0.1, 0.2, 5.0, 5.1]), np.array([0, 0, 0, 1, 1])) == pytest.approx(0.1)


def test_a_dead_time_that_is_not_told_from_none_is_none():
    assert told_dead_time(1e-4, 1e-5) == 0.0  # far less than a step
    assert told_dead_time(2e-3, 1e-3) == 0.0
    assert told_dead_time(2e-3, 1e-4) == 2e-3
