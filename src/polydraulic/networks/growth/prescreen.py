"""Prescreening: which of very many inputs a full search should see.

All Singles and Doubles over a sample of the rows are scored from pair moments, which needs no table with three variables; an
input is worth what the best node that reads it explains.
"""

import numpy as np

from polydraulic.networks.growth.moments import moments_of_blocks
from polydraulic.networks.growth.scoring import squared_errors
from polydraulic.networks.growth.training_rows import BLOCK, TrainingRows, sample_of
from polydraulic.networks.model.nodes import DOUBLE, SINGLE

_PAIRS = 200_000  # scored at a time


def promising_inputs(rows: TrainingRows, n_chosen: int) -> np.ndarray:
    """Indices of the `n_chosen` inputs that explain most in a Single or a Double, in rising order."""
    n = len(rows.scaling.x_mean)
    m = moments_of_blocks(iter(sample_of(rows, BLOCK)), n, triples=False)
    single = squared_errors(m, SINGLE, np.arange(n)[:, None])
    # a pair counts for both its inputs by what it explains beyond its better half
    best = single.copy()
    i, j = np.triu_indices(n, k=1)
    for start in range(0, len(i), _PAIRS):
        a, b = i[start : start + _PAIRS], j[start : start + _PAIRS]
        error = squared_errors(m, DOUBLE, np.column_stack([a, b]))
        gained = np.minimum(single[a], single[b]) - error
        np.minimum.at(best, a, single.max() - gained)
        np.minimum.at(best, b, single.max() - gained)
    return np.sort(np.argsort(best, kind="stable")[:n_chosen])
