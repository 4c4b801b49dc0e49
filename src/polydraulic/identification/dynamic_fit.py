"""Fit a log with memory: one dynamic model of all outputs, with the errors of its runs through blocks of time held out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from sklearn.base import BaseEstimator

from polydraulic.display import DEFAULT, as_shown
from polydraulic.errors import InputError
from polydraulic.identification.arguments import check_columns, parts_of, table_of, unused_in_words
from polydraulic.identification.judging import LEVEL, Errors, errors_of, far_from_others, r2_text, unit_after
from polydraulic.identification.log_rows import log_rows
from polydraulic.identification.runs import DynamicRun, last_value_held, side_by_side
from polydraulic.networks.dynamic.command_response import response_facts, response_in_words
from polydraulic.networks.dynamic.dynamic_regressor import DynamicRegressor
from polydraulic.networks.dynamic.free_run import dynamics_of
from polydraulic.networks.dynamic.joint_regressor import JointRegressor
from polydraulic.networks.dynamic.lag_selection import Choice
from polydraulic.networks.dynamic.spans import Span, blocks_of, rows_of, spans_of
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.hold_out import BLOCKS, blocks_of_parts, held_blocks
from polydraulic.networks.intervals import half_width
from polydraulic.networks.model.lag_words import lags_in_words, rows_in_words, strength_in_words
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.nodes import LINEAR as LINEAR_NODE
from polydraulic.networks.model.shown_model import shown_model
from polydraulic.networks.model.table import Network, Node
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

LAST, LINEAR = "last value held", "linear, same lags"  # models for scale
_SMALLEST = 20  # rows that a block must hold beside the longest lag
_FEWER = 0.1  # by which the share of rows in their intervals may fall below the level without a word
_ONLY_READ = 0.1  # share of the rows that models do not answer, above which it is worth a word
_FEW_BLOCKS = 10  # of a short log, two of them held out


class RunErrors(NamedTuple):
    """Errors of free runs, and of answers one step ahead."""

    free_run: Errors
    one_step: Errors


class DynamicOutputFit(NamedTuple):
    """Model of one output, of all rows, and how one without the blocks held out runs through these; in the output's unit.

    Attributes
    ----------
    model : Model
        Its `training` states all of the following.
    errors : RunErrors
    others : dict from name to RunErrors
        What simpler models reach there, for scale.
    half_width : float
        Of the interval around a free run at `LEVEL`, from half of the blocks; infinite if the rows are too few.
    covered : float
        Share of the rows of the other half that lies in it.
    held : DynamicRun
    """

    model: Model
    errors: RunErrors
    others: dict[str, RunErrors]
    half_width: float
    covered: float
    held: DynamicRun

    def shown(self, units: str = DEFAULT) -> "DynamicOutputFit":
        """The fit with model, errors and runs as they are shown: to be read."""
        unit = self.model.output.unit
        return self._replace(
            model=shown_model(self.model, units),
            errors=RunErrors(*(kind.shown(unit, units) for kind in self.errors)),
            others={name: RunErrors(*(kind.shown(unit, units) for kind in of)) for name, of in self.others.items()},
            half_width=as_shown(self.half_width, unit, units),
            held=self.held.shown(unit, units),
        )

    def text(self, units: str = DEFAULT) -> str:
        """How good the model is, in lines."""
        read = self.shown(units)
        return "\n  ".join([str(read.model.output), *statements(read)])

    def __str__(self) -> str:
        return self.text()


@dataclass(frozen=True, eq=False)
class DynamicFit:
    """Dynamic models of a log; ``str()`` says how good they are.

    Attributes
    ----------
    outputs : list of DynamicOutputFit
        One per output.
    table : Table
        What the models were fitted to.
    source : str
        Where it came from.
    doubts : list of str
        What makes the models doubtful, in sentences: rows that are not used, or only read; values far from all others; of joints, gaps that
        left no room to learn.
    """

    outputs: list[DynamicOutputFit]
    table: Table = field(repr=False)
    source: str
    doubts: list[str] = field(default_factory=list)

    @property
    def models(self) -> list[Model]:
        """The models, which may read each other's outputs."""
        return [found.model for found in self.outputs]

    def text(self, units: str = DEFAULT) -> str:
        """How good the models are, in lines."""
        return "\n".join(
            [*(found.text(units) for found in self.outputs), *(f"warning: {said}" for said in self.doubts)]
        )

    def __str__(self) -> str:
        return self.text()


