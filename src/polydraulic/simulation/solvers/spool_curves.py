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


@kernel
def spool_curve(c: np.ndarray, link: int, t0: float, t: float) -> SpoolCurve:
    """Input number `link` at the time t of a piece that begins at t0 and has the coefficients c, (n_input, N_COEFFICIENT)."""
    s = t - t0
    fading = c[link, 2] * exp(-s * c[link, 7])
    w = c[link, 5]
    x = c[link, 0] + c[link, 1] * s + fading
    v = c[link, 1] - fading * c[link, 7]
    if w != 0.0:
        turn = sincos(w * (t - c[link, 6]))
        x = x + c[link, 3] * turn.sin + c[link, 4] * turn.cos
        v = v + w * (c[link, 3] * turn.cos - c[link, 4] * turn.sin)
    return SpoolCurve(x, v)
