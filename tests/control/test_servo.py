"""Rules of a controller that know nothing of a machine."""

import numpy as np
import pytest

from polydraulic.control.servo import outside_band, slew_share, slewed, stop_share


def test_a_joint_that_is_slowed_ahead_of_its_limits_never_passes_them():
    rng = np.random.default_rng(3)
    for _ in range(50):
        low, high = np.sort(rng.uniform(-2.0, 2.0, 2))
        angle, braking, dt = rng.uniform(low, high), rng.uniform(0.1, 2.0), 0.01
        before = 0.0
        for _ in range(300):
            wanted = float(rng.choice([-1.0, 1.0])) if rng.random() < 0.02 else (1.0 if before >= 0.0 else -1.0)
            rate = wanted * stop_share(angle, wanted, low, high, braking, dt)
            angle, before = angle + rate * dt, wanted
            assert low - 1e-12 <= angle <= high + 1e-12


def test_braking_towards_a_limit_is_within_what_is_allowed():
    angle, rates = 0.0, []
    for _ in range(400):
        rate = stop_share(angle, 0.5, -1.0, 1.0, 0.25, 0.01) * 0.5
        rates.append(rate)
        angle += 0.01 * rate
    assert rates[0] == 0.5
    assert rates[-1] < 0.01
    assert -np.diff(rates).min() / 0.01 < 2.0 * 0.25  # in steps, the last of which end at the limit


def test_away_from_a_limit_a_joint_moves_freely():
    assert stop_share(1.0, -0.5, -1.0, 1.0, 0.5, 0.01) == 1.0
    assert stop_share(1.2, 0.5, -1.0, 1.0, 0.5, 0.01) == 0.0


@pytest.mark.parametrize(("change", "share"), [((0.0, 0.0), 1.0), ((0.003, 0.004), 1.0), ((0.3, 0.4), 0.016)])
def test_changes_in_a_plane_keep_their_direction(change, share):
    assert slew_share(*change, 0.008) == pytest.approx(share)


def test_values_follow_within_a_step_and_errors_lose_their_band():
    assert slewed(0.0, 1.0, 0.1) == 0.1
    assert slewed(0.95, 1.0, 0.1) == 1.0
    assert [outside_band(e, 0.1) for e in (0.05, -0.05)] == [0.0, 0.0]
    assert outside_band(0.3, 0.1) == pytest.approx(0.2)
