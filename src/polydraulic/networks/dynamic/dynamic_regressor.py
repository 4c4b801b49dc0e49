"""DynamicRegressor: networks on lagged inputs and outputs (polynomial NARX), judged by how they run on their own."""

import logging
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
from sklearn.base import clone

from polydraulic.errors import InputError
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.networks.dynamic.free_run import prepare_loop, run_windows
from polydraulic.networks.dynamic.free_runner import FreeRunner
from polydraulic.networks.dynamic.lag_selection import LADDER, Choice, Options, checked_lags, select, select_terms
from polydraulic.networks.dynamic.lagged_terms import Frame, Terms, frame_of
from polydraulic.networks.dynamic.refine_free_run import refine_over_steps, spread
from polydraulic.networks.dynamic.spans import Span, answered, blocks_of, lagged, rows_of, spans_of, without
from polydraulic.networks.dynamic.term_growth import grow_average, grow_terms
from polydraulic.networks.dynamic.term_network import places_read, term_networks
from polydraulic.networks.growth.workers import in_threads
from polydraulic.networks.model.lags import Dynamics, Lag
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.nodes import LINEAR
from polydraulic.networks.model.table import Network, Node
from polydraulic.progress import Progress, quiet

_log = logging.getLogger(__name__)
_MARGIN = 0.1  # of their range, by which the limits of outputs and of their changes are wider than the data
_HORIZONS, _OWN_HORIZONS = (8, 16, 32, 64, 128, 256), (None, 8, 64)  # to choose from; for a given estimator
_PATIENCE = 8  # so many more terms of each output without a gain end the growth
_SMALLEST = 20  # rows that a block must hold beside the longest lag
_THINNEST, _LARGEST = 1e-150, 1e150  # of signals, whose squares are to be numbers with all digits