def fit_dynamic(
    table: Table | str | Path | Sequence[Table | str | Path],
    inputs: Sequence[str],
    outputs: Sequence[str],
    *,
    estimator: AbductiveRegressor | None = None,
    longest_lag: int = 8,
    progress: Progress = quiet,
) -> DynamicFit:
    """Fit all outputs together; they may read each other's past.

    Every fifth block of time is held out while lags and complexity are chosen and the errors are measured; then the same is done
    with all rows, which may lead to another choice.

    Parameters
    ----------
    table : Table, str, Path or sequence of them
        Or its file: a log with a column ``time``, and ``segment`` where it has gaps; see `log_rows`. Of several tables, or a pattern such
        as ``day*.parquet``, no lag and no block crosses the end of one.
    inputs, outputs : sequence of str
    estimator : AbductiveRegressor, optional
        Of every network; chosen by free runs if not given.
    longest_lag : int
        In rows.
    progress : Progress, optional
        Called with each choice that is tried.

    Returns
    -------
    DynamicFit

    Raises
    ------
    InputError
        As `fit_table`; no raster in the times, or too few rows that follow each other.
    """

    def learner(raster: float, tell: Progress) -> DynamicRegressor:
        def choices(choice: str, tried: int, most: int) -> None:
            tell(f"choice {tried}, {choice}", tried, most)

        return DynamicRegressor(estimator, longest_lag=longest_lag, raster=raster, progress=choices)

    log = table_of(table, [*inputs, *outputs], ["time", "segment"])
    return fit_log(log, inputs, outputs, learner, lambda raster: longest_lag, progress)


def fit_log(
    log: tuple[Table, str], inputs: Sequence[str], outputs: Sequence[str],
    learner: Callable[[float, Progress], Any], lag: Callable[[float], int], progress: Progress,
) -> DynamicFit:  # fmt: skip
    """Learn without the blocks held out, judge by these, learn from all rows; the learner and the rows it looks back go by the raster.

    Parameters
    ----------
    log : (Table, str)
        The rows, and where they come from.
    inputs, outputs : sequence of str
    learner : function of the raster in s and of a progress
    lag : function of the raster in s
        Rows that a model may read before its first answer.
    progress : Progress
    """
    table, source = log
    check_columns(table, inputs, outputs)
    rows = log_rows(table)
    raster = rows.raster or 0.0  # never None where the table has times
    spans = spans_of(rows.segments, np.ones(len(table), dtype=bool))
    parts = parts_of(table)
    logs = np.repeat(np.arange(len(parts)), parts)
    held = _held_out(spans, lag(raster), parts)
    X, y = table.matrix(inputs), table.matrix(outputs)
    without = y.copy()
    without[rows_of(held)] = np.nan  # a gap, across which nothing is learnt
    names = [Variable(name, table.unit(name)) for name in inputs], [Variable(o, table.unit(o)) for o in outputs]

    def search(targets: np.ndarray, what: str, done: int) -> Any:
        progress(what, done, 2)

        def tell(step: str, _: int, __: int) -> None:
            progress(f"{what}: {step}", done, 2)

        of = learner(raster, tell)
        return of.fit(X, targets, rows.segments, **({"logs": logs} if isinstance(of, JointRegressor) else {}))

    judged = search(without, "hold out", 0)
    lags = judged.choice_.input_lags, judged.choice_.output_lags
    linear = DynamicRegressor(_Linear(), input_lags=lags[0], output_lags=lags[1], increments=False, horizon=None)
    linear.fit(X, without, rows.segments)
    # terms that were chosen need not read the longest of the lags on offer, a linear model reads them all
    found, plain = side_by_side([judged.to_models(*names), linear.to_models(*names)], table, held)
    final = search(y, "all rows", 1)
    progress("all rows", 2, 2)
    fits = []
    choices = {"choice": _choice(final.choice_), "choice_held_out": _choice(judged.choice_)}
    for k, model in enumerate(final.to_models(*names)):
        model.training.update({"rows": len(table), "held_out": "blocks of time", **choices})
        if isinstance(final, JointRegressor):
            model.training["response"] = response_facts(final.responses_[k], inputs[k], table.unit(inputs[k]), raster)
        fits.append(_judged(model, found[k], plain[k], table[model.output.name]))
    models = [fit.model for fit in fits]
    doubts = [unused_in_words(table), _only_read(spans, models), *far_from_others(table, models).values()]
    if isinstance(final, JointRegressor):
        doubts += final.doubts_
    return DynamicFit(fits, table, source, [doubt for doubt in doubts if doubt])


