"""AbductiveRegressor: a polynomial abductive network as a scikit-learn estimator."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.model import Model, Variable
from polydraulic.networks.nodes import KIND_NAMES
from polydraulic.networks.synthesis import Settings, synthesize
from polydraulic.networks.table import UNBOUNDED, Network

_SMALLEST = 4  # coefficients of the smallest node with a constant


class AbductiveRegressor(RegressorMixin, BaseEstimator):
    """Polynomial abductive network: cubic nodes grown layer by layer under the predicted squared error.

    Parameters
    ----------
    max_layers : int, default=4
        Layers at most; growth stops earlier when the predicted squared error no longer falls.
    n_survivors : int, default=8
        Nodes of a layer that later layers may draw on.
    kinds : sequence of str, default=("single", "double", "triple", "linear")
        Node kinds to try.
    cpm : float, default=1.0
        Complexity penalty multiplier; larger values give smaller networks.
    prior_variance : "adaptive", "half-variance" or float, default="adaptive"
        Prior error variance s_p^2 of the penalty. "adaptive" estimates it again from the residuals as the network
        grows and needs no tuning; "half-variance" is var(y) / 2, the historical choice; a number is in squared units of y.
    domain : sequence of (low, high), optional
        Box in which the model holds, one pair an input; the range of the training data if not given. Inputs outside
        are moved to its border.
    output_bounds : (low, high), optional
        Physical bounds of the output; predictions are clamped to them.

    Attributes
    ----------
    network_ : Network
        Nodes, normalizers, unitizer, domain.
    history_ : list of Step
        The layers tried, with K, FSE, penalty and PSE in squared units of y.
    fse_, pse_ : float
        Fitting and predicted squared error of the chosen network.
    n_features_in_ : int
    feature_names_in_ : ndarray of str
        Only if fitted on a frame with column names.

    Examples
    --------
    >>> import numpy as np
    >>> X = np.random.default_rng(0).uniform(size=(500, 2))
    >>> model = AbductiveRegressor().fit(X, X[:, 0] * X[:, 1])
    >>> round(float(model.predict([[0.5, 0.4]])[0]), 6)
    0.2
    """

    def __init__(
        self,
        *,
        max_layers: int = 4,
        n_survivors: int = 8,
        kinds: Sequence[str] = KIND_NAMES,
        cpm: float = 1.0,
        prior_variance: str | float = "adaptive",
        domain: Sequence[tuple[float, float]] | None = None,
        output_bounds: tuple[float, float] | None = None,
    ) -> None:
        self.max_layers = max_layers
        self.n_survivors = n_survivors
        self.kinds = kinds
        self.cpm = cpm
        self.prior_variance = prior_variance
        self.domain = domain
        self.output_bounds = output_bounds

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> "AbductiveRegressor":
        """Grow a network.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
            A constant column carries no information and is never chosen.
        y : (n_row,) array-like of finite float
        sample_weight : (n_row,) array-like, optional
            A weight acts like that many repetitions of its row.

        Raises
        ------
        ValueError
            NaN or infinite values, fewer rows than the smallest node has coefficients, settings out of range.
        """
        settings = self._settings()
        X, y = validate_data(self, X, y, y_numeric=True, dtype=np.float64, ensure_min_samples=2)
        y = y.astype(np.float64)
        weight = None if sample_weight is None else _check_sample_weight(sample_weight, X, ensure_non_negative=True)
        if weight is not None:
            used = weight > 0.0
            X, y, weight = X[used], y[used], weight[used]
        rows = len(y) if weight is None else float(weight.sum())
        if rows < _SMALLEST:
            raise InputError(
                f"n_samples = {rows:g}: a network needs at least {_SMALLEST} rows, the coefficients of its smallest node"
            )
        low, high = X.min(axis=0), X.max(axis=0)
        if self.domain is not None:
            low, high = _box(self.domain, X.shape[1])
        with np.errstate(over="ignore", invalid="ignore"):
            x_mean, x_scale = _mean_and_spread(X, weight)
            y_mean, y_scale = (float(value) for value in _mean_and_spread(y, weight))
        if not np.all(np.isfinite([*x_mean, *x_scale, y_mean, y_scale * y_scale])):
            raise InputError("the values are too large for their squares to be numbers: scale the columns")
        bounds = (-UNBOUNDED, UNBOUNDED) if self.output_bounds is None else self.output_bounds
        if not bounds[0] <= bounds[1]:
            raise InputError(f"output_bounds = {bounds}: the first must not exceed the second")
        nodes, self.history_ = synthesize(
            (X - x_mean) / x_scale, (y - y_mean) / y_scale, weight, y_scale * y_scale, settings
        )
        chosen = [step for step in self.history_ if step.accepted][-1]
        self.fse_, self.pse_ = chosen.fse, chosen.pse
        self.network_ = Network(
            nodes=tuple(nodes),
            x_mean=tuple(x_mean.tolist()),
            x_scale=tuple(x_scale.tolist()),
            x_low=tuple(low.tolist()),
            x_high=tuple(high.tolist()),
            y_mean=y_mean,
            y_scale=y_scale,
            y_low=float(bounds[0]),
            y_high=float(bounds[1]),
        )
        return self

    def predict(self, X: Any) -> np.ndarray:
        """Outputs for `X`, shape (n_row,)."""
        check_is_fitted(self)
        X = validate_data(self, X, reset=False, dtype=np.float64)
        return self.to_model().predict(X)

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the fitted network as a model that can be saved, exported and simulated."""
        check_is_fitted(self)
        training = {"pse": self.pse_, "fse": self.fse_, "layers": sum(s.accepted for s in self.history_) - 1}
        return Model(
            variables(self, inputs),
            output or Variable("y"),
            {},
            (self.network_,),
            {**training, **settings_of(self)},
        )

    def _settings(self) -> Settings:
        kinds = tuple(self.kinds)
        unknown = [kind for kind in kinds if kind not in KIND_NAMES]
        if unknown or not kinds:
            raise InputError(f"kinds = {kinds}: must be one or more of {KIND_NAMES}")
        for name, low in (("max_layers", 1), ("n_survivors", 1)):
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or value < low:
                raise InputError(f"{name} = {value!r}: must be a whole number, at least {low}")
        if not self.cpm >= 0.0:
            raise InputError(f"cpm = {self.cpm!r}: must be at least 0")
        named = isinstance(self.prior_variance, str)
        if named and self.prior_variance not in ("adaptive", "half-variance"):
            raise InputError(f"prior_variance = {self.prior_variance!r}: 'adaptive', 'half-variance' or a number")
        if not named and not float(self.prior_variance) >= 0.0:
            raise InputError(f"prior_variance = {self.prior_variance!r}: must be at least 0")
        return Settings(kinds, int(self.max_layers), int(self.n_survivors), float(self.cpm), self.prior_variance)


