"""Dynamic models on their own: each answer is read by the later ones (free run), or all is measured (one step ahead).

One compiled loop serves both, and anything between: a window begins from measured rows and goes on by itself to its end. Where models of joints
say how their strength differs, measured rows before a window say how strong they are; nothing before it means a strength of 1.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.errors import InputError
from polydraulic.networks.dynamic.joint_strength import StrengthNumbers, strength_numbers
from polydraulic.networks.dynamic.rows import STATES, OutputLimits, answer, begin_strength, see_row, strength_of
from polydraulic.networks.dynamic.spans import Span, answered, spans_of
from polydraulic.networks.model.lags import Dynamics
from polydraulic.networks.model.model import Model, pack_models
from polydraulic.networks.model.partition import Regions, choose
from polydraulic.networks.model.table import NetworkTable, evaluate, work_size


class Loop(NamedTuple):
    """Models of several outputs as plain arrays; signals are columns, inputs first, then the outputs in order."""

    table: NetworkTable
    root: np.ndarray  # (n_output,) int64: way to the output's networks in the joined partitions
    depth: int
    axis: np.ndarray  # (n_split,) and so on, as `Regions`
    at: np.ndarray
    below: np.ndarray
    above: np.ndarray
    n_lag: np.ndarray  # (n_output,) int64
    column: np.ndarray  # (n_output, width) int64: which signal each input of the model is
    steps: np.ndarray  # (n_output, width) int64: and how long ago
    limits: np.ndarray  # (n_output, 4) `OutputLimits`
    numbers: np.ndarray  # (n_output, 5) `StrengthNumbers`


def dynamics_of(model: Model) -> Dynamics:
    """Return what makes a model dynamic, or say that it is not."""
    if model.dynamics is None:
        raise InputError(
            f"the model of {model.output.name!r} is static: it has no lags; fit a DynamicRegressor, or polydraulic fit --dynamic"
        )
    return model.dynamics


def limits_of(model: Model) -> OutputLimits:
    """How far a dynamic model's output may go, and in one row."""
    down, up = dynamics_of(model).step
    return OutputLimits(down, up, min(n.y_low for n in model.networks), max(n.y_high for n in model.networks))


@kernel
def _limits(loop: Loop, k: int) -> OutputLimits:
    return OutputLimits(loop.limits[k, 0], loop.limits[k, 1], loop.limits[k, 2], loop.limits[k, 3])


@kernel
def _numbers(loop: Loop, k: int) -> StrengthNumbers:
    n = loop.numbers
    return StrengthNumbers(n[k, 0], n[k, 1], n[k, 2], n[k, 3], n[k, 4])


def prepare_loop(models: Sequence[Model], signals: Sequence[str]) -> Loop:
    """Put models of the last of `signals`, in their order, into one loop."""
    regions, table = pack_models(models)
    firsts = np.cumsum([0, *(len(part.axis) for part in regions)])

    def moved(ways: Any, first: int) -> np.ndarray:
        ways = np.asarray(ways)
        return np.where(ways >= 0, ways + first, ways).astype(np.int64)

    dynamics, outputs = [dynamics_of(model) for model in models], {model.output.name for model in models}
    for lag in (lag for one in dynamics for lag in one.lags):
        if lag.signal in outputs and lag.steps < 1:
            raise InputError(f"the models read {lag}, which is being predicted: read it at least one step ago")
    n_lag = np.array([len(one.lags) for one in dynamics], dtype=np.int64)
    column = np.zeros((len(models), int(n_lag.max())), dtype=np.int64)
    steps = np.zeros_like(column)
    for k, one in enumerate(dynamics):
        column[k, : n_lag[k]] = [signals.index(lag.signal) for lag in one.lags]
        steps[k, : n_lag[k]] = [lag.steps for lag in one.lags]
    return Loop(
        table=table,
        root=np.array([moved(r.root, f) for r, f in zip(regions, firsts, strict=False)], dtype=np.int64),
        depth=max(part.depth for part in regions),
        axis=np.concatenate([part.axis for part in regions]),
        at=np.concatenate([part.at for part in regions]),
        below=np.concatenate([moved(r.below, f) for r, f in zip(regions, firsts, strict=False)]),
        above=np.concatenate([moved(r.above, f) for r, f in zip(regions, firsts, strict=False)]),
        n_lag=n_lag,
        column=column,
        steps=steps,
        limits=np.array([limits_of(model) for model in models]),
        numbers=np.array([strength_numbers(one.strength) for one in dynamics]),
    )


