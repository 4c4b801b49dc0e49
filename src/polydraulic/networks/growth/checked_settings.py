"""Settings of an estimator, refused where they make no sense."""

from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.growth.synthesis import Settings
from polydraulic.networks.model.nodes import POLYNOMIALS

_MISSING = ("refuse", "drop", "impute")


def checked_settings(estimator: Any) -> Settings:
    """What steers the search, of an `AbductiveRegressor`.

    Raises
    ------
    InputError
        A setting out of its range; those that do not steer the search are looked at, too.
    """
    kinds = tuple(estimator.kinds)
    if not kinds or any(kind not in POLYNOMIALS for kind in kinds):
        raise InputError(f"kinds = {kinds}: must be one or more of {POLYNOMIALS}")
    for name in ("max_layers", "n_survivors", "max_inputs"):
        value = getattr(estimator, name)
        if not isinstance(value, int | np.integer) or value < 1:
            raise InputError(f"{name} = {value!r}: must be a whole number, at least 1")
    if not 0.0 <= estimator.cpm < np.inf:
        raise InputError(f"cpm = {estimator.cpm!r}: must be at least 0 and finite")
    if estimator.missing not in _MISSING:
        raise InputError(f"missing = {estimator.missing!r}: must be one of {_MISSING}")
    prior = estimator.prior_variance
    if isinstance(prior, str) and prior not in ("adaptive", "half-variance"):
        raise InputError(f"prior_variance = {prior!r}: 'adaptive', 'half-variance' or a number")
    if not isinstance(prior, str) and not 0.0 <= float(prior) < np.inf:
        raise InputError(f"prior_variance = {prior!r}: must be at least 0 and finite")
    bounds = estimator.output_bounds
    good = bounds is None or bounds == "data" or (not isinstance(bounds, str) and bounds[0] <= bounds[1])
    if not good:
        raise InputError(f"output_bounds = {bounds!r}: must be 'data', None, or (low, high) with low <= high")
    return Settings(
        kinds, int(estimator.max_layers), int(estimator.n_survivors), float(estimator.cpm), prior, bool(estimator.carve)
    )
