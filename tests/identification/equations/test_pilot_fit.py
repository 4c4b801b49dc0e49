import numpy as np
import pytest

from helpers.piloted_spool import RASTER, TRAVEL, TRUE, spool_log
from polydraulic.identification.equations.pilot_fit import (
    Jets,
    fit_pilot,
    moves_against,
    raster_within,
    told_dead_time,
)
from polydraulic.identification.equations.spool_motion import SpoolEffects, driven_spool, pieces_of
from polydraulic.parameters.schema import Pilot


@pytest.fixture(scope="module")
def log():
    return spool_log()


def test_a_pilot_is_found_with_its_dead_time(log):
    time, segment, voltage, _, measured = log
    found = fit_pilot(time, segment, voltage, measured, TRAVEL, Pilot(0.02, 0.1, 0.0))
    assert found.pilot.gain == pytest.approx(TRUE.gain, rel=1e-3)
    assert found.pilot.time_constant == pytest.approx(TRUE.time_constant, rel=5e-3)
    assert found.pilot.dead_time == pytest.approx(TRUE.dead_time, abs=1e-3)
    assert found.rms == pytest.approx(4e-5, rel=0.1)
    assert all(abs(a - b) < 6.0 * e for a, b, e in zip(found.pilot, TRUE, found.errors, strict=True))


def test_a_spool_tells_conductances_that_its_jets_follow_from(log):
    time, segment, voltage, _, _ = log
    far = np.abs(np.sin(0.7 * time))  # how far a load lets jets be strong
    known, open_ = 40.0 * far, np.clip(np.abs(voltage) - 0.5, 0.0, None)
    unsure, off = np.stack([8.0 * open_ * far, 0.0 * far, 4.0 * np.clip(np.cos(time), 0.0, None)]), [1.5, 0.0, -0.8]
    does, pieces = SpoolEffects(3e-4, 1e-4), pieces_of(segment)
    strength = known + off @ unsure
    spool = driven_spool(TRUE, TRAVEL, time, pieces, voltage, np.zeros(len(time)), RASTER, does, strength)
    spool = spool + np.random.default_rng(3).normal(0.0, 4e-5, len(time))
    found, without = (
        fit_pilot(
            time, segment, voltage, spool, TRAVEL, TRUE, free=SpoolEffects._fields,
            jets=Jets(known, numbers, 0.0 * time, np.zeros(len(numbers))),
        )
        for numbers in (unsure, unsure[:0])
    )  # fmt: skip
    assert found.moved == pytest.approx(off, abs=0.1)
    assert found.moved_errors[1] == 1.0  # which no jet shows
    assert all(abs(a - b) < 4.0 * e for a, b, e in zip(found.moved, off, found.moved_errors, strict=True))
    assert found.effects.hysteresis == pytest.approx(does.hysteresis, rel=0.02)
    assert found.effects.shift == pytest.approx(does.shift, rel=0.01)
    assert found.rms == pytest.approx(4e-5, rel=0.05)
    assert not len(without.moved)
    assert abs(without.effects.hysteresis / does.hysteresis - 1.0) > 0.05
    # what was moved before counts as far from what was known
    again = Jets(known + found.moved @ unsure, unsure, 0.0 * time, found.moved)
    twice = fit_pilot(time, segment, voltage, spool, TRAVEL, TRUE, jets=again, free=SpoolEffects._fields)
    assert twice.moved == pytest.approx(np.zeros(3), abs=0.01)


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


def test_the_raster_is_that_within_pieces():
    assert raster_within(np.array([0.0, 0.1, 0.2, 5.0, 5.1]), np.array([0, 0, 0, 1, 1])) == pytest.approx(0.1)


def test_a_dead_time_that_is_not_told_from_none_is_none():
    assert told_dead_time(1e-4, 1e-5) == 0.0  # far less than a step
    assert told_dead_time(2e-3, 1e-3) == 0.0
    assert told_dead_time(2e-3, 1e-4) == 2e-3
