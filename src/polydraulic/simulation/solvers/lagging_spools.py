"""Spools that lag behind what drives them by half a width either way, in closed form for drivers that are known in advance.

Such a spool stands, or moves with its driver at half a width behind it. It begins to move where the driver is that far ahead, and stands where the
driver turns back. Both are found on the driver's curve, and pieces end there.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.simulation.solvers.spool_curves import LOOK, SAME, spool_curve

NONE = -1.0  # half width of what has no hysteresis


class Lagging(NamedTuple):
    """Pieces of all inputs, and coefficients of drivers and of what follows them."""

    starts: np.ndarray  # (n_piece + 1,) s
    driven: np.ndarray  # (n_piece, n_input, N_COEFFICIENT)
    coefficients: np.ndarray


@kernel
def _turn(c: np.ndarray, link: int, t0: float, low: float, high: float) -> float:
    """Where a driver turns back between two times; the later one if it does not."""
    begins, ends = spool_curve(c, link, t0, low).v, spool_curve(c, link, t0, high).v
    a, b = low, high
    if begins * ends < 0.0:
        for _ in range(60):
            middle = 0.5 * (a + b)
            before = spool_curve(c, link, t0, middle).v * begins > 0.0
            a, b = (middle, b) if before else (a, middle)
    return b


@driver
def _changes(starts: np.ndarray, c: np.ndarray, halves: np.ndarray, found: np.ndarray) -> int:
    """Rows of time, input, way (0 where it stands) and place from then on; more than `found` holds are counted, not kept."""
    n, most = 0, found.shape[0]
    for link in range(c.shape[1]):
        place = 0.0
        for piece in range(c.shape[0]):
            half, t0, t1 = halves[piece, link], starts[piece], starts[piece + 1]
            if half < 0.0:
                place = spool_curve(c[piece], link, t0, t1).x
                continue
            x = spool_curve(c[piece], link, t0, t0).x
            place, way, low = min(max(place, x - half), x + half), 0.0, t0
            if n < most:
                found[n, 0], found[n, 1], found[n, 2], found[n, 3] = t0, link, way, place
            n += 1
            parts = int((t1 - t0) / LOOK) + 1
            for half_part in range(2 * parts):
                high = t0 + (t1 - t0) * (half_part // 2 + 1) / parts
                high = _turn(c[piece], link, t0, low, high) if half_part % 2 == 0 else high
                end = spool_curve(c[piece], link, t0, high).x
                side = 1.0 if end >= x else -1.0
                if way != 0.0 and side != way and end != x:
                    place, way = x - way * half, 0.0
                    if n < most:
                        found[n, 0], found[n, 1], found[n, 2], found[n, 3] = low, link, way, place
                    n += 1
                if way == 0.0 and side * (end - place) > half:
                    a, b, way = low, high, side
                    for _ in range(60):
                        middle = 0.5 * (a + b)
                        early = side * (spool_curve(c[piece], link, t0, middle).x - place) <= half
                        a, b = (middle, b) if early else (a, middle)
                    if n < most:
                        found[n, 0], found[n, 1], found[n, 2], found[n, 3] = b, link, way, place
                    n += 1
                low, x = high, end
            place = place if way == 0.0 else x - way * half
    return n


def lagging(starts: np.ndarray, c: np.ndarray, halves: np.ndarray) -> Lagging:
    """Inputs of which some lag behind, from the centre on, or from where they are if they followed at once before.

    Parameters
    ----------
    starts : (n_piece + 1,) array, s
    c : (n_piece, n_input, N_COEFFICIENT) array
        Of what drives them.
    halves : (n_piece, n_input) array, m
        Half widths; `NONE` of inputs that follow at once.
    """
    if not (halves >= 0.0).any():
        return Lagging(starts, c, c)
    found = np.empty((1024, 4))
    n = _changes(starts, c, halves, found)
    if n > len(found):
        found = np.empty((n, 4))
        _changes(starts, c, halves, found)
    found = found[:n]
    times = np.unique(found[:, 0])
    after = np.clip(np.searchsorted(starts, times), 1, len(starts) - 1)
    times = times[np.minimum(np.abs(times - starts[after - 1]), np.abs(times - starts[after])) > SAME]
    times = times[np.diff(times, prepend=-np.inf) > SAME]
    pieces = np.unique(np.concatenate([starts, times]))
    of = np.searchsorted(starts[:-1], pieces[:-1], side="right") - 1
    driven, later = c[of].copy(), (pieces[:-1] - starts[of])[:, None]
    driven[:, :, 0] += driven[:, :, 1] * later
    driven[:, :, 2] *= np.exp(-later * driven[:, :, 7])
    spools, middles = driven.copy(), 0.5 * (pieces[:-1] + pieces[1:])
    for link in np.flatnonzero((halves >= 0.0).any(axis=0)):
        own = found[found[:, 1] == link]
        _, _, way, place = own[np.searchsorted(own[:, 0], middles, side="right") - 1].T
        lags = halves[of, link] >= 0.0
        moves, stands = lags & (way != 0.0), lags & (way == 0.0)
        spools[moves, link, 0] -= (way * halves[of, link])[moves]
        spools[stands, link, 1:7] = 0.0
        spools[stands, link, 0] = place[stands]
    return Lagging(pieces, driven, spools)


def curve_at(starts: np.ndarray, c: np.ndarray, link: int, t: np.ndarray) -> np.ndarray:
    """Input number `link` at times, from pieces with these coefficients."""
    piece = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, len(c) - 1)
    c0, c1, c2, c3, c4, w, delay, rate = c[piece, link].T
    s, turn = t - starts[piece], w * (t - delay)
    return np.asarray(c0 + c1 * s + c2 * np.exp(-s * rate) + c3 * np.sin(turn) + c4 * np.cos(turn))
