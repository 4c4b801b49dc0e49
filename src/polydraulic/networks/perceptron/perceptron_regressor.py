"""PerceptronRegressor: the three-layer back-propagation network that abductive networks are compared with.

Thesis sections 3.2 and 4.3. The structure is the printed one; the training is what a careful user would do, so that the
comparison is a fair one: exact gradients, a quasi-Newton method, starting weights that cover the inputs, several starts.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from sklearn.base import BaseEstimator, RegressorMixin
from sklearn.utils import check_random_state
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.networks.growth.training_rows import check_narrow, check_span, constant_columns
from polydraulic.networks.hold_out import drawn_rows
from polydraulic.networks.model.fitted import checked_box, settings_of, variables
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.nodes import LINEAR, SIGMOID
from polydraulic.networks.model.table import UNBOUNDED, Network, Node
from polydraulic.networks.perceptron.back_propagation import (
    MARGIN,
    Task,
    Trained,
    descend,
    layers,
    quasi_newton,
    starting_weights,
)


class PerceptronRegressor(RegressorMixin, BaseEstimator):
    """Perceptron with one hidden layer of sigmoids g(h) = 1 / (1 + exp(-2 beta h)), trained by back-propagation.

    The loss is E = <e^2> / 2 + weight_cost sum W^2 / 2, with e = (prediction - y) / range of y and <> the mean over rows.

    Parameters
    ----------
    hidden_units : int, default=15
    output : "sigmoid" or "linear", default="sigmoid"
        Output unit. A sigmoid spans the range of y with a margin at both ends, so that it need not saturate.
    beta : float, default=0.5
        Steepness of the sigmoids; 0.5 is the logistic function. Starting weights are divided by it, so that it acts
        through `weight_cost` and `eta` alone.
    weight_cost : float, default=0.0
        Penalty on the squared weights of all connections; biases are free.
    zero_error_radius : float, default=0.0
        An error counts by what it exceeds this share of the range of y.
    solver : "lbfgs" or "gradient", default="lbfgs"
        "gradient" is plain gradient descent over all rows at once, dW = -eta dE/dW + momentum * (last dW). The printed
        rule sums over the rows where E takes the mean: its eta is this one divided by the number of rows.
    eta : float, default=0.2
        Learning rate of "gradient"; a sigmoid output bears larger ones than a linear output.
    momentum : float, default=0.0
        Share of the last step that "gradient" repeats, below 1; the printed rule has none.
    max_iter : int, default=1000
        Maximum number of iterations, each over all rows.
    tol : float, default=1e-5
        Training ends when 100 iterations lower the loss by less than this share.
    n_starts : int, default=3
        Random starts, of which the one with the smallest loss is kept.
    random_state : int, RandomState or None, default=0
        Source of the starting weights.
    domain : sequence of (low, high), optional
        Box in which the model holds, one pair per input; the range of the training data if not given. Inputs outside
        are moved to its border.
    output_bounds : (low, high), optional
        Physical bounds of the output; predictions are clamped to them.

    Attributes
    ----------
    network_ : Network
        Sigmoid nodes over the inputs and one node over them: evaluated, bounded, saved and exported like any other network.
    weights_ : tuple of ndarray
        Weights of the hidden units (hidden_units, n_input + 1) and of the output (hidden_units + 1,), biases last.
    loss_ : float
        E of the start that was kept.
    history_ : (n,) ndarray
        E before each of its iterations, and at the end.
    n_iter_ : int
    n_features_in_ : int
    feature_names_in_ : ndarray of str
        Only if fitted on a frame with column names.

    Examples
    --------
    >>> import numpy as np
    >>> X = np.random.default_rng(0).uniform(size=(200, 2))
    >>> model = PerceptronRegressor(hidden_units=5).fit(X, X[:, 0] * X[:, 1])
    >>> round(float(model.predict([[0.5, 0.4]])[0]), 2)
    0.2
    """

    def __init__(
        self,
        *,
        hidden_units: int = 15,
        output: str = "sigmoid",
        beta: float = 0.5,
        weight_cost: float = 0.0,
        zero_error_radius: float = 0.0,
        solver: str = "lbfgs",
        eta: float = 0.2,
        momentum: float = 0.0,
        max_iter: int = 1000,
        tol: float = 1e-5,
        n_starts: int = 3,
        random_state: int | np.random.RandomState | None = 0,
        domain: Sequence[tuple[float, float]] | None = None,
        output_bounds: tuple[float, float] | None = None,
    ) -> None:
        self.hidden_units = hidden_units
        self.output = output
        self.beta = beta
        self.weight_cost = weight_cost
        self.zero_error_radius = zero_error_radius
        self.solver = solver
        self.eta = eta
        self.momentum = momentum
        self.max_iter = max_iter
        self.tol = tol
        self.n_starts = n_starts
        self.random_state = random_state
        self.domain = domain
        self.output_bounds = output_bounds

    def fit(self, X: Any, y: Any, sample_weight: Any = None) -> "PerceptronRegressor":
        """Train the weights.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
            A constant column carries no information; its weights are zero.
        y : (n_row,) array-like of finite float
        sample_weight : (n_row,) array-like, optional
            A weight acts like that many repetitions of its row.

        Raises
        ------
        ValueError
            NaN or infinite values, settings out of range, an `eta` with which the loss grows without bound.
        """
        self._check_settings()
        X, y = validate_data(self, X, y, y_numeric=True, dtype=np.float64, ensure_min_samples=2)
        weight = (
            np.ones(len(y))
            if sample_weight is None
            else _check_sample_weight(sample_weight, X, ensure_non_negative=True)
        )
        X, y, weight = _merge_rows(X, y.astype(np.float64), weight)
        low, high = X.min(axis=0), X.max(axis=0)
        y_least = float(y.min())
        with np.errstate(over="ignore"):
            span, y_span = high - low, float(y.max() - y_least)
        if not np.all(np.isfinite([*span, y_span])):
            raise InputError("the values are too large for their range to be a number: scale the columns")
        varies = ~constant_columns(low, high, low, [f"input {place}" for place in range(len(low))])
        scale = np.where(varies, span, 1.0)
        check_narrow(scale)
        task = Task(
            inputs=np.column_stack([np.where(varies, (X - low) / scale, 0.0), np.ones(len(y))]),
            target=(y - y_least) / (y_span or 1.0),
            share=weight / weight.sum(),
            hidden_units=int(self.hidden_units),
            beta=float(self.beta),
            weight_cost=float(self.weight_cost),
            zero_error_radius=float(self.zero_error_radius),
            sigmoid=self.output == "sigmoid",
        )
        found = self._train(task, varies)
        self.history_ = np.array(found.history)
        self.loss_, self.n_iter_ = found.history[-1], len(found.history) - 1
        self.weights_ = layers(found.weights, task)
        box = (
            np.column_stack([low, high]) if self.domain is None else np.column_stack(checked_box(self.domain, len(low)))
        )
        bounds = (-UNBOUNDED, UNBOUNDED) if self.output_bounds is None else self.output_bounds
        margin = MARGIN if task.sigmoid else 0.0
        stretch = y_span / (1.0 - 2.0 * margin)
        nodes, constant = _nodes(self.weights_, task)
        self.network_ = Network(
            nodes=nodes,
            x_mean=tuple(low.tolist()),
            x_scale=tuple(scale.tolist()),
            x_low=tuple(box[:, 0].tolist()),
            x_high=tuple(box[:, 1].tolist()),
            y_mean=y_least + (constant - margin) * stretch,
            y_scale=stretch,
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
        """Return the network as a model that can be saved, exported and simulated."""
        check_is_fitted(self)
        training = {"loss": self.loss_, **settings_of(self)}
        return Model(variables(self, inputs), output or Variable("y"), (self.network_,), training=training)

    def _train(self, task: Task, varies: np.ndarray) -> Trained:
        random = check_random_state(self.random_state)
        runs = []
        # The matrices are slim: a second thread costs more than it brings, and would change the order of sums.
        with one_blas_thread():
            for _ in range(self.n_starts):
                start = starting_weights(random, task, varies)
                if self.solver == "lbfgs":
                    runs.append(quasi_newton(start, task, int(self.max_iter), self.tol))
                else:
                    runs.append(descend(start, task, self.eta, self.momentum, int(self.max_iter), self.tol))
        return min(runs, key=lambda run: run.history[-1])

    def _check_settings(self) -> None:
        for name in ("hidden_units", "max_iter", "n_starts"):
            value = getattr(self, name)
            if not isinstance(value, int | np.integer) or value < 1:
                raise InputError(f"{name} = {value!r}: must be a whole number, at least 1")
        for name, allowed in (("output", ("sigmoid", "linear")), ("solver", ("lbfgs", "gradient"))):
            value = getattr(self, name)
            if value not in allowed:
                raise InputError(f"{name} = {value!r}: must be one of {allowed}")
        for name in ("beta", "eta"):
            value = getattr(self, name)
            if not 0.0 < value < np.inf:
                raise InputError(f"{name} = {value!r}: must be above 0 and finite")
        for name, limit in (("weight_cost", np.inf), ("zero_error_radius", 1.0), ("momentum", 1.0), ("tol", 1.0)):
            value = getattr(self, name)
            if not 0.0 <= value < limit:
                raise InputError(f"{name} = {value!r}: must be at least 0 and below {limit:g}")
        if self.output_bounds is not None and not self.output_bounds[0] <= self.output_bounds[1]:
            raise InputError(f"output_bounds = {self.output_bounds}: the first must not exceed the second")


class SweepPoint(NamedTuple):
    """Errors of a perceptron with this many hidden units, in units of y."""

    hidden_units: int
    training_rms: float
    held_out_rms: float


def hidden_unit_sweep(
    X: Any, y: Any, units: Sequence[int], *, held_out: float = 0.25, **settings: Any
) -> list[SweepPoint]:
    """Error against the number of hidden units (thesis Fig 4-18).

    Parameters
    ----------
    X : (n_row, n_input) array-like
    y : (n_row,) array-like
    units : sequence of int
        Numbers of hidden units, each fitted on the same rows.
    held_out : float
        Share of the rows, chosen at random, that no fit sees.
    **settings
        Other settings of `PerceptronRegressor`; `random_state` also chooses the rows.

    Raises
    ------
    InputError
        If the share leaves fewer than two rows to either side.
    """
    X, y = np.asarray(X, dtype=np.float64), np.asarray(y, dtype=np.float64)
    n_held = round(held_out * len(y))
    if not 2 <= n_held <= len(y) - 2:
        raise InputError(f"held_out = {held_out!r}: must leave at least 2 of the {len(y)} rows to either side")
    kept, held = drawn_rows(len(y), n_held, settings.get("random_state", 0))
    points = []
    for n in units:
        model = PerceptronRegressor(hidden_units=n, **settings).fit(X[kept], y[kept])
        errors = (float(np.sqrt(np.mean((model.predict(X[rows]) - y[rows]) ** 2))) for rows in (kept, held))
        points.append(SweepPoint(n, *errors))
    return points


def _merge_rows(X: np.ndarray, y: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Sort the rows, merge equal ones, drop those without weight.

    Training amplifies rounding, so that sums taken in another order end in another minimum. Merged, a weight and as many
    repetitions give the same bits, in any order of rows.
    """
    rows, place = np.unique(np.column_stack([X, y])[weight > 0.0], axis=0, return_inverse=True)
    if not len(rows):
        raise InputError("sample_weight: no row has a weight above 0")
    merged = np.bincount(place.ravel(), weights=weight[weight > 0.0])
    check_span(float(merged.min()), float(merged.max()))
    return rows[:, :-1], rows[:, -1], merged


def _nodes(weights: tuple[np.ndarray, np.ndarray], task: Task) -> tuple[tuple[Node, ...], float]:
    """The perceptron as nodes, and a constant to add to the last of them, which a linear node has not."""
    hidden, output = weights
    n_input, steep = hidden.shape[1] - 1, 2.0 * task.beta
    units = [
        Node(SIGMOID, tuple(range(n_input)), tuple((steep * np.roll(unit, 1)).tolist()))  # biases first
        for unit in hidden
    ]
    slots = tuple(range(n_input, n_input + len(units)))
    if task.sigmoid:
        return (*units, Node(SIGMOID, slots, tuple((steep * np.roll(output, 1)).tolist()))), 0.0
    return (*units, Node(LINEAR, slots, tuple(output[:-1].tolist()))), float(output[-1])
