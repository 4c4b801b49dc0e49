"""DynamicRegressor: networks on lagged inputs and outputs (polynomial NARX), judged by how they run on their own."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from sklearn.base import BaseEstimator, clone
from sklearn.utils.validation import check_array, check_is_fitted, validate_data

from polydraulic.errors import InputError
from polydraulic.networks.free_run import prepare_loop, run_windows, simulate_spans
from polydraulic.networks.lag_selection import LADDER, Choice, Options, checked_lags, select
from polydraulic.networks.lags import Dynamics, Lag, Span, answered, blocks_of, lagged, rows_of, spans_of, without
from polydraulic.networks.model import Model, Variable
from polydraulic.networks.multi_step import refine_over_steps, spread
from polydraulic.networks.nodes import LINEAR
from polydraulic.networks.regressor import AbductiveRegressor, variables
from polydraulic.networks.table import Network, Node

_MARGIN = 0.1  # of their range, by which the limits of outputs and of their changes are wider than the data
_LAYERS, _OWN_LAYERS = (2, 0, 1, 3), (-1,)  # to choose from; those of a given estimator
_SMALLEST = 20  # rows that a block must hold beside the longest lag


class DynamicRegressor(BaseEstimator):
    """Network of lagged inputs and outputs, for logs.

    It predicts one row ahead from what was measured (`predict`), or runs on its own answers (`simulate`). Whatever is left open
    is chosen by the free-run error on blocks of the training rows that were held out.

    Parameters
    ----------
    estimator : AbductiveRegressor, RegionRegressor or PerceptronRegressor, optional
        Learns the next row from the lagged ones. If not given, each output has a linear network or one of one to three layers, as
        chosen.
    input_lags, output_lags : "auto" or sequence of int
        How many rows ago inputs (0 is now) and outputs are read. No output lags at all give a model without memory of its own.
    increments : "auto" or bool
        Whether networks learn the change of an output, to which its last value is added, or the output.
    horizon : "auto", int or None
        After growth all coefficients are refined over windows of so many rows that run on their own; None leaves that out.
    longest_lag : int, default=8
        Up to which lags are tried: 1, 2, 3, 4, 6, 8, 12, 16, 24, ...
    n_blocks : int, default=4
        Blocks of rows that follow each other in time, each held out once.
    raster : float, optional
        Time between rows in s; it goes into the model file.
    verbose : bool, default=False
        Print a line for each choice that is tried to standard error.

    Attributes
    ----------
    models_ : list of Model
        One an output; inputs are named ``u[t-1]``.
    choice_ : Choice
        What was chosen.
    tried_ : list of Choice
        Everything that was tried, in order; empty if nothing was left open.
    warm_up_ : int
        Rows that must be measured before the first answer.

    Notes
    -----
    A run cannot grow without bound: lagged values are moved into the range seen in training, outputs stay in the range of
    the targets and a tenth of it at both ends, and so do their changes from row to row.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> u, y = rng.uniform(-1, 1, size=400), np.zeros(400)
    >>> for t in range(1, 400):
    ...     y[t] = 0.8 * y[t - 1] + 0.3 * u[t - 1] ** 2
    >>> model = DynamicRegressor(input_lags=[1], output_lags=[1], increments=False, horizon=None)
    >>> model = model.fit(u[:200, None], y[:200])
    >>> run = model.simulate(u[200:, None], y[200:])
    >>> bool(np.abs(run - y[200:]).max() < 0.01)
    True
    """

    def __init__(
        self,
        estimator: Any = None,
        *,
        input_lags: str | Sequence[int] = "auto",
        output_lags: str | Sequence[int] = "auto",
        increments: str | bool = "auto",
        horizon: str | int | None = "auto",
        longest_lag: int = 8,
        n_blocks: int = 4,
        raster: float | None = None,
        verbose: bool = False,
    ) -> None:
        self.estimator = estimator
        self.input_lags = input_lags
        self.output_lags = output_lags
        self.increments = increments
        self.horizon = horizon
        self.longest_lag = longest_lag
        self.n_blocks = n_blocks
        self.raster = raster
        self.verbose = verbose

    def fit(self, X: Any, y: Any, segments: Any = None) -> "DynamicRegressor":
        """Choose what is left open, and learn from all rows.

        Parameters
        ----------
        X : (n_row, n_input) array-like
            Rows in time order at a constant raster. A row with NaN in `X` or `y` is a gap: nothing is learnt across it.
        y : (n_row,) or (n_row, n_output) array-like
        segments : (n_row,) array-like, optional
            Labels; rows of different labels do not follow each other.

        Raises
        ------
        ValueError
            Infinite values, settings out of range, too few rows that follow each other.
        """
        if self.raster is not None and not 0.0 < self.raster < np.inf:
            raise InputError(f"raster = {self.raster!r}: must be a time above 0 in s")
        X, y = self._checked(X, y, reset=True)
        self._single_output = y.ndim == 1
        signals = np.column_stack([X, y])
        self.n_outputs_ = signals.shape[1] - self.n_features_in_
        spans = spans_of(segments, np.isfinite(signals).all(axis=1))
        *self.tried_, self.choice_ = self._choose(signals, spans)
        self.models_ = self._learn(self.choice_, signals, spans)
        self.warm_up_ = self._dynamics.warm_up
        return self

    def simulate(self, X: Any, y: Any, *, segments: Any = None, horizon: int | None = None) -> np.ndarray:
        """Run on its own from the first `warm_up_` rows of each segment.

        Parameters
        ----------
        X : (n_row, n_input) array-like of finite float
        y : (n_row,) or (n_row, n_output) array-like
            Measured outputs, of which only the first `warm_up_` rows of each segment are read; the rest may be NaN.
        segments : (n_row,) array-like, optional
            Labels; each segment is a run of its own.
        horizon : int, optional
            Begin anew from measured outputs after so many rows.

        Returns
        -------
        array of the shape of `y`
            The measured rows at the start of each segment, then the answers.
        """
        check_is_fitted(self)
        X, y = self._checked(X, y, reset=False)
        names = self._names()
        loop = prepare_loop(self.models_, names)
        found = simulate_spans(loop, np.column_stack([X, y]), names, self.warm_up_, segments, horizon)
        return found.reshape(y.shape)

    def predict(self, X: Any, y: Any, *, segments: Any = None) -> np.ndarray:
        """Predict each row from measured ones before it; arguments and result as `simulate`."""
        return self.simulate(X, y, segments=segments, horizon=1)

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the (first) output's model, which can be saved, bounded and exported."""
        return self.to_models(inputs, None if output is None else [output])[0]

    def to_models(
        self, inputs: Sequence[Variable] | None = None, outputs: Sequence[Variable] | None = None
    ) -> list[Model]:
        """Return one model an output, with names and units of the signals (not of their lags)."""
        check_is_fitted(self)
        signals = [*variables(self, inputs), *(self._outputs() if outputs is None else outputs)]
        if len(signals) != self.n_features_in_ + self.n_outputs_:
            raise InputError(f"{len(outputs or [])} output names for a model with {self.n_outputs_} outputs")
        known = dict(zip(self._names(), signals, strict=True))
        found = []
        for model, output in zip(self.models_, signals[self.n_features_in_ :], strict=True):
            lags = tuple(Lag(known[lag.signal].name, lag.steps) for lag in self._dynamics.lags)
            units = [known[lag.signal].unit for lag in self._dynamics.lags]
            names = tuple(Variable(str(lag), unit) for lag, unit in zip(lags, units, strict=True))
            assert model.dynamics is not None
            dynamics = replace(model.dynamics, lags=lags)
            found.append(replace(model, inputs=names, output=output, dynamics=dynamics))
        return found

    def _choose(self, signals: np.ndarray, spans: list[Span]) -> list[Choice]:
        """Return everything tried, and the chosen one at the end."""
        options = self._options()
        if not options.open:
            return [options.at(1, 1)]
        blocks = self._blocks(spans, options.longest)

        def say(choice: Choice) -> None:
            if self.verbose:
                print(choice, file=sys.stderr)

        return select(options, lambda choice: self._held_out_error(choice, signals, spans, blocks), say)

    def _options(self) -> Options:
        longest = self._whole("longest_lag")
        options = Options(
            checked_lags("input_lags", self.input_lags, 0),
            checked_lags("output_lags", self.output_lags, 1),
            tuple(lag for lag in LADDER if lag <= longest),
            (True, False) if self.increments == "auto" else (bool(self.increments),),
            _LAYERS if self.estimator is None else _OWN_LAYERS,
            (None, 8, 64)
            if self.horizon == "auto"
            else (self.horizon if self.horizon is None else self._whole("horizon"),),
            self.n_outputs_,
        )
        if options.input_lags == () and options.output_lags == ():
            raise InputError("input_lags and output_lags are both empty: there is nothing to learn from")
        if options.output_lags is not None and 1 not in options.output_lags:
            if self.increments is True:
                raise InputError("increments=True adds changes to the last output: output_lags must contain 1")
            options = options._replace(increments=(False,))
        return options

    def _blocks(self, spans: list[Span], longest: int) -> list[list[Span]]:
        """Blocks to hold out, without the rows that all choices may need before."""
        blocks = [answered(block, longest) for block in blocks_of(spans, self._whole("n_blocks", 2))]
        if any(sum(b - a for a, b in block) < _SMALLEST for block in blocks):
            raise InputError(
                f"{sum(b - a for a, b in spans)} rows are too few to choose from: each of the n_blocks = {self.n_blocks} "
                f"blocks needs {_SMALLEST} rows beside longest_lag = {self.longest_lag}; give lags, or more rows"
            )
        return blocks

    def _held_out_error(
        self, choice: Choice, signals: np.ndarray, spans: list[Span], blocks: list[list[Span]]
    ) -> float:
        """Free-run error on each block of models that have not seen it."""
        outputs = signals[:, self.n_features_in_ :]
        scale, total, count = spread(outputs[rows_of(spans)]), 0.0, 0
        for block in blocks:
            # the rows before a block start its runs: they are known then, and stay out of the fit with it
            models = self._learn(choice, signals, without(spans, [(a - choice.longest, b) for a, b in block]))
            rows = rows_of(block)
            errors = (run_windows(prepare_loop(models, self._names()), signals, block)[rows] - outputs[rows]) / scale
            total += float(np.sum(errors * errors))
            count += errors.size
        return float(np.sqrt(total / count))

    def _learn(self, choice: Choice, signals: np.ndarray, spans: list[Span]) -> list[Model]:
        n, names = self.n_features_in_, self._names()
        reads = [(i, step) for i in range(n) for step in choice.input_lags]
        reads += [(n + k, step) for k in range(self.n_outputs_) for step in choice.output_lags]
        lags = tuple(Lag(names[column], step) for column, step in reads)
        targets = answered(spans, choice.longest)
        rows = rows_of(targets)
        if not rows.size:
            raise InputError(f"no {choice.longest + 1} rows follow each other: shorten the lags or fill the gaps")
        X = lagged(signals, reads, rows)
        inputs, models = [Variable(str(lag)) for lag in lags], []
        for k, output in enumerate(self._outputs()):
            y, last = signals[rows, n + k], signals[rows - 1, n + k]
            target = y - last if choice.increments else y
            if choice.layers[k] == 0:
                model = Model(tuple(inputs), output, (linear_network(X, target, _widened(target)),))
            else:
                model = self._base(choice.layers[k]).fit(X, target).to_model(inputs, output)
            step = _widened(y - last)
            if choice.increments:
                model = _added_to_last(model, reads.index((n + k, 1)), _widened(y))
            models.append(replace(model, dynamics=Dynamics(lags, step, self.raster)))
        if choice.horizon is not None:
            models = refine_over_steps(models, names, signals, targets, choice.horizon)
        return models

    def _base(self, layers: int) -> Any:
        return AbductiveRegressor(max_layers=layers) if self.estimator is None else clone(self.estimator)

    @property
    def _dynamics(self) -> Dynamics:
        found = self.models_[0].dynamics
        assert found is not None
        return found

    def _names(self) -> list[str]:
        return [variable.name for variable in (*variables(self, None), *self._outputs())]

    def _outputs(self) -> Iterator[Variable]:
        several = self.n_outputs_ > 1
        return (Variable(f"y{k}" if several else "y") for k in range(self.n_outputs_))

    def _checked(self, X: Any, y: Any, *, reset: bool) -> tuple[np.ndarray, np.ndarray]:
        X = validate_data(self, X, reset=reset, dtype=np.float64, ensure_all_finite="allow-nan")
        y = check_array(y, dtype=np.float64, ensure_2d=False, ensure_all_finite="allow-nan", input_name="y")
        if y.ndim > 2 or len(y) != len(X):
            raise InputError(f"y has shape {y.shape}; it must be ({len(X)},) or ({len(X)}, n_output)")
        if not reset and y.size != len(X) * self.n_outputs_:
            raise InputError(f"y has shape {y.shape}; the model has {self.n_outputs_} outputs")
        return X, y

    def _whole(self, name: str, least: int = 1) -> int:
        value = getattr(self, name)
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
            raise InputError(f"{name} = {value!r}: must be a whole number, at least {least}")
        return int(value)


