"""Spools driven by voltages, and smoothed."""

import numpy as np
import pytest

from helpers.piloted_spool import RASTER, TRAVEL, TRUE, spool_log
from polydraulic.identification.equations.spool_motion import driven_spool, pieces_of, smooth_spool


@pytest.fixture(scope="module")
def log():
    return spool_log()


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


def test_pieces():
    assert pieces_of(np.array([0, 0, 1, 1, 1])).tolist() == [[0, 2], [2, 5]]
