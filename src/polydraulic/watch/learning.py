"""What is to be expected of a machine while it is healthy, learnt from blocks of healthy work."""

from collections.abc import Mapping

import numpy as np

from polydraulic.errors import InputError
from polydraulic.watch.block import Readings, residuals_of, scores_of
from polydraulic.watch.expected import Expected, learn_jitter, slow_variance, togetherness, whitened
from polydraulic.watch.flat import longest_flat
from polydraulic.watch.noise import channel_scales
from polydraulic.watch.sequential import Limits, highest, threshold_for
from polydraulic.watch.watched import Watched, plan_of, tests_of, ways_of

FALSE_ALARMS = 0.1  # per hour
_LEAST_BLOCKS = 60
_ROOM = 0.5  # of the threshold that healthy blocks may come to


def learn_expected(of: Watched, readings: Readings, noise: Mapping[str, float], rate: float = FALSE_ALARMS) -> Expected:
    """What is to be expected of the machine while it is healthy.

    Parameters
    ----------
    of : Watched
    readings : Readings
        Of healthy blocks, in the order of time.
    noise : mapping from column to float
        Standard deviation of each sensor's white noise, SI.
    rate : float
        False alarms per hour of all tests together.

    Raises
    ------
    InputError
        Too few blocks.
    """
    n_block = len(readings[of.columns[0]])
    if n_block < _LEAST_BLOCKS:
        raise InputError(
            f"healthy work has {n_block} blocks of {of.shape.seconds:g} s without a gap, and what is to be expected takes {_LEAST_BLOCKS}: "
            "give more healthy work, five minutes or more are good"
        )
    plan = plan_of(of, noise)
    scales = channel_scales(*residuals_of(plan, readings))
    scores, states = scores_of(plan, readings, scales)
    offset, jitter = learn_jitter(scores)
    white = whitened(scores, offset, jitter)
    together = togetherness(white)
    slow = slow_variance(white, together)
    ways, threshold = ways_of(of.directions), threshold_for(rate, tests_of(of.directions), of.shape.seconds)
    for _ in range(30):  # until healthy blocks stay well below the threshold
        most = highest(white, Limits(threshold, together, slow, ways))
        if np.all(most <= _ROOM * threshold):
            break
        together = np.where(most > _ROOM * threshold, 1.3 * together, together)
    flat = longest_flat(dict(zip(of.columns, states.T, strict=True)))
    return Expected(dict(noise), tuple(scales), offset, jitter, together, slow, flat, n_block)