@driver
def _follow(
    loop: Loop, signals: np.ndarray, since: np.ndarray, start: np.ndarray, found: np.ndarray, states: np.ndarray, work: np.ndarray
) -> None:  # fmt: skip
    """Strengths `found` (n_window, n_output, 2), upwards and downwards, at the start of windows from rows measured `since`.

    `states` (n_output, STATES) is what `see_row` keeps of a joint.
    """
    n_output = found.shape[1]
    first, t = signals.shape[1] - n_output, -1
    for w in range(start.shape[0]):
        if w == 0 or since[w] != since[w - 1] or start[w] < t:
            t = since[w]
            for k in range(n_output):
                begin_strength(states[k], _numbers(loop, k))
        while t < start[w]:
            for k in range(n_output):
                if loop.numbers[k, 4] == 0.0:
                    continue
                for i in range(loop.n_lag[k]):
                    work[i] = signals[t - loop.steps[k, i], loop.column[k, i]]
                regions = Regions(loop.root[k], loop.depth, loop.axis, loop.at, loop.below, loop.above)
                y = evaluate(loop.table, choose(regions, work), work)
                last, measured = signals[t - 1, first + k], signals[t, first + k]
                see_row(states[k], _limits(loop, k), _numbers(loop, k), y, last, measured)
            t += 1
        for k in range(n_output):
            found[w, k, 0] = strength_of(states[k, 0], states[k, 1])
            found[w, k, 1] = strength_of(states[k, 0], -states[k, 1])


@driver
def _run(
    loop: Loop, signals: np.ndarray, start: np.ndarray, stop: np.ndarray, strength: np.ndarray, found: np.ndarray, work: np.ndarray
) -> None:  # fmt: skip
    """Answers `found` (n_row, n_output) in windows; before its start a window reads what was measured."""
    n_output = found.shape[1]
    first = signals.shape[1] - n_output
    for w in range(start.shape[0]):
        for t in range(start[w], stop[w]):
            for k in range(n_output):
                for i in range(loop.n_lag[k]):
                    row = t - loop.steps[k, i]
                    c = loop.column[k, i]
                    work[i] = found[row, c - first] if c >= first and row >= start[w] else signals[row, c]
                regions = Regions(loop.root[k], loop.depth, loop.axis, loop.at, loop.below, loop.above)
                y = evaluate(loop.table, choose(regions, work), work)
                last = found[t - 1, k] if t > start[w] else signals[t - 1, first + k]
                found[t, k] = answer(_limits(loop, k), strength[w, k, 0], strength[w, k, 1], y, last)


def strengths_before(
    loop: Loop, signals: np.ndarray, windows: Sequence[Span], since: Sequence[int] | None
) -> np.ndarray:
    """How strong joints are at the start of windows.

    Parameters
    ----------
    loop, signals, windows, since
        As for `run_windows`.

    Returns
    -------
    (n_window, n_output, 2) array
        Factors of their rates, upwards and downwards.
    """
    ends = np.array(windows, dtype=np.int64).reshape(-1, 2)
    found = np.ones((len(ends), len(loop.root), 2))
    if since is not None and loop.numbers[:, 4].any():
        states, work = np.zeros((len(loop.root), STATES)), np.zeros(work_size(loop.table))
        _follow(loop, signals, np.array(since, dtype=np.int64), ends[:, 0].copy(), found, states, work)
    return found


def run_windows(
    loop: Loop, signals: np.ndarray, windows: Sequence[Span], since: Sequence[int] | None = None
) -> np.ndarray:
    """Answers in windows of rows, which begin from measured outputs and go on by themselves.

    Parameters
    ----------
    loop : Loop
    signals : (n_row, n_signal) array
        Inputs, then measured outputs; an output is read only before the start of a window.
    windows : sequence of (start, stop)
        As many rows as the longest lag stand before each start.
    since : sequence of int, optional
        For each window a row from which on all is measured until it starts, with as many rows as the longest lag before it: they show how
        strong joints are. Without it, all are as strong as in the mean.

    Returns
    -------
    (n_row, n_output) array
        The measured outputs outside the windows.
    """
    return run_as_strong(loop, signals, windows, strengths_before(loop, signals, windows, since))