def _only_read(spans: Sequence[Span], models: Sequence[Model]) -> str:
    """Sentence on rows that begin a piece, or are one that is too short, where these are many; empty otherwise."""
    first = max(dynamics_of(model).warm_up for model in models)
    count, only = sum(b - a for a, b in spans), sum(min(b - a, first) for a, b in spans)
    if only <= _ONLY_READ * count:
        return ""
    return f"{only} of {count} rows are read and teach nothing: the first {first} of each of {len(spans)} pieces without a gap, or all of shorter ones"


def statements(fit: DynamicOutputFit) -> list[str]:
    """What was found, in words."""
    unit, scale = unit_after(fit.model.output), fit.others.items()
    runs, *others = remarks(fit)
    return [
        *(
            f"{name}: {r2_text(kind.r2)}, rms {kind.rms:.4g}{unit}, largest {kind.largest:.4g}{unit}"
            for name, kind in ((runs, fit.errors.free_run), ("one step ahead", fit.errors.one_step))
        ),
        f"rms for scale, free run / one step: {'; '.join(f'{n} {o.free_run.rms:.4g} / {o.one_step.rms:.4g}' for n, o in scale)}",
        *others,
    ]


def remarks(fit: DynamicOutputFit) -> list[str]:
    """The same without errors, for those who show them in a table: how long the runs were, and what to think of them."""
    model, (free, one) = fit.model, fit.errors
    raster = model.dynamics.raster if model.dynamics else None
    seconds = "" if raster is None else f" ({fit.held.longest * raster:.3g} s)"
    runs = f"{fit.held.n_run} free runs" if fit.held.n_run > 1 else "a free run"
    found = [f"{runs} of up to {fit.held.longest} rows{seconds} that were held out"]
    response: Any = model.training.get("response")
    found += [response_in_words(response)] if response else []
    found += [strength_in_words(model.dynamics)] if model.dynamics and model.dynamics.strength else []
    if np.isfinite(fit.half_width):
        few = ": the blocks differ too much to rely on them" if fit.covered < LEVEL - _FEWER else ""
        found.append(
            f"{LEVEL:.0%} intervals of such a run, plus or minus {fit.half_width:.4g}{unit_after(model.output)}, hold for "
            f"{fit.covered:.0%} of the rows that they were not set by{few}"
        )
    last = fit.others[LAST]
    if free.r2 <= 0.0 or last.free_run.rms <= free.rms:
        better = "mean" if last.free_run.r2 <= 0.0 else "last value held"
        found.append(f"over such runs the {better} would err less: do not simulate with it")
    if fit.others[LINEAR].free_run.rms < free.rms:
        found.append("a linear model of the same lags runs better on the blocks held out")
    if last.one_step.rms < one.rms:
        found.append("one step ahead the last value says more: it was made to run")
    chosen: Any = model.training["choice"]
    judged: Any = model.training["choice_held_out"]
    if chosen != judged:
        lags = (
            f"lags of inputs {rows_in_words(judged['input_lags'])}, of outputs {rows_in_words(judged['output_lags'])}"
        )
        found.append(
            f"these errors are of the choice without the rows held out: {lags}, {_how(judged)}; all rows led to another"
        )
    return [*found, f"reads {lags_in_words(dynamics_of(model))}; {model.n_coefficients} coefficients, {_how(chosen)}"]


