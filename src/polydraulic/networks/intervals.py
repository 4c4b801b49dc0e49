"""Prediction intervals with stated coverage: split conformal, from the residuals of rows that were held out.

If new rows come from where the held-out ones came from, the interval holds the true value with at least the stated
probability, whatever the network and the noise.
"""

from fractions import Fraction
from math import ceil, inf

import numpy as np

from polydraulic.errors import InputError


def half_width(sizes: np.ndarray, coverage: float) -> float:
    """Half-width of the interval around a prediction; infinite where the rows are too few to state it.

    Of `n` rows held out and a new one, each is as likely to have the k-th smallest error: the interval is as wide as the
    smallest error whose rank reaches the coverage of ``n + 1``.

    Parameters
    ----------
    sizes : (n_held_out,) array
        Sizes of the residuals, in any order.
    coverage : float
        Probability in (0, 1), meant as the decimal number that it is written as.

    Raises
    ------
    InputError
        If the coverage is not a probability.
    """
    rank = ceil((sizes.size + 1) * _exact(coverage))
    return float(np.partition(sizes, rank - 1)[rank - 1]) if rank <= sizes.size else inf


def stated_half_width(sizes: np.ndarray, coverage: float) -> float:
    """The same for an estimator that has to state it.

    Raises
    ------
    InputError
        Also if too few rows were held out.
    """
    found = half_width(sizes, coverage)
    if found == inf:
        exact = _exact(coverage)
        raise InputError(
            f"coverage {coverage} needs at least {ceil(exact / (1 - exact))} held-out rows; this model has {sizes.size}: "
            "raise calibration"
        )
    return found


def _exact(coverage: float) -> Fraction:
    if not 0.0 < coverage < 1.0:
        raise InputError(f"coverage = {coverage!r}: must lie between 0 and 1, for example 0.9")
    return Fraction(str(float(coverage)))  # in floats, 0.55 of 100 ranks are more than 55