def run_as_strong(loop: Loop, signals: np.ndarray, windows: Sequence[Span], strength: np.ndarray) -> np.ndarray:
    """The same with strengths that are given, (n_window, n_output, 2) factors of rates, upwards and downwards."""
    found = signals[:, signals.shape[1] - len(loop.root) :].copy()
    ends = np.array(windows, dtype=np.int64).reshape(-1, 2)
    _run(loop, signals, ends[:, 0].copy(), ends[:, 1].copy(), strength, found, np.zeros(work_size(loop.table)))
    return found


def pieces(spans: Sequence[Span], horizon: int) -> list[Span]:
    """Cut spans into windows of at most `horizon` rows."""
    return [(at, min(at + horizon, b)) for a, b in spans for at in range(a, b, horizon)]


def free_run(
    models: Sequence[Model], signals: Mapping[str, Any], *, segments: Any = None, horizon: int | None = None
) -> dict[str, np.ndarray]:
    """Simulate dynamic models, such as a model file holds.

    Parameters
    ----------
    models : sequence of Model
        One for each output that they read of each other.
    signals : mapping from name to (n_row,) array-like
        Inputs, and outputs of which only the first rows of each segment are read, as many as the longest lag.
    segments : (n_row,) array-like, optional
        Labels; a new one begins a new run.
    horizon : int, optional
        Restart from measured outputs after this many rows: 1 predicts one step ahead. All outputs are read then, and those before a restart
        show how strong joints are.

    Returns
    -------
    dict from output to (n_row,) array
        The given rows at the start of each segment, then the models' answers.

    Raises
    ------
    InputError
        A static model, a signal that is missing or not finite where it is read, a segment that is too short.
    """
    outputs = [model.output.name for model in models]
    read = {lag.signal for model in models for lag in dynamics_of(model).lags}
    names = [*sorted(read - set(outputs)), *outputs]
    missing = [name for name in names if name not in signals]
    if missing:
        raise InputError(f"signals lack {missing}; given are {list(signals)}")
    columns = [np.asarray(signals[name], dtype=np.float64) for name in names]
    if any(column.shape != columns[0].shape or column.ndim != 1 for column in columns):
        raise InputError(f"signals have shapes {[column.shape for column in columns]}; all must be (n_row,)")
    warm_up = max(dynamics_of(model).warm_up for model in models)
    found = simulate_spans(prepare_loop(models, names), np.column_stack(columns), names, warm_up, segments, horizon)
    return dict(zip(outputs, found.T, strict=True))


def simulate_spans(
    loop: Loop, signals: np.ndarray, names: Sequence[str], warm_up: int, segments: Any, horizon: int | None
) -> np.ndarray:
    """Check what is read, and answer in every segment; see `free_run`."""
    if horizon is not None and (not isinstance(horizon, int | np.integer) or horizon < 1):
        raise InputError(f"horizon = {horizon!r}: must be a whole number of rows, at least 1")
    spans = spans_of(segments, np.ones(len(signals), dtype=bool))
    short = [b - a for a, b in spans if b - a <= warm_up]
    if short or not spans:
        raise InputError(
            f"a segment has {min(short, default=0)} rows; a run needs more than {warm_up}, the longest lag"
        )
    windows = answered(spans, warm_up)
    needed, since = np.ones(signals.shape, dtype=bool), [a for a, _ in windows]
    if horizon is None:
        for a, b in windows:
            needed[a:b, signals.shape[1] - len(loop.root) :] = False
    else:
        since = [a for a, b in windows for _ in range(a, b, int(horizon))]
        windows = pieces(windows, int(horizon))
    bad = needed & ~np.isfinite(signals)
    if bad.any():
        row, column = np.argwhere(bad)[0]
        raise InputError(
            f"{names[column]} = {signals[row, column]} in row {row}: must be finite where a run reads it; "
            "leave such rows out and begin a new segment after them"
        )
    return run_windows(loop, signals, windows, since)