def _held_out(spans: Sequence[Span], longest_lag: int, parts: Sequence[int]) -> list[Span]:
    """Rows of every fifth block of time; no block goes beyond its part, a number of rows."""
    n, least = sum(b - a for a, b in spans), longest_lag + _SMALLEST
    if n < _FEW_BLOCKS * least:
        raise InputError(
            f"the log has {n} rows; to hold blocks of time out it takes {_FEW_BLOCKS * least} with a longest lag of "
            f"{longest_lag} rows: shorten the lag, or record more"
        )
    counts = blocks_of_parts(BLOCKS if n >= BLOCKS * least else _FEW_BLOCKS, parts)
    blocks: list[list[Span]] = []
    for (low, high), count in zip(pairwise(np.cumsum([0, *parts]).tolist()), counts, strict=True):
        blocks += blocks_of([(a, b) for a, b in spans if low <= a < high], count)
    return [span for block in held_blocks(blocks) for span in block]


def _choice(choice: Choice) -> dict[str, Any]:
    """What was chosen, as it stands in a model file."""
    found = choice._asdict()
    del found["error"]
    return {name: list(value) if isinstance(value, tuple) else value for name, value in found.items()}


def _how(choice: Mapping[str, Any]) -> str:
    """How a choice learns, in words."""
    rows, terms = choice["horizon"], choice["terms"]
    parts = [] if terms is None else [f"polynomials of {terms} terms in all"]
    parts += ["of increments"] if choice["increments"] else []
    return ", ".join([*parts, f"fitted to runs of {rows} rows" if rows else "fitted one step ahead"])


def _judged(model: Model, run: DynamicRun, plain: DynamicRun, measured: np.ndarray) -> DynamicOutputFit:
    """Errors and intervals, written into the model's training, too."""
    last = last_value_held(run, measured)
    errors = RunErrors(errors_of(run.measured, run.free), errors_of(run.measured, run.one_step))
    others = {
        LAST: RunErrors(errors_of(run.measured, last[0]), errors_of(run.measured, last[1])),
        LINEAR: RunErrors(errors_of(run.measured, plain.free), errors_of(run.measured, plain.one_step)),
    }
    sizes = np.abs(run.free - run.measured)
    sets = run.number % 2 == 0  # whole runs set the width, the others say whether it holds
    width = half_width(sizes[sets], LEVEL) if not sets.all() else inf
    covered = float(np.mean(sizes[~sets] <= width)) if not sets.all() else 0.0
    model.training.update(
        {
            "free_runs": run.n_run,
            "free_run_rows": run.longest,
            **_numbers(errors),
            "for_scale": {name: _numbers(other) for name, other in others.items()},
            "interval_level": LEVEL,
            "interval_half_widths": [width] if np.isfinite(width) else [],
            "interval_covered": covered,
        }
    )
    return DynamicOutputFit(model, errors, others, width, covered, run)


def _numbers(errors: RunErrors) -> dict[str, float]:
    """Errors under their names in a model file: free_run_rms and so on."""
    return {
        f"{kind}_{name}": value for kind in errors._fields for name, value in getattr(errors, kind)._asdict().items()
    }


class _Linear(BaseEstimator):
    """Least squares within the guards of other models, for scale."""

    def fit(self, X: np.ndarray, y: np.ndarray) -> "_Linear":
        mean, scale, margin = X.mean(axis=0), X.std(axis=0), 0.1 * float(np.ptp(y))
        scale = np.where(scale > 0.0, scale, 1.0)
        coef = np.linalg.lstsq((X - mean) / scale, y - y.mean(), rcond=1e-10)[0]
        node = Node(LINEAR_NODE, tuple(range(len(mean))), tuple(coef.tolist()))
        x_mean, x_scale, x_low, x_high = (tuple(end.tolist()) for end in (mean, scale, X.min(axis=0), X.max(axis=0)))
        bounds = float(y.min()) - margin, float(y.max()) + margin
        self.network_ = Network((node,), x_mean, x_scale, x_low, x_high, float(y.mean()), 1.0, *bounds)
        return self

    def to_model(self, inputs: Sequence[Variable], output: Variable) -> Model:
        return Model(tuple(inputs), output, (self.network_,))
