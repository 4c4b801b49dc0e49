"""Spools behind known drivers against a play operator that goes along the driver in small steps."""

import tracemalloc

import numpy as np
import pytest

from polydraulic.parameters.schema import Pilot
from polydraulic.parameters.signals import Piecewise, Sine
from polydraulic.simulation.solvers.lagging_spools import curve_at
from polydraulic.simulation.solvers.spools import KnownInput, known_motion

# m; what a raster of 50 us misses where a driver turns
BETWEEN = 5e-9
PILOT = Pilot(gain=0.01, time_constant=0.08, dead_time=0.02)
SIGNALS = {
    "sine": Sine(0.8, 5.0),
    "corners": Piecewise((0.0, 0.3, 0.6, 0.9, 1.0, 1.4, 1.41, 2.0), (0.0, 0.7, 0.65, -0.4, -0.4, 0.9, 0.0, 0.1)),
    "clipped": Sine(3.0, 4.0),
}


def followed(driven, halves):
    place, found = 0.0, []
    for x, half in zip(driven, halves, strict=True):
        place = min(max(place, x - half), x + half)
        found.append(place)
    return np.array(found)


@pytest.mark.parametrize("half", [0.0, 1e-4, 8e-4, 0.1])
@pytest.mark.parametrize("signal", SIGNALS.values(), ids=SIGNALS)
def test_a_spool_follows_by_a_play_operator(signal, half):
    plain = KnownInput(signal, PILOT, 0.01, (0.0, 2e-3))
    motion = known_motion([plain, plain._replace(lags=[(0.0, half)])], 2.0)
    t = np.linspace(0.0, 2.0, 40_001)
    driven, spool = (curve_at(motion.starts, c, 1, t) for c in (motion.driven, motion.coefficients))
    assert np.allclose(curve_at(motion.starts, motion.coefficients, 0, t), driven, atol=1e-16)
    assert np.abs(spool - followed(driven, np.full(len(t), half))).max() < BETWEEN
    assert np.abs(spool - driven).max() <= half * (1.0 + 1e-12) + 1e-16
    # steps end where a spool begins to move, stands, or passes a knot
    for level in (-2e-3, 2e-3):
        passed = t[1:][(spool[1:] < level) != (spool[:-1] < level)]
        assert all(np.abs(motion.breaks - time).min() < 1e-4 for time in passed)


def test_a_width_that_changes_in_time_counts_from_then_on():
    one = KnownInput(SIGNALS["sine"], PILOT, 0.01, (), lags=[(0.0, 1e-4), (0.7, 2e-3), (1.3, 0.0)])
    motion = known_motion([one], 2.0, corners=[0.7, 1.3])
    t = np.linspace(0.0, 2.0, 40_001)
    driven, spool = (curve_at(motion.starts, c, 0, t) for c in (motion.driven, motion.coefficients))
    # a width counts until the time at which it changes, where one that gets narrower makes the spool jump
    halves = np.where(t < 0.7 + 1e-9, 1e-4, np.where(t < 1.3 + 1e-9, 2e-3, 0.0))
    off = np.abs(spool - followed(driven, halves))
    assert off[np.abs(t - 1.3) > 1e-9].max() < BETWEEN


def test_what_lags_later_follows_at_once_before():
    one = KnownInput(SIGNALS["sine"], PILOT, 0.01, (), lags=[(0.7, 2e-3)])
    motion = known_motion([one], 2.0, corners=[0.7])
    t = np.linspace(0.0, 2.0, 40_001)
    driven, spool = (curve_at(motion.starts, c, 0, t) for c in (motion.driven, motion.coefficients))
    assert np.array_equal(spool[t < 0.7], driven[t < 0.7])
    assert np.abs(np.diff(spool)).max() < 1e-5
    behind = np.abs(spool - driven)[t > 0.7 + 1e-9]
    assert behind.max() == pytest.approx(2e-3, rel=1e-9)


def test_a_recorded_lever_of_many_corners_takes_memory_by_their_number():
    n = 600
    levers = Piecewise(tuple(0.01 * np.arange(n)), tuple(np.linspace(-1.0, 1.0, n)))
    one = KnownInput(levers, PILOT, 0.01, (), lags=[(0.0, 0.1)])
    known_motion([one], 0.1)
    tracemalloc.start()
    motion = known_motion([one], 0.01 * n)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(motion.starts) >= n
    assert most < 8 * 200 * len(motion.starts)


def test_what_does_not_lag_is_as_it_was():
    one = KnownInput(SIGNALS["corners"], PILOT, 0.01, (0.0, 2e-3))
    motion = known_motion([one], 2.0)
    assert motion.driven is motion.coefficients
