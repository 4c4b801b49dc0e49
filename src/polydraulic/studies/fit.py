"""Fit a table: one model an output, with its error on rows that were held out."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from sklearn.base import clone

from polydraulic.errors import InputError
from polydraulic.networks import AbductiveRegressor, Model, RegionRegressor, Variable
from polydraulic.tables import Table

_FOLD = 5


class Fit(NamedTuple):
    """A model of all rows, and the errors on every fifth row of one fitted without them, in the output's unit."""

    model: Model
    r2: float
    rms: float
    largest: float


def fit_table(
    table: Table,
    inputs: Sequence[str],
    outputs: Sequence[str],
    estimator: AbductiveRegressor,
    edges: Mapping[str, Sequence[float]],
    max_regions: int = 1,
    progress: Callable[[str], None] = lambda step: None,
) -> list[Fit]:
    """Fit each output column from the input columns.

    Parameters
    ----------
    table : Table
    inputs, outputs : sequence of str
    estimator : AbductiveRegressor
        Cloned for every fit.
    edges : mapping from input name to edges
        Regions; empty to find them, or for one network.
    max_regions : int
        Without edges, so many regions may be found.
    progress : function of str
        Called twice an output.

    Raises
    ------
    InputError
        A column that is both input and output, a constant column, too few rows, edges of an unknown column.
    """
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(f"column {sorted(both)[0]!r} is both input and output")
    for name in [*inputs, *outputs]:
        if len(table) and np.ptp(table[name]) == 0.0:
            role = "cannot explain anything: leave it out" if name in inputs else "needs no model"
            raise InputError(f"column {name!r} is {table[name][0]:g} in all {len(table)} rows; it {role}")
    unknown = [name for name in edges if name not in inputs]
    if unknown:
        raise InputError(f"edges name the column {unknown[0]!r}; the inputs are {list(inputs)}")
    if len(table) <= _FOLD:
        raise InputError(f"the table has {len(table)} rows; fitting and holding out takes more than {_FOLD}")
    by_index = {list(inputs).index(name): cuts for name, cuts in edges.items()}
    X = table.matrix(inputs)
    held = np.arange(len(table)) % _FOLD == _FOLD - 1
    fits = []
    for output in outputs:
        y = table[output]
        regressor = RegionRegressor(estimator, edges=by_index or None, max_regions=max_regions)
        progress(f"{output}: hold out")
        error = clone(regressor).fit(X[~held], y[~held]).predict(X[held]) - y[held]
        spread = float(np.var(y[held]))
        progress(f"{output}: all rows")
        fitted = clone(regressor).fit(X, y)
        model = fitted.to_model([Variable(n, table.unit(n)) for n in inputs], Variable(output, table.unit(output)))
        mean_square = float(np.mean(error * error))
        r2 = 1.0 - mean_square / spread if spread > 0.0 else 0.0  # as scikit-learn: nothing to explain
        model.training.update({"held_out_r2": r2, "held_out_rms": mean_square**0.5, "rows": len(y)})
        fits.append(Fit(model, r2, mean_square**0.5, float(np.max(np.abs(error)))))
    return fits
