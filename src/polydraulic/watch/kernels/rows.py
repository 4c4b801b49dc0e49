"""Rows as they come: a block fills row by row, a gap begins it anew, and the next one keeps what comes before what it judges."""

from math import inf

import numpy as np

from polydraulic._kernel import driver

TAKEN, FULL, NO_NUMBER, NEVER_APART, OTHER_RASTER = 0, 1, 2, 3, 4  # what became of a row
FILLED, GAPS = 0, 1  # places in `counts`
JITTER = 0.05  # of the raster, by which rows of a block may be nearer or farther apart in the mean
MOST_GAPS = 100  # in succession, after which rows do not come at the raster
_GAP = 1.5  # times the raster


@driver
def take_row(time: float, row: np.ndarray, rows: np.ndarray, counts: np.ndarray, raster: float) -> int:
    """Put a row behind those of the block; `counts` holds how many there are, and how many gaps there were in succession."""
    width = row.shape[0] + 1
    fine = abs(time) < inf
    for k in range(width - 1):
        fine = fine and abs(row[k]) < inf
    if not fine:
        return NO_NUMBER
    filled, gaps = counts[FILLED], 0
    if filled > 0:
        apart = time - rows[(filled - 1) * width]
        if apart <= 0.0 or apart >= _GAP * raster:
            filled, gaps = 0, counts[GAPS] + 1
    else:
        gaps = counts[GAPS]
    at = filled * width
    rows[at] = time
    for k in range(width - 1):
        rows[at + 1 + k] = row[k]
    counts[FILLED] = filled + 1
    counts[GAPS] = gaps
    if gaps > MOST_GAPS:
        return NEVER_APART
    if (filled + 1) * width < rows.shape[0]:
        return TAKEN
    mean = (time - rows[0]) / float(filled)
    if abs(mean / raster - 1.0) > JITTER:
        counts[FILLED] = 0
        return OTHER_RASTER
    return FULL


@driver
def keep_rows(rows: np.ndarray, counts: np.ndarray, width: int, inside: int) -> None:
    """Begin the next block with the rows behind the first `inside`."""
    kept = rows.shape[0] - inside * width
    for k in range(kept):
        rows[k] = rows[k + inside * width]
    counts[FILLED] -= inside
