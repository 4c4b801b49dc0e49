"""Variances of residuals: as wide as residuals of a healthy machine are."""

import numpy as np

from helpers.watched_logs import blocks, known, log_of
from polydraulic.watch.block import residuals_of
from polydraulic.watch.noise import channel_scales
from polydraulic.watch.watched import plan_of


def test_residuals_of_new_healthy_work_are_as_wide_as_their_variances():
    of, expected = known()
    own, variances = residuals_of(plan_of(of, expected.noise), blocks(of, log_of(of.machine, 13, 60.0))[0])
    for channel, r, v, (more, _) in zip(of.channels, own, variances, expected.scales, strict=True):
        fine = np.isfinite(v)
        z = r[fine] / np.sqrt(v[fine] + more)
        assert 0.2 < np.median(np.abs(z)) / 0.6745 < 2.0, channel.name


def test_where_a_residual_says_nothing_its_variance_is_infinite():
    of, expected = known()
    readings, _ = blocks(of, log_of(of.machine, 13, 20.0))
    low = {**readings, "lift.p_a": np.zeros_like(readings["lift.p_a"])}
    place = [c.name for c in of.channels].index("lift.volume_a")
    plan = plan_of(of, expected.noise)
    assert np.all(np.isinf(residuals_of(plan, low)[1][place]))
    assert not np.all(np.isinf(residuals_of(plan, readings)[1][place]))


def test_too_few_residuals_teach_nothing():
    nothing = [np.full((3, 50), np.inf)] * 2
    assert channel_scales([np.ones((3, 50))] * 2, nothing) == [(0.0, 1.0)] * 2
