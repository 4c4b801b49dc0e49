"""Variances of residuals: as wide as residuals of a healthy machine are."""

import numpy as np

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.noise import channel_scales, first_variances, whole_variances
from polydraulic.watch.residuals import Residuals, case_of


def test_residuals_of_new_healthy_work_are_as_wide_as_their_variances():
    of, expected = known()
    residuals = Residuals(blocks(of, log_of(of.machine, 13, 60.0))[0], of.shape, of.channels)
    case = case_of(of.machine)
    plain = [(more, 1.0) for more, _ in expected.scales]
    for channel, r, v in zip(
        of.channels, residuals.of(case), whole_variances(residuals, case, expected.noise, plain), strict=True
    ):
        z = (r / np.sqrt(v))[np.isfinite(r) & np.isfinite(v)]
        assert 0.2 < np.median(np.abs(z)) / 0.6745 < 2.0, channel.name


def test_where_a_residual_says_nothing_its_variance_is_infinite():
    of, expected = known()
    readings, _ = blocks(of, log_of(of.machine, 13, 20.0))
    low = {**readings, "lift.p_a": np.zeros_like(readings["lift.p_a"])}
    residuals = Residuals(low, of.shape, of.channels)
    place = [c.name for c in of.channels].index("lift.volume_a")
    assert np.all(np.isinf(first_variances(residuals, case_of(of.machine), expected.noise)[place]))


def test_too_few_residuals_teach_nothing():
    of, _ = known()
    residuals = Residuals(blocks(of, log_of(of.machine, 13, 20.0))[0], of.shape, of.channels)
    nothing = [np.full_like(r, np.inf) for r in residuals.of(case_of(of.machine))]
    assert channel_scales(residuals, case_of(of.machine), nothing) == [(0.0, 1.0)] * len(of.channels)
