"""AbductiveRegressor: polynomial abductive networks as a scikit-learn estimator."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
from sklearn.base import BaseEstimator, MultiOutputMixin, RegressorMixin
from sklearn.utils import Tags
from sklearn.utils.validation import _check_sample_weight, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.networks.growth.checked_settings import checked_settings
from polydraulic.networks.growth.far_values import warn_of_far_values
from polydraulic.networks.growth.one_output import learn_output
from polydraulic.networks.growth.synthesis import Settings, penalty, residual_variance
from polydraulic.networks.growth.training_rows import (
    SMALLEST,
    Scaling,
    TrainingRows,
    rows_apart,
    rows_from_blocks,
    rows_in_memory,
)
from polydraulic.networks.growth.unseen.row_blocks import row_blocks
from polydraulic.networks.hold_out import calibration_rows
from polydraulic.networks.intervals import stated_half_width
from polydraulic.networks.model.fitted import checked_box, predictions, settings_of, variables
from polydraulic.networks.model.history import GrowthStep
from polydraulic.networks.model.model import Model, Variable, describe
from polydraulic.networks.model.nodes import POLYNOMIALS
from polydraulic.networks.model.table import UNBOUNDED, Network

_MARGIN = 0.1  # of the range of the targets, by which output_bounds="data" widens it


class Grown(NamedTuple):
    """One output's network and how it came about; errors in squared units of y."""

    network: Network
    history: list[GrowthStep]
    fse: float
    pse: float


