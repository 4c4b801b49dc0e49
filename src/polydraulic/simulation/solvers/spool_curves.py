"""A curve that a spool follows, or anything else that is known in advance.

x(s) = c0 + c1 s + c2 exp(-s / tau) + c3 sin(w t) + c4 cos(w t), with s from the start of its piece and t the signal's own time.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.elementary import exp, sincos

N_COEFFICIENT = 8  # c0 .. c4, w, delay, 1 / tau
LOOK = 0.02  # s; a spool is taken to pass no knot, and to turn back, not twice within this time
SAME = 1e-9  # s


class SpoolCurve(NamedTuple):
    """Position in m and velocity in m/s."""

    x: float
    v: float


class KnownCurve(NamedTuple):
    """Coefficients of one curve."""

    c0: float
    c1: float
    c2: float
    c3: float
    c4: float
    w: float
    delay: float
    rate: float  # 1 / tau


@kernel
def curve_of(c: np.ndarray, link: int) -> KnownCurve:
    """The curve of input number `link` in a piece with the coefficients c, (n_input, N_COEFFICIENT)."""
    return KnownCurve(c[link, 0], c[link, 1], c[link, 2], c[link, 3], c[link, 4], c[link, 5], c[link, 6], c[link, 7])


@kernel
def along_curve(k: KnownCurve, t0: float, t: float) -> SpoolCurve:
    """Where a curve of a piece that begins at t0 is at the time t, and how fast."""
    s = t - t0
    fading = k.c2 * exp(-s * k.rate)
    x = k.c0 + k.c1 * s + fading
    v = k.c1 - fading * k.rate
    if k.w != 0.0:
        turn = sincos(k.w * (t - k.delay))
        x = x + k.c3 * turn.sin + k.c4 * turn.cos
        v = v + k.w * (k.c3 * turn.cos - k.c4 * turn.sin)
    return SpoolCurve(x, v)


@kernel
def spool_curve(c: np.ndarray, link: int, t0: float, t: float) -> SpoolCurve:
    """Input number `link` at the time t of a piece that begins at t0 and has the coefficients c, (n_input, N_COEFFICIENT)."""
    return along_curve(curve_of(c, link), t0, t)
