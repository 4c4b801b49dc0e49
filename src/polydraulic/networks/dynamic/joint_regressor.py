"""JointRegressor: joints that integrate a rate, which their commands open through dead time, lag and dead zone."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.blas_threads import one_blas_thread
from polydraulic.networks.dynamic.command_response import Response, away_from_stops, find_response, most_looked_back
from polydraulic.networks.dynamic.free_runner import FreeRunner
from polydraulic.networks.dynamic.joint_network import joint_network
from polydraulic.networks.dynamic.joint_rate import Factors, learn_rate
from polydraulic.networks.dynamic.lag_selection import Choice
from polydraulic.networks.dynamic.lagged_terms import Frame, frame_of
from polydraulic.networks.dynamic.spans import Span, answered, blocks_of, rows_of, spans_of
from polydraulic.networks.model.lags import Dynamics, Lag
from polydraulic.networks.model.model import Model, Variable
from polydraulic.progress import Progress, quiet

_BEYOND = 0.02  # of its range, by which a joint may leave what was seen where it met no stop: few logs end far from the end of a travel
_ENDLESS = 1e4  # of its range, by which a joint that turns without end may: models state finite ranges
_MARGIN = 0.1  # of their range, by which changes from row to row may
_NAMED = 3  # runs of rows in a sentence


class JointRegressor(FreeRunner):
    """Angles or strokes of joints from their commands, for machines whose hydraulics nobody describes.

    From row to row each joint moves by a rate: the openings of its valve to either side, alone, times its own angle, and times what the other
    valves are opened in all (a shared pump). Each opening squared, angles of other joints and further inputs have to earn their place on blocks
    held out. Every term holds an opening of its own valve, so that a joint whose command is within its dead zone stands still. See
    `polydraulic.networks.dynamic.joint_rate`.

    Parameters
    ----------
    longest_lag : int, default=16
        Rows after which the response of a rate to its command must be over.
    horizon : int, default=200
        Rows of the free runs by which is chosen.
    max_terms : int, default=16
        Of what each joint's openings are multiplied by, beside its angle and the other openings.
    n_blocks : int, default=4
        Blocks of rows that follow each other in time, each held out once to choose.
    continuous : sequence of int, default=()
        Joints, by their columns of `y`, that turn without end: they have no stops, and no rate depends on their angle.
    raster : float, optional
        Time between rows in s; it goes into the model file.
    progress : Progress, optional
        Told of each joint.
    signal_names : sequence of str, optional
        Of inputs and joints, as messages call them.

    Attributes
    ----------
    models_ : list of Model
        One per joint; inputs are named ``x0[t-1]``.
    responses_ : list of Response
        Play, dead time, lag and dead zone of each joint's command.
    choice_ : Choice
        What was chosen: its horizon is that of the windows that rates are fitted to, its error the mean size of errors rather than their rms.
    warm_up_ : int
        Rows that must be measured before the first answer.
    doubts_ : list of str
        Where gaps lie so close to each other that play was not looked for, or rows between them were left out; rows count from 1.

    Notes
    -----
    A model knows how much the strength of its joint, a factor of its rate each way, differs among logs, or blocks of time where there is one: a run
    that begins after measured rows goes by how strong these show the joint to be (`horizon` of `simulate`). At the start of a segment it is as in the mean. See
    `polydraulic.networks.dynamic.joint_strength`.

    A run cannot grow without bound: a joint stays in its range in training, widened by a fiftieth at each end but where it was driven
    against a stop, and changes from row to row stay in theirs, widened by a tenth. Joints that turn without end may go on for ten thousand
    times their range.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> u, y = np.repeat(rng.uniform(-1, 1, size=100), 10), np.zeros(1000)
    >>> for t in range(2, 1000):
    ...     y[t] = y[t - 1] + 0.02 * (max(u[t - 2] - 0.3, 0.0) + min(u[t - 2] + 0.2, 0.0)) - 0.002 * (y[t - 1] > 1.0)
    >>> model = JointRegressor(horizon=100, longest_lag=8).fit(u[:, None], y)
    >>> [round(edge, 1) for edge, _ in model.responses_[0].edges]
    [0.3, -0.2]
    """

    _output = "joint"

    def __init__(
        self, *, longest_lag: int = 16, horizon: int = 200, max_terms: int = 16, n_blocks: int = 4, continuous: Sequence[int] = (),
        raster: float | None = None, progress: Progress = quiet, signal_names: Sequence[str] | None = None,
    ) -> None:  # fmt: skip
        self.longest_lag = longest_lag
        self.horizon = horizon
        self.max_terms = max_terms
        self.n_blocks = n_blocks
        self.continuous = continuous
        self.raster = raster
        self.progress = progress
        self.signal_names = signal_names

    def fit(self, X: Any, y: Any, segments: Any = None, logs: Any = None) -> "JointRegressor":
        """Find how joints respond, and learn their rates.

        Parameters
        ----------
        X : (n_row, n_input) array-like
            Rows in time order at a constant raster: first the command of each joint, in their order, then what else rates may depend on. A
            row with NaN in `X` or `y` is a gap: nothing is learnt across it.
        y : (n_row,) or (n_row, n_joint) array-like
            Angles or strokes.
        segments : (n_row,) array-like, optional
            Labels; rows of different labels do not follow each other.
        logs : (n_row,) array-like, optional
            Labels of logs, which may be of different days; rows of different ones do not follow each other either. One log if not given.

        Raises
        ------
        ValueError
            Fewer inputs than joints, infinite values, settings out of range, too few rows that follow each other, a command that does
            not move its joint.
        """
        for name, least in (("longest_lag", 2), ("horizon", 2), ("max_terms", 1), ("n_blocks", 2)):
            self._whole(name, least)
        X, y = self._checked(X, y, reset=True)
        self._single_output = y.ndim == 1
        signals = np.column_stack([X, y])
        self.n_outputs_ = signals.shape[1] - self.n_features_in_
        if self.n_features_in_ < self.n_outputs_:
            raise InputError(
                f"{self.n_features_in_} inputs for {self.n_outputs_} joints: give the command of each joint first, in the order of the joints"
            )
        strange = [k for k in self.continuous if k not in range(self.n_outputs_)]
        if strange:
            raise InputError(
                f"continuous = {list(self.continuous)}: joints are numbered 0 to {self.n_outputs_ - 1}, {strange} are none"
            )
        known = np.isfinite(signals).all(axis=1)
        logs = None if logs is None else np.asarray(logs)
        if logs is not None and logs.shape != (len(X),):
            raise InputError(f"logs has shape {logs.shape}; it must hold one label for each of the {len(X)} rows")
        spans = spans_of(segments, known)
        if logs is not None:
            spans = [
                (max(a, c), min(b, d)) for a, b in spans for c, d in spans_of(logs, known) if max(a, c) < min(b, d)
            ]
        n, names = self.n_outputs_, self._names()
        said = names if self.signal_names is None else list(self.signal_names)
        if len(said) != len(names):
            raise InputError(f"{len(said)} signal_names for {len(names)} inputs and joints: name each of them, or none")
        self.doubts_ = self._no_play(spans)
        with_play = not self.doubts_
        self.responses_ = []
        for k in range(n):
            self.progress(f"dead zone of {said[k]}", k, 2 * n)
            of, joint = (said[k], said[self.n_features_in_ + k]), signals[:, self.n_features_in_ + k]
            endless = k in self.continuous
            self.responses_.append(
                find_response(
                    signals[:, k],
                    joint,
                    spans,
                    self.longest_lag,
                    of,
                    self.raster,
                    continuous=endless,
                    with_play=with_play,
                )
            )
        looked_back = max(self.longest_lag, *(response.reads[-1] for response in self.responses_))
        targets = answered(spans, looked_back)
        self.doubts_ += self._too_short(spans, looked_back)
        found = []
        for k in range(n):
            self.progress(f"rate of {said[self.n_features_in_ + k]}", n + k, 2 * n)
            with one_blas_thread():
                found.append(self._learn(k, signals, spans, targets, logs))
        self.models_ = [model for model, _, _ in found]
        self.warm_up_ = max(model.dynamics.warm_up for model in self.models_ if model.dynamics)
        read = {
            (lag.signal in names[self.n_features_in_ :], lag.steps)
            for m in self.models_
            if m.dynamics
            for lag in m.dynamics.lags
        }
        lags = tuple(sorted(steps for own, steps in read if not own))
        error = float(np.mean([error for _, _, error in found]))
        self.choice_ = Choice(lags, (1,), True, self.longest_lag, sum(terms for _, terms, _ in found), error)
        return self

    def _remedy(self) -> str:
        return f"shorten the longest lag of {self.longest_lag} rows, or fill the gaps"

    def _no_play(self, spans: Sequence[Span]) -> list[str]:
        """Sentence on too few rows to choose terms by, were they read as far back as play asks for."""
        before = most_looked_back(self.longest_lag)
        rows, least = sum(b - a for a, b in answered(spans, before)), self.n_blocks * (self.longest_lag + 1)
        if rows >= least:
            return []
        return [
            f"play was not looked for: that takes {least} rows after {before} others without a gap between them, and the log has {rows}: "
            f"{self._remedy()}"
        ]

    def _too_short(self, spans: Sequence[Span], looked_back: int) -> list[str]:
        """Sentence on rows between gaps that are too few to be learnt from."""
        short = [f"{a + 1} to {b}" for a, b in spans if b - a <= looked_back]
        if not short:
            return []
        more = f" and {len(short) - _NAMED} more" if len(short) > _NAMED else ""
        return [
            f"{len(short)} of {len(spans)} runs of rows without a gap were left out, as they have no more than the {looked_back} rows that are read "
            f"before the first one that is learnt from: rows {', '.join(short[:_NAMED])}{more}; {self._remedy()}"
        ]

    def _learn(
        self, k: int, signals: np.ndarray, spans: list[Span], targets: list[Span], logs: np.ndarray | None
    ) -> tuple[Model, int, float]:
        """Model of joint `k`, its number of terms, and their error on blocks held out."""
        first, response = self.n_features_in_, self.responses_[k]
        short = [sum(b - a for a, b in block) for block in blocks_of(targets, self.n_blocks)]
        if min(short) <= self.longest_lag:
            raise InputError(
                f"{sum(short)} rows are too few to choose from: each of the n_blocks = {self.n_blocks} blocks needs more "
                f"than the longest lag, {self.longest_lag}; shorten it, or record more rows"
            )
        ramps = [(j, one, side) for j, one in enumerate(self.responses_) for side in range(len(one.edges))]
        ramps.sort(key=lambda ramp: ramp[0] != k)  # its own first
        others = [self.responses_[j].ramps(signals[:, j], spans).sum(axis=1) for j in range(self.n_outputs_) if j != k]
        opened = np.column_stack([response.ramps(signals[:, k], spans), *([np.sum(others, axis=0)] if others else [])])
        seen = [first + j for j in range(self.n_outputs_) if j != k and j not in self.continuous]
        columns = [*range(self.n_outputs_, first), *seen, first + k]
        inner = np.column_stack([opened, signals[:, columns]])
        frame = self._frame(inner, opened.shape[1], response, targets)
        n_own, last = len(response.edges), inner.shape[1] - 1
        known = (*range(n_own, opened.shape[1]), *(() if k in self.continuous else (last,)))
        factors = Factors(tuple(range(n_own)), known, (*range(n_own), *range(opened.shape[1], last)))
        away = away_from_stops(signals[:, first + k], spans, response.stops)
        terms, error, strength = learn_rate(
            frame, factors, targets, away, self.longest_lag, self.horizon, self.n_blocks, self.max_terms, logs
        )
        network, reads = joint_network(frame, terms, ramps, n_own, signals, columns, targets)
        names = self._names()
        lags = tuple(Lag(names[column], steps) for column, steps in reads)
        rows = rows_of(targets)
        change = signals[rows, first + k] - signals[rows - 1, first + k]
        ends = float(change.min()), float(change.max())
        wider = _MARGIN * (ends[1] - ends[0])
        strength = strength and replace(strength, noise=strength.noise * float(frame.scale[-1]))
        dynamics = Dynamics(lags, (ends[0] - wider, ends[1] + wider), self.raster, strength)
        inputs = tuple(Variable(str(lag)) for lag in lags)
        return Model(inputs, Variable(names[first + k]), (network,), dynamics=dynamics), len(terms.coef), error

    def _frame(self, inner: np.ndarray, n_ramp: int, response: Response, targets: list[Span]) -> Frame:
        """Ramps as they are now, all else one row ago; the joint goes as far as its stop, or a little beyond what was seen."""
        reads = [(column, int(column >= n_ramp)) for column in range(inner.shape[1])]
        frame = frame_of(inner, 1, reads, targets, 0.0, n_raw=n_ramp)
        stops = response.stops
        wider = (_ENDLESS if response.continuous else _BEYOND) * (frame.y_high - frame.y_low)
        y_low, y_high = frame.y_low - wider * (not stops[0]), frame.y_high + wider * (not stops[1])
        low, high = frame.low.copy(), frame.high.copy()
        low[-1], high[-1] = y_low[0], y_high[0]
        return frame._replace(y_low=y_low, y_high=y_high, low=low, high=high)