class AbductiveRegressor(MultiOutputMixin, RegressorMixin, BaseEstimator):
    """Polynomial abductive network: cubic nodes grown layer by layer under the predicted squared error.

    Parameters
    ----------
    max_layers : int, default=4
        Maximum number of layers; growth stops earlier when the predicted squared error no longer falls.
    n_survivors : int, default=8
        Nodes of a layer that later layers may draw on.
    kinds : sequence of str, default=("single", "double", "triple", "linear")
        Node kinds to try.
    cpm : float, default=1.0
        Complexity penalty multiplier; larger values give smaller networks.
    prior_variance : "adaptive", "half-variance" or float, default="adaptive"
        Prior error variance s_p^2 of the penalty. "adaptive" estimates it again from the residuals as the network
        grows and needs no tuning; "half-variance" is var(y) / 2, the historical choice; a number is in squared units of y.
    carve : bool, default=True
        Leave terms out of a node that cost more than they explain.
    refine : bool, default=True
        Improve all coefficients of the grown network together, by Levenberg-Marquardt.
    leave_one_out : bool, default=True
        Of all layers keep the one whose rows are predicted best by a network that has not seen them (to first order),
        and refined coefficients only if they lower this error too. It stops high powers that a few far rows decide. Rows
        of a log, given in the order of time, are left out in blocks, and the smallest network is kept that is not clearly worse.
        A network that explains no more than a search as wide finds by chance becomes a constant.
    max_inputs : int, default=30
        With more inputs than this, the search sees only that many, chosen by what they explain in Singles and Doubles.
    missing : "refuse", "drop" or "impute", default="refuse"
        What to do with NaN in X: an error; leave such rows out of the fit (and refuse them in `predict`); or put the
        mean of the column in its place, in `fit` and `predict`.
    domain : sequence of (low, high), optional
        Box in which the model holds, one pair per input; the range of the training data if not given. Inputs outside
        are moved to its border.
    output_bounds : "data", (low, high) or None, default="data"
        Predictions are clamped to these physical bounds; "data" is the range of the targets, widened by a tenth of it
        at both ends; None sets no bounds.
    calibration : float, default=0.0
        Share of the rows that is held out to state prediction intervals.
    random_state : int, RandomState or None, default=None
        Chooses the rows that are held out; without calibration nothing is random.

    Attributes
    ----------
    networks_ : list of Network
        One per output, without nodes where it is a constant; `network_` is the first.
    histories_ : list of list of GrowthStep
        The layers tried, with K, FSE, penalty and PSE in squared units of y; `history_` is the first.
    fse_, pse_ : float, or (n_output,) array
        Fitting and predicted squared error of the final network.
    residuals_ : list of (n_held_out,) array
        Sizes of the held-out residuals, rising, one array per output.
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
        kinds: Sequence[str] = POLYNOMIALS,
        cpm: float = 1.0,
        prior_variance: str | float = "adaptive",
        carve: bool = True,
        refine: bool = True,
        leave_one_out: bool = True,
        max_inputs: int = 30,
        missing: str = "refuse",
        domain: Sequence[tuple[float, float]] | None = None,
        output_bounds: str | tuple[float, float] | None = "data",
        calibration: float = 0.0,
        random_state: Any = None,
    ) -> None:
        self.max_layers = max_layers
        self.n_survivors = n_survivors
        self.kinds = kinds
        self.cpm = cpm
        self.prior_variance = prior_variance
        self.carve = carve
        self.refine = refine
        self.leave_one_out = leave_one_out
        self.max_inputs = max_inputs
        self.missing = missing
        self.domain = domain
        self.output_bounds = output_bounds
        self.calibration = calibration
        self.random_state = random_state

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()
        tags.input_tags.allow_nan = self.missing != "refuse"
        return tags

    def fit(self, X: Any, y: Any, sample_weight: Any = None, groups: Any = None) -> "AbductiveRegressor":
        """Grow a network for each output.

        Parameters
        ----------
        X : (n_row, n_input) array-like of float
            A constant column carries no information and is never chosen.
        y : (n_row,) or (n_row, n_output) array-like of finite float
        sample_weight : (n_row,) array-like, optional
            A weight acts like that many repetitions of its row.
        groups : (n_row,) array-like, optional
            Rows with the same label depend on each other and are left out together; a label for each row says that none
            do. Without groups and weights, rows
            whose inputs all move slowly from one to the next are taken for a log, and cut into stretches of time;
            shuffled rows are independent.

        Raises
        ------
        ValueError
            NaN or infinite values, fewer than four rows, settings out of range.

        Warns
        -----
        UserWarning
            A few values of `y` lie far from all others, and decide alone what is learnt.
        """
        settings = self._settings()
        X, y = validate_data(
            self, X, y, y_numeric=True, dtype=np.float64, multi_output=True, ensure_min_samples=2,
            ensure_all_finite="allow-nan" if self.missing != "refuse" else True,
        )  # fmt: skip
        y = y.astype(np.float64)
        weight = None if sample_weight is None else _check_sample_weight(sample_weight, X, ensure_non_negative=True)
        warn_of_far_values(y if weight is None else np.where(weight[:, None] > 0.0, y.reshape(len(y), -1), np.nan), 2)
        blocks = None
        if self.leave_one_out and (groups is not None or weight is None or np.all(weight == 1.0)):
            blocks = row_blocks(X if self.missing == "refuse" else np.nan_to_num(X), groups)
        X, y, weight, blocks = self._complete(X, y, weight, blocks)
        self._single_output = y.ndim == 1
        targets = y.reshape(len(y), -1)
        learn, hold = calibration_rows(len(y), self.calibration, self.random_state)
        part = None if weight is None else weight[learn]
        X_learn = X[learn]
        with one_blas_thread():
            grown = [
                self._grow(
                    rows_in_memory(X_learn, target, part),
                    settings,
                    None if blocks is None else rows_apart(X_learn, target, part, blocks[learn]),
                )
                for target in targets[learn].T
            ]
        self._finish(grown)
        predicted = np.column_stack([model.predict(X[hold]) for model in self.to_models()])
        self.residuals_ = [np.sort(np.abs(column)) for column in (predicted - targets[hold]).T]
        return self

    def fit_blocks(self, blocks: Iterable[Any]) -> "AbductiveRegressor":
        """Grow a network from rows that need not fit in memory.

        Parameters
        ----------
        blocks : iterable of (X, y) or (X, y, weight)
            Passed over many times: a list, a `ParquetBlocks`, or any object whose ``__iter__`` starts a new pass. Memory
            depends on the size of a block, not on their number. Missing values and calibration are not offered here.

        Raises
        ------
        ValueError
            As for `fit`; also blocks that can be read only once.
        """
        settings = self._settings()
        if self.missing != "refuse" or self.calibration:
            raise InputError("fit_blocks takes missing='refuse' and calibration=0: prepare the blocks, or use fit")
        rows = rows_from_blocks(blocks)
        self.n_features_in_ = len(rows.scaling.x_mean)
        self._single_output = True
        with one_blas_thread():
            self._finish([self._grow(rows, settings)])
        self.residuals_ = [np.zeros(0)]
        return self

    @overload
    def predict(self, X: Any) -> np.ndarray: ...

    @overload
    def predict(
        self, X: Any, *, return_domain: bool = ..., return_interval: float | None = ...
    ) -> np.ndarray | tuple[np.ndarray, ...]: ...

    def predict(
        self, X: Any, *, return_domain: bool = False, return_interval: float | None = None
    ) -> np.ndarray | tuple[np.ndarray, ...]:
        """Outputs for `X`, shape (n_row,), or (n_row, n_output) if fitted on several.

        Parameters
        ----------
        X : (n_row, n_input) array-like
        return_domain : bool
            Also return a (n_row,) array of bool: whether the row lies in the domain.
        return_interval : float, optional
            Also return low and high ends of intervals with this coverage, shaped like the outputs; needs
            ``calibration`` in the fit.

        Returns
        -------
        outputs, or a tuple (outputs, low, high, inside) of what was asked for
        """
        check_is_fitted(self)
        X = validate_data(
            self, X, reset=False, dtype=np.float64, ensure_all_finite="allow-nan" if self.missing == "impute" else True
        )
        if self.missing == "impute":
            X = np.where(np.isnan(X), self.impute_, X)
        y = np.column_stack([model.predict(X) for model in self.to_models()])
        half = None
        if return_interval is not None:
            half = np.array([stated_half_width(residuals, return_interval) for residuals in self.residuals_])
        inside = self.to_model().inside(X) if return_domain else None
        return predictions(y, half, inside, single=self._single_output)

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the (first) network as a model that can be saved, exported and simulated."""
        return self.to_models(inputs, None if output is None else [output])[0]

    def to_models(
        self, inputs: Sequence[Variable] | None = None, outputs: Sequence[Variable] | None = None
    ) -> list[Model]:
        """Return one model per output."""
        check_is_fitted(self)
        several = len(self.networks_) > 1
        names = outputs or [Variable(f"y{k}" if several else "y") for k in range(len(self.networks_))]
        fse, pse = np.atleast_1d(self.fse_), np.atleast_1d(self.pse_)
        return [
            Model(
                variables(self, inputs),
                name,
                (network,),
                training={"pse": float(pse[k]), "fse": float(fse[k]), **settings_of(self)},
            )
            for k, (network, name) in enumerate(zip(self.networks_, names, strict=False))
        ]

    def equations(self) -> str:
        """Equations of every output, one line per node, in normalized variables."""
        return "\n".join("\n".join(describe(model.networks[0], model.inputs)) for model in self.to_models())

    def _grow(self, rows: TrainingRows, settings: Settings, apart: TrainingRows | None = None) -> Grown:
        s = rows.scaling
        if s.weight < SMALLEST:
            weighted = any(w is not None for *_, w in rows)
            raise InputError(
                f"the weights sum to {s.weight:g}: a weight acts like that many repetitions of its row, and a network needs at "
                f"least {SMALLEST} rows; divide the weights by their mean to weigh rows against each other"
                if weighted
                else f"n_samples = {s.weight:g}: a network needs at least {SMALLEST} rows"
            )
        y_low, y_high = self._output_bounds(s)
        found = learn_output(
            rows,
            settings,
            ((y_low - s.y_mean) / s.y_scale, (y_high - s.y_mean) / s.y_scale),
            max_inputs=self.max_inputs,
            polish=self.refine,
            leave_one_out=self.leave_one_out,
            apart=apart,
        )
        fse = found.fse
        low, high = (s.x_low, s.x_high) if self.domain is None else checked_box(self.domain, len(s.x_mean))
        network = Network(
            nodes=tuple(found.nodes),
            x_mean=tuple(s.x_mean.tolist()),
            x_scale=tuple(s.x_scale.tolist()),
            x_low=tuple(low.tolist()),
            x_high=tuple(high.tolist()),
            y_mean=s.y_mean,
            y_scale=s.y_scale,
            y_low=y_low,
            y_high=y_high,
        )
        k = network.n_coefficients
        cost = penalty(settings, k, s.weight, residual_variance(fse, k, s.weight), s.y_scale**2)
        return Grown(network, found.history, fse * s.y_scale**2, (fse + cost) * s.y_scale**2)

    def _finish(self, grown: list[Grown]) -> None:
        self.networks_ = [one.network for one in grown]
        self.histories_ = [one.history for one in grown]
        self.network_, self.history_ = self.networks_[0], self.histories_[0]
        fse, pse = [one.fse for one in grown], [one.pse for one in grown]
        self.fse_: Any = fse[0] if self._single_output else np.array(fse)
        self.pse_: Any = pse[0] if self._single_output else np.array(pse)

    def _complete(
        self, X: np.ndarray, y: np.ndarray, weight: np.ndarray | None, blocks: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, np.ndarray | None]:
        """Rows to learn from: missing values dealt with, rows without weight left out."""
        used = np.ones(len(X), dtype=bool) if weight is None else weight > 0.0
        if self.missing == "drop":
            used &= ~np.isnan(X).any(axis=1)
        X, y = X[used], y[used]
        weight, blocks = (None if of_row is None else of_row[used] for of_row in (weight, blocks))
        if self.missing == "impute":
            if len(X) and np.isnan(X).all(axis=0).any():
                raise InputError(f"input {int(np.isnan(X).all(axis=0).argmax())} has no value at all: leave it out")
            self.impute_ = np.nanmean(X, axis=0) if len(X) else np.zeros(X.shape[1])
            X = np.where(np.isnan(X), self.impute_, X)
        return X, y, weight, blocks

    def _output_bounds(self, s: Scaling) -> tuple[float, float]:
        if self.output_bounds is None:
            return -UNBOUNDED, UNBOUNDED
        if isinstance(self.output_bounds, str):
            margin = _MARGIN * (s.y_high - s.y_low)
            return s.y_low - margin, s.y_high + margin
        return float(self.output_bounds[0]), float(self.output_bounds[1])

    def _settings(self) -> Settings:
        return checked_settings(self)