class DynamicRegressor(FreeRunner):
    """Network of lagged inputs and outputs, for logs.

    It predicts one row ahead from what was measured (`predict`), or runs on its own predictions (`simulate`). Whatever is left open
    is chosen by the free-run error on blocks of the training rows that were held out.

    Parameters
    ----------
    estimator : AbductiveRegressor, RegionRegressor or PerceptronRegressor, optional
        Learns the next row from the lagged ones. If not given, each output has a polynomial, grown term by term by how it runs on
        its own.
    input_lags, output_lags : "auto" or sequence of int
        How many rows ago inputs (0 is now) and outputs may be read. No output lags at all give a model without memory of its own.
    increments : "auto" or bool
        Whether a given estimator learns the change of an output, to which its last value is added, or the output. For polynomials
        it is the same: the last value is a term of theirs.
    horizon : "auto", int or None
        Polynomials fit runs of this many rows, given estimators are refined to do so; None is one step ahead.
    max_terms : int, default=20
        Of each output's polynomial, while it is being chosen.
    longest_lag : int, default=8
        Up to which lags are tried: 1, 2, 3, 4, 6, 8, 12, 16, 24, ...
    n_blocks : int, default=4
        Blocks of rows that follow each other in time, each held out once.
    raster : float, optional
        Time between rows in s; it goes into the model file.
    progress : Progress, optional
        Told each choice of lags and horizon that was tried.

    Attributes
    ----------
    models_ : list of Model
        One per output; inputs are named ``u[t-1]``.
    choice_ : Choice
        What was chosen.
    tried_ : list of Choice
        Everything that was tried, in order; empty if nothing was left open.
    warm_up_ : int
        Rows that must be measured before the first answer.

    Notes
    -----
    A run cannot grow without bound: lagged values are moved into the range seen in training, outputs stay in the range of
    the targets widened by a tenth at both ends, and so do their changes from row to row.

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
        max_terms: int = 20,
        longest_lag: int = 8,
        n_blocks: int = 4,
        raster: float | None = None,
        progress: Progress = quiet,
    ) -> None:
        self.estimator = estimator
        self.input_lags = input_lags
        self.output_lags = output_lags
        self.increments = increments
        self.horizon = horizon
        self.max_terms = max_terms
        self.longest_lag = longest_lag
        self.n_blocks = n_blocks
        self.raster = raster
        self.progress = progress

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
        _check_sizes(signals[rows_of(spans)], self._names())
        with one_blas_thread():
            *self.tried_, self.choice_ = self._choose(signals, spans)
            self.models_ = self._learn(self.choice_, signals, spans)
        self.warm_up_ = self._dynamics.warm_up
        return self

    def to_model(self, inputs: Sequence[Variable] | None = None, output: Variable | None = None) -> Model:
        """Return the (first) output's model, which can be saved, bounded and exported."""
        return self.to_models(inputs, None if output is None else [output])[0]

    def _choose(self, signals: np.ndarray, spans: list[Span]) -> list[Choice]:
        """Return everything tried, and the chosen one at the end."""
        options = self._options()
        if self.estimator is not None and not options.open:
            return [options.at(1, 1)]
        blocks, tried = self._blocks(spans, options.longest), count(1)

        def tell(choice: Choice) -> None:
            _log.info("%s", choice)
            self.progress(f"lags to {choice.longest}, error {choice.error:.2f}", next(tried), options.most)

        if self.estimator is None:
            return select_terms(options, lambda choice: self._held_out_path(choice, signals, spans, blocks), tell)
        return select(options, lambda choice: self._held_out_error(choice, signals, spans, blocks), tell)

    def _options(self) -> Options:
        longest, own = self._whole("longest_lag"), self.estimator is not None
        horizons: tuple[int | None, ...] = _OWN_HORIZONS if own else _HORIZONS
        if self.horizon != "auto":
            horizons = (None if self.horizon is None else self._whole("horizon"),)
        options = Options(
            checked_lags("input_lags", self.input_lags, 0),
            checked_lags("output_lags", self.output_lags, 1),
            tuple(lag for lag in LADDER if lag <= longest),
            (bool(self.increments),) if self.increments != "auto" else (True, False) if own else (False,),
            horizons,
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
                f"blocks needs {_SMALLEST} rows beside the longest lag, {longest}; shorten the lags, or record more rows"
            )
        return blocks

    def _held_out_error(
        self, choice: Choice, signals: np.ndarray, spans: list[Span], blocks: list[list[Span]]
    ) -> float:
        """Free-run error on each block of models that have not seen it."""
        scale = spread(signals[rows_of(spans), self.n_features_in_ :])

        def error(block: list[Span]) -> float:
            models = self._learn(choice, signals, _but(spans, block, choice.longest))
            return self._run_error(models, signals, block, scale)

        return float(np.mean(in_threads(error, blocks)))

    def _held_out_path(
        self, choice: Choice, signals: np.ndarray, spans: list[Span], blocks: list[list[Span]]
    ) -> list[Choice]:
        """The same for polynomials of one term more at a time, until more of them do not help any more."""
        scale, found = spread(signals[rows_of(spans), self.n_features_in_ :]), list[Choice]()
        most = self._whole("max_terms") * self.n_outputs_
        paths = [self._polynomials(choice, signals, _but(spans, block, choice.longest)) for block in blocks]

        def one_more(place: int) -> tuple[int, float] | None:
            step = next(paths[place], None)
            return None if step is None else (step[0], self._run_error(step[1], signals, blocks[place], scale))

        while all(steps := in_threads(one_more, range(len(blocks)))):
            (terms, _), *_ = known = [step for step in steps if step is not None]
            found.append(choice._replace(terms=terms, error=float(np.mean([error for _, error in known]))))
            best = int(np.argmin([one.error for one in found]))
            if terms >= most or len(found) - 1 - best >= _PATIENCE * self.n_outputs_:
                break
        return found

    def _run_error(self, models: list[Model], signals: np.ndarray, block: list[Span], scale: np.ndarray) -> float:
        rows, outputs = rows_of(block), signals[:, self.n_features_in_ :]
        errors = (run_windows(prepare_loop(models, self._names()), signals, block)[rows] - outputs[rows]) / scale
        return float(np.sqrt(np.mean(errors * errors)))

    def _learn(self, choice: Choice, signals: np.ndarray, spans: list[Span]) -> list[Model]:
        if choice.terms is not None:
            frame, targets = self._frame(choice, signals, spans)
            terms = grow_average(frame, targets, choice.horizon or 1, choice.terms)
            return self._models(frame, terms, targets)
        n, names = self.n_features_in_, self._names()
        reads = self._reads(choice)
        lags = tuple(Lag(names[column], step) for column, step in reads)
        targets = _targets(spans, choice)
        rows = rows_of(targets)
        X = lagged(signals, reads, rows)
        inputs, models = [Variable(str(lag)) for lag in lags], []
        for k, output in enumerate(self._outputs()):
            y, last = signals[rows, n + k], signals[rows - 1, n + k]
            model = clone(self.estimator).fit(X, y - last if choice.increments else y).to_model(inputs, output)
            if choice.increments:
                model = _added_to_last(model, reads.index((n + k, 1)), _widened(y))
            models.append(replace(model, dynamics=Dynamics(lags, _widened(y - last), self.raster)))
        if choice.horizon is not None:
            models = refine_over_steps(models, names, signals, targets, choice.horizon)
        return models

    def _polynomials(self, choice: Choice, signals: np.ndarray, spans: list[Span]) -> Iterator[tuple[int, list[Model]]]:
        """Numbers of terms, and models of this many."""
        frame, targets = self._frame(choice, signals, spans)
        for terms in grow_terms(frame, targets, choice.horizon or 1):
            yield len(terms.coef), self._models(frame, terms, targets)

    def _frame(self, choice: Choice, signals: np.ndarray, spans: list[Span]) -> tuple[Frame, list[Span]]:
        targets = _targets(spans, choice)
        return frame_of(signals, self.n_outputs_, self._reads(choice), targets, _MARGIN), targets

    def _models(self, frame: Frame, terms: Terms, targets: list[Span]) -> list[Model]:
        """Polynomials as models, which read what these terms hold."""
        names, places, rows = self._names(), places_read(terms), rows_of(targets)
        lags = tuple(Lag(names[frame.column[place]], int(frame.steps[place])) for place in places)
        inputs = tuple(Variable(str(lag)) for lag in lags)
        first = self.n_features_in_
        changes = (frame.scale * (frame.signals[rows] - frame.signals[rows - 1]))[:, first:]
        return [
            Model(inputs, output, (network,), dynamics=Dynamics(lags, _widened(change), self.raster))
            for output, network, change in zip(self._outputs(), term_networks(frame, terms), changes.T, strict=True)
        ]

    def _reads(self, choice: Choice) -> list[tuple[int, int]]:
        """Columns and steps that a choice offers."""
        n = self.n_features_in_
        reads = [(i, step) for i in range(n) for step in choice.input_lags]
        return reads + [(n + k, step) for k in range(self.n_outputs_) for step in choice.output_lags]

    @property
    def _dynamics(self) -> Dynamics:
        found = self.models_[0].dynamics
        assert found is not None
        return found


def _but(spans: list[Span], block: list[Span], warm_up: int) -> list[Span]:
    """Rows to learn from: those before a block start its runs, are known then, and stay out with it."""
    return without(spans, [(a - warm_up, b) for a, b in block])


def _check_sizes(signals: np.ndarray, names: Sequence[str]) -> None:
    """Refuse signals whose squares overflow, or lose their digits."""
    for name, values in zip(names, signals.T, strict=True):
        low, high = (float(end(values)) if values.size else 0.0 for end in (np.min, np.max))
        if max(-low, high) > _LARGEST or 0.0 < high - low < _THINNEST:
            raise InputError(
                f"{name} lies in {low:g} to {high:g}: its values must not be beyond {_LARGEST:g}, nor vary by less than "
                f"{_THINNEST:g}; scale it"
            )


def _targets(spans: list[Span], choice: Choice) -> list[Span]:
    targets = answered(spans, choice.longest)
    if not targets:
        raise InputError(f"no {choice.longest + 1} rows follow each other: shorten the lags or fill the gaps")
    return targets


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
