"""A random operator: joystick voltages that nobody planned, yet that a hand could make.

Each joystick rests, goes out to one side, is held there at one to three levels, and comes back to rest or is thrown over to the
other side at once. The hand follows such a wish through two equal lags, so that voltages are smooth and never leave their bounds.
"""

from collections.abc import Collection, Sequence
from math import exp, isfinite

import numpy as np

from polydraulic.errors import InputError
from polydraulic.parameters.signals import Piecewise

RASTER = 0.02  # s
HAND = 0.08  # s, each of the two lags: from 10 to 90 % in 0.27 s
LONGEST = 1e5  # s
_PAUSE, _HOLD = 0.2, 0.4  # s, shortest


def random_signals(
    seed: int, duration: float, *, links: Collection[str], limit: float, functions: Sequence[str]
) -> dict[str, Piecewise]:
    """Voltages of a random operator; `random_operator` says what they are like.

    Parameters
    ----------
    seed : int
    duration : float, s
    links : collection of str
    limit : float, V
    functions : sequence of str
        That the machine has: each has a hand of its own, by its place.

    Raises
    ------
    InputError
        If one of these is not usable.
    """
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed = {seed!r}: must be a whole number, at least 0")
    if not (isfinite(duration) and RASTER <= duration <= LONGEST):
        raise InputError(f"duration = {duration} s: must lie in [{RASTER}, {LONGEST:g}] s")
    if not (isfinite(limit) and limit > 0.0):
        raise InputError(f"limit = {limit} V: must be finite and above 0")
    if not links or not set(links) <= set(functions):
        raise InputError(f"links = {links!r}: must be some of {list(functions)}")
    time = np.arange(int(duration / RASTER) + 2) * RASTER
    return {
        link: Piecewise(time, _hand(_wish(np.random.default_rng([seed, place]), time, limit), limit))
        for place, link in enumerate(functions)
        if link in links
    }


def _wish(rng: np.random.Generator, time: np.ndarray, limit: float) -> np.ndarray:
    """Levels that the operator wants, constant between jumps."""
    begins, levels = [0.0], [0.0]
    now, side = _PAUSE + rng.exponential(0.8), rng.choice([-1.0, 1.0])
    for _ in range(int(time[-1] / _HOLD) + 2):  # a move lasts longer than the shortest hold
        if now > time[-1]:
            break
        side = -side if rng.random() < 0.7 else side
        level = limit * rng.uniform(0.4, 1.0)
        for _ in range(rng.integers(1, 4)):
            begins.append(now)
            levels.append(side * level)
            now += _HOLD + rng.exponential(0.6)
            level = min(level * rng.uniform(0.6, 1.3), limit)
        if rng.random() < 0.65:
            begins.append(now)
            levels.append(0.0)
            now += _PAUSE + rng.exponential(0.8)
    return np.asarray(levels)[np.searchsorted(begins, time, side="right") - 1]


def _hand(wish: np.ndarray, limit: float) -> np.ndarray:
    from scipy.signal import lfilter

    keep = exp(-RASTER / HAND)
    for _ in range(2):
        wish = lfilter([1.0 - keep], [1.0, -keep], wish)
    return np.clip(wish, -limit, limit)  # the lags stay inside but for rounding
