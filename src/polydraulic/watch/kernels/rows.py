"""Rows as they come: a block fills row by row, a gap begins it anew, and the next one keeps what comes before what it judges."""

from math import inf

import numpy as np

from polydraulic._kernel import driver
from polydraulic.watch.kernels.numbers import FILLED, GAPS

TAKEN, FULL, NO_NUMBER, NEVER_APART, OTHER_RASTER = 0, 1, 2, 3, 4  # what became of a row
JUDGED = 8  # of one that completed a block which was judged; what that means for alarms is added
JITTER = 0.05  # of the raster, by which rows of a block may be nearer or farther apart in the mean
MOST_GAPS = 100  # in succession, after which rows do not come at the raster
_GAP = 1.5  # times the raster


@driver
def take_row(
    time: float, row: np.ndarray, n: int, live: np.ndarray, at_rows: int, marks: np.ndarray, raster: float
) -> int:
    """Put a row behind those of a block of n rows; `marks` holds how many there are, and how many gaps there were in succession."""
    width = row.shape[0] + 1
    fine = abs(time) < inf
    for k in range(width - 1):
        fine = fine and abs(row[k]) < inf
    if not fine:
        return NO_NUMBER
    filled, gaps = marks[FILLED], 0
    if filled > 0:
        apart = time - live[at_rows + (filled - 1) * width]
        if apart <= 0.0 or apart >= _GAP * raster:
            filled = 0
            gaps = marks[GAPS] + 1
    else:
        gaps = marks[GAPS]
    at = at_rows + filled * width
    live[at] = time
    for k in range(width - 1):
        live[at + 1 + k] = row[k]
    marks[FILLED] = filled + 1
    marks[GAPS] = gaps
    if gaps > MOST_GAPS:
        return NEVER_APART
    if filled + 1 < n:
        return TAKEN
    mean = (time - live[at_rows]) / float(filled)
    if abs(mean / raster - 1.0) > JITTER:
        marks[FILLED] = 0
        return OTHER_RASTER
    return FULL


@driver
def keep_rows(live: np.ndarray, at_rows: int, n: int, inside: int, width: int, marks: np.ndarray) -> None:
    """Begin the next block with the rows behind the first `inside`."""
    for k in range((n - inside) * width):
        live[at_rows + k] = live[at_rows + inside * width + k]
    marks[FILLED] = n - inside
