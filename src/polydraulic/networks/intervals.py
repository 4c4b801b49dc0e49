"""Prediction intervals with stated coverage: split conformal, from the residuals of rows that were held out.

If new rows come from where the held-out ones came from, the interval holds the true value with at least the stated
probability, whatever the network and the noise.
"""

from math import ceil
from typing import Any

import numpy as np
from sklearn.utils import check_random_state

from polydraulic.errors import InputError


def half_width(residuals: np.ndarray, coverage: float) -> float:
    """Half-width of the interval around a prediction.

    Parameters
    ----------
    residuals : (n_held_out,) array
        Sizes of the residuals, rising.
    coverage : float
        Probability in (0, 1).

    Raises
    ------
    InputError
        If the coverage is not a probability, or too few rows were held out to state it.
    """
    if not 0.0 < coverage < 1.0:
        raise InputError(f"coverage = {coverage!r}: must lie between 0 and 1, for example 0.9")
    n = residuals.size
    rank = ceil((n + 1) * coverage)
    if rank > n:
        needed = ceil(coverage / (1.0 - coverage) - 1e-9)
        raise InputError(
            f"coverage {coverage} needs at least {needed} held-out rows; this model has {n}: raise calibration"
        )
    return float(residuals[rank - 1])


def hold_out(n: int, share: float, random_state: Any) -> tuple[np.ndarray, np.ndarray]:
    """Rows to learn from, and rows to hold out, of `n`.

    Raises
    ------
    InputError
        If the share is none.
    """
    if not 0.0 <= share < 1.0:
        raise InputError(f"calibration = {share!r}: must be a share of the rows, at least 0 and below 1")
    held = round(share * n)
    if not held:
        return np.arange(n), np.arange(0)
    chosen = check_random_state(random_state).permutation(n)
    return np.sort(chosen[held:]), np.sort(chosen[:held])
