"""What every estimator gives its models: names of the inputs, the domain, the settings worth keeping."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.model.model import Variable


def settings_of(estimator: Any) -> dict[str, object]:
    """Return the settings of a fit worth keeping in a model file."""
    keep = "max_layers n_survivors cpm prior_variance carve refine leave_one_out".split()
    keep += "hidden_units output beta weight_cost zero_error_radius solver".split()
    return {name: value for name, value in estimator.get_params(deep=False).items() if name in keep}


def variables(estimator: Any, inputs: Sequence[Variable] | None) -> tuple[Variable, ...]:
    """Given inputs, else the names seen in fit, else x0, x1, ..."""
    if inputs is not None:
        if len(inputs) != estimator.n_features_in_:
            raise InputError(f"{len(inputs)} input names for a model with {estimator.n_features_in_} inputs")
        return tuple(inputs)
    names = getattr(estimator, "feature_names_in_", None)
    names = [f"x{i}" for i in range(estimator.n_features_in_)] if names is None else names
    return tuple(Variable(str(name)) for name in names)


def predictions(y: np.ndarray, half: np.ndarray | None, inside: np.ndarray | None, *, single: bool) -> Any:
    """What `predict` returns: the outputs, and behind them what else was asked for.

    Parameters
    ----------
    y : (n_row, n_output) array
    half : array or None
        Half widths of intervals, to be given as lower and upper ends.
    inside : (n_row,) array of bool or None
        Whether rows lie within the domain.
    single : bool
        Whether outputs are given as (n_row,).

    Returns
    -------
    array, or tuple of arrays if there is more than one
    """
    found = [y] if half is None else [y, y - half, y + half]
    if single:
        found = [values[:, 0] for values in found]
    if inside is not None:
        found.append(inside)
    return found[0] if len(found) == 1 else tuple(found)


def checked_box(domain: Sequence[tuple[float, float]], n_input: int) -> tuple[np.ndarray, np.ndarray]:
    """Lows and highs of a given domain."""
    box = np.asarray(domain, dtype=np.float64)
    if box.shape != (n_input, 2) or not np.all(box[:, 0] <= box[:, 1]):
        raise InputError(f"domain = {domain!r}: must give (low, high) for each of the {n_input} inputs")
    return box[:, 0], box[:, 1]