def linear_network(X: np.ndarray, y: np.ndarray, bounds: tuple[float, float]) -> Network:
    """Least squares as a network of one linear node, with output bounds."""
    mean, scale = X.mean(axis=0), spread(X)
    coef = np.linalg.lstsq((X - mean) / scale, y - y.mean(), rcond=1e-10)[0]
    x_mean, x_scale, x_low, x_high = (tuple(end.tolist()) for end in (mean, scale, X.min(axis=0), X.max(axis=0)))
    node = Node(LINEAR, tuple(range(len(mean))), tuple(coef.tolist()))
    return Network((node,), x_mean, x_scale, x_low, x_high, float(y.mean()), 1.0, *bounds)


def _widened(values: np.ndarray) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return low - _MARGIN * (high - low), high + _MARGIN * (high - low)


def _added_to_last(model: Model, place: int, bounds: tuple[float, float]) -> Model:
    """The model of an output from that of its change: one more node adds the input `place`, the last value."""

    def added(network: Network) -> Network:
        n, mean, scale = network.n_inputs, network.x_mean[place], network.x_scale[place]
        slots = (n + len(network.nodes) - 1, place) if network.nodes else (place,)
        coef = (network.y_scale, scale) if network.nodes else (scale,)
        return replace(
            network, nodes=(*network.nodes, Node(LINEAR, slots, coef)), y_mean=network.y_mean + mean, y_scale=1.0,
            y_low=bounds[0], y_high=bounds[1],
        )  # fmt: skip

    return replace(model, networks=tuple(added(network) for network in model.networks))
