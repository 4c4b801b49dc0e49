"""RegionRegressor: one model for each cell of a grid of given edges (thesis Table 3)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin, clone
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.model import Edges, Model, Variable, cell_name, cell_of, n_cells
from polydraulic.networks.regressor import AbductiveRegressor, settings_of, variables


class RegionRegressor(RegressorMixin, BaseEstimator):
    """A separate network in each cell that the edges cut out of the input space.

    Parameters
    ----------
    estimator : AbductiveRegressor, optional
        Cloned for every cell.
    edges : mapping from input (index, or column name) to rising edges
        A value on an edge belongs to the cell below it.

    Attributes
    ----------
    estimators_ : list of AbductiveRegressor
        One a cell; the last cut input varies fastest.
    edges_ : dict from input index to tuple of float
    n_features_in_ : int

    Examples
    --------
    >>> import numpy as np
    >>> X = np.linspace(-1, 1, 400)[:, None]
    >>> model = RegionRegressor(edges={0: [0.0]}).fit(X, np.abs(X[:, 0]))
    >>> round(float(model.predict([[-0.3]])[0]), 6)
    0.3
    """

    def __init__(
        self,
        estimator: AbductiveRegressor | None = None,
        edges: Mapping[Any, Sequence[float]] | None = None,
    ) -> None:
        self.estimator = estimator
        self.edges = edges

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> "RegionRegressor":
        """Fit every cell on its own rows.

        Raises
        ------
        ValueError
            As for `AbductiveRegressor`; also edges that do not rise, and cells without enough rows.
        """
        X, y = validate_data(self, X, y, y_numeric=True, dtype=np.float64, ensure_min_samples=2)
        weight = None if sample_weight is None else _check_sample_weight(sample_weight, X)
        base = AbductiveRegressor() if self.estimator is None else self.estimator
        self.edges_ = self._edges()
        cell = cell_of(self.edges_, X)
        self.estimators_ = []
        for k in range(n_cells(self.edges_)):
            rows = cell == k
            name = cell_name(self.edges_, variables(self, None), k)
            if not rows.any():
                raise InputError(f"no rows with {name}: add data there or move the edges")
            estimator = clone(base)
            if base.domain is not None:
                estimator.set_params(domain=self._cell_domain(base.domain, k))
            try:
                estimator.fit(X[rows], y[rows], None if weight is None else weight[rows])
            except ValueError as error:
                raise InputError(f"region {name}: {error}") from error
            self.estimators_.append(estimator)
        return self

    def predict(self, X: Any) -> np.ndarray:
        """Outputs for `X`, shape (n_row,)."""
        check_is_fitted(self)
        X = validate_data(self, X, reset=False, dtype=np.float64)
        return self.to_model().predict(X)

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the fitted networks as a model that can be saved, exported and simulated."""
        check_is_fitted(self)
        networks = tuple(estimator.network_ for estimator in self.estimators_)
        training = {
            "pse": [estimator.pse_ for estimator in self.estimators_],
            **settings_of(self.estimators_[0]),
        }
        return Model(variables(self, inputs), output or Variable("y"), self.edges_, networks, training)

    def _edges(self) -> Edges:
        names = [variable.name for variable in variables(self, None)]
        found: dict[int, tuple[float, ...]] = {}
        for key, cuts in (self.edges or {}).items():
            axis = names.index(key) if key in names else key
            if not isinstance(axis, int | np.integer) or not 0 <= axis < len(names):
                raise InputError(f"edges name the input {key!r}; the inputs are {names}")
            values = np.asarray(cuts, dtype=np.float64)
            if values.ndim != 1 or not values.size or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0):
                raise InputError(f"edges of {key!r} = {cuts!r}: must be rising finite numbers")
            found[int(axis)] = tuple(values.tolist())
        return found

    def _cell_domain(self, domain: Sequence[tuple[float, float]], cell: int) -> list[tuple[float, float]]:
        box = [(float(low), float(high)) for low, high in domain]
        for axis, cuts in reversed(self.edges_.items()):
            cell, place = divmod(cell, len(cuts) + 1)
            low = max(box[axis][0], cuts[place - 1]) if place else box[axis][0]
            high = min(box[axis][1], cuts[place]) if place < len(cuts) else box[axis][1]
            box[axis] = (low, high)
        return box
