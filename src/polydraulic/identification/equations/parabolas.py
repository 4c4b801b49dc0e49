"""Signals and their rates by local parabolas over five rows of one segment."""

import numpy as np

ROWS = 5
_PLACES = np.arange(ROWS) - ROWS // 2
# value, slope, curvature at the middle
_FIT = np.linalg.pinv(np.vander(_PLACES, 3, increasing=True).astype(np.float64))


def local_parabolas(values: np.ndarray, segment: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smoothed values and their changes a row: a parabola through the five rows around each, or the first or last five of its segment.

    Parameters
    ----------
    values : (n_row,) array
    segment : (n_row,) array
        Rows of one segment follow each other on the raster.

    Returns
    -------
    smooth, change : (n_row,) array
        In segments of five rows and fewer values stay as they are, and changes are zero.
    """
    n = len(values)
    smooth, change = values.astype(np.float64), np.zeros(n)
    cuts = np.flatnonzero(np.diff(segment)) + 1
    begin, end = np.concatenate([[0], cuts]), np.concatenate([cuts, [n]])
    long = end - begin > ROWS
    if not long.any():
        return smooth, change
    own = np.repeat(np.arange(len(begin)), end - begin)
    rows = np.flatnonzero(long[own])
    middle = np.clip(rows, begin[own[rows]] + ROWS // 2, end[own[rows]] - 1 - ROWS // 2)
    value, slope, bend = (sum(_FIT[k, j] * values[middle + _PLACES[j]] for j in range(ROWS)) for k in range(3))
    away = rows - middle
    smooth[rows] = value + away * (slope + away * bend)
    change[rows] = slope + 2.0 * away * bend
    return smooth, change