def settings_of(estimator: BaseEstimator) -> dict[str, object]:
    """Return the settings of a fit worth keeping in a model file."""
    keep = ("max_layers", "n_survivors", "cpm", "prior_variance")
    return {name: value for name, value in estimator.get_params(deep=False).items() if name in keep}


def variables(estimator: BaseEstimator, inputs: Sequence[Variable] | None) -> tuple[Variable, ...]:
    """Given inputs, else the names seen in fit, else x0, x1, ..."""
    if inputs is not None:
        if len(inputs) != estimator.n_features_in_:
            raise InputError(f"{len(inputs)} input names for a model with {estimator.n_features_in_} inputs")
        return tuple(inputs)
    names = getattr(estimator, "feature_names_in_", None)
    names = [f"x{i}" for i in range(estimator.n_features_in_)] if names is None else names
    return tuple(Variable(str(name)) for name in names)


def _mean_and_spread(values: np.ndarray, weight: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation; 1 instead of the deviation where all values are equal."""
    mean = np.average(values, axis=0, weights=weight)
    spread = np.sqrt(np.average((values - mean) ** 2, axis=0, weights=weight))
    constant = np.ptp(values, axis=0) <= 1e-12 * np.abs(mean)
    mean = np.where(constant, values[0], mean) + 0.0  # no negative zeros in files
    return mean, np.where(constant | (spread == 0.0), 1.0, spread)


def _box(domain: Sequence[tuple[float, float]], n_input: int) -> tuple[np.ndarray, np.ndarray]:
    box = np.asarray(domain, dtype=np.float64)
    if box.shape != (n_input, 2) or not np.all(box[:, 0] <= box[:, 1]):
        raise InputError(f"domain = {domain!r}: must give (low, high) for each of the {n_input} inputs")
    return box[:, 0], box[:, 1]
