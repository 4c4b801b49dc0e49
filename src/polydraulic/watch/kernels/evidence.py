"""Evidence of all tests, block by block: sums that begin anew where they are negative."""

import numpy as np

from polydraulic._kernel import driver

KEPT = 600  # blocks back to which a beginning can lie
LEAST_BLOCKS = 8  # that decide together
_MOST = 2.0  # thresholds that a sum may reach


@driver
def gather(
    pull: np.ndarray,
    information: np.ndarray,
    together: np.ndarray,
    down: np.ndarray,
    threshold: float,
    count: int,
    sums: np.ndarray,
    began: np.ndarray,
    showing: np.ndarray,
    totals: np.ndarray,
) -> None:
    """Take a block's whitened scores.

    `count` is the number of blocks with this one; sums and beginnings hold both ways of each direction, up and down (where `down` is 1);
    `totals` rows of pull, information and squares of pull over information of all directions, the last `KEPT` + 1 of them, in a ring.
    """
    n = pull.shape[0]
    most = threshold / float(LEAST_BLOCKS)
    before = _ring(count - 1) * 3 * n
    here = _ring(count) * 3 * n
    for k in range(n):
        own, known = pull[k], information[k]
        for way in range(2):
            gained = ((own if way == 0 else -own) - 0.5 * known) / together[k]
            total = sums[2 * k + way] + min(max(gained, -most), most)
            fresh = total <= 0.0
            goes = way == 0 or down[k] != 0
            sums[2 * k + way] = 0.0 if fresh or not goes else min(total, _MOST * threshold)
            began[2 * k + way] = count if fresh else began[2 * k + way]
        showing[k] += min(0.5 * known / together[k], most)
        square = own * own / max(known, 1e-300) if known > 0.0 else 0.0
        totals[here + k] = totals[before + k] + own
        totals[here + n + k] = totals[before + n + k] + known
        totals[here + 2 * n + k] = totals[before + 2 * n + k] + square


@driver
def _ring(block: int) -> int:
    """Place of a block among those that are kept; the first of all blocks has the place 0."""
    return block - (KEPT + 1) * int(float(block) / float(KEPT + 1))
