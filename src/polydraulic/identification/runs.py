"""Dynamic models run on a log: what they answer on their own and one step ahead, next to what was measured."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, amount, as_shown
from polydraulic.errors import InputError
from polydraulic.identification.arguments import TIMES, models_of, table_of, unused_in_words
from polydraulic.identification.judging import errors_of, r2_text
from polydraulic.identification.log_rows import rows_for
from polydraulic.networks.dynamic.free_run import dynamics_of, free_run
from polydraulic.networks.dynamic.spans import Span, rows_of, spans_of
from polydraulic.networks.model.model import Model
from polydraulic.tables import Table


class DynamicRun(NamedTuple):
    """Rows that the model of one output answered; arrays of shape (n_row,), in the output's unit.

    Attributes
    ----------
    row : array of int
        Where they stand in the log.
    number : array of int
        Which run a row belongs to; each begins from measured rows and goes on by itself.
    time : array, s
        Number of the row where the log has no times.
    measured, free, one_step : array
        Measured; answered from the model's own predictions; answered from measured values.
    """

    row: np.ndarray
    number: np.ndarray
    time: np.ndarray
    measured: np.ndarray
    free: np.ndarray
    one_step: np.ndarray

    @property
    def longest(self) -> int:
        """Rows of the longest run."""
        return int(np.bincount(self.number).max())

    @property
    def n_run(self) -> int:
        """Number of runs."""
        return int(self.number[-1]) + 1

    def shown(self, unit: str, units: str = DEFAULT) -> "DynamicRun":
        """The run of an output in `unit` as it is shown."""
        measured, free, one_step = (
            as_shown(values, unit, units) for values in (self.measured, self.free, self.one_step)
        )
        return self._replace(measured=measured, free=free, one_step=one_step)


def run_on(
    models: Sequence[Model], table: Table, spans: Sequence[Span], horizon: int | None = None
) -> list[DynamicRun]:
    """Run the models of a file through spans of a log.

    Parameters
    ----------
    models : sequence of Model
        Dynamic ones, one for each output that they read of each other.
    table : Table
        With their signals.
    spans : sequence of (start, stop)
        Rows that follow each other. The first ones of each, as many as the longest lag, are read only; shorter ones are left out.
    horizon : int, optional
        Restart from measured outputs after this many rows.

    Returns
    -------
    list of DynamicRun
        One per output.

    Raises
    ------
    InputError
        A signal that is missing, or no span that is long enough.
    """
    warm_up = _warm_up(models)
    kept = [(a, b) for a, b in spans if b - a > warm_up]
    if not kept:
        longest = max((b - a for a, b in spans), default=0)
        raise InputError(
            f"at most {longest} rows of the table follow each other; a run needs more than {warm_up}, the longest lag"
        )
    rows, length = rows_of(kept), np.array([b - a for a, b in kept])
    labels, place = np.repeat(np.arange(len(kept)), length), np.concatenate([np.arange(n) - warm_up for n in length])
    outputs = [model.output.name for model in models]
    names = _signals(models)
    signals = {name: table[name][rows] for name in names}
    free = free_run(models, signals, segments=labels, horizon=horizon)
    one_step = free_run(models, signals, segments=labels, horizon=1)
    answered = place >= 0
    begins = place[answered] % (horizon or len(rows)) == 0
    row, number = rows[answered], np.cumsum(begins) - 1
    time = table["time"][row] if "time" in table.names else row.astype(np.float64)
    return [
        DynamicRun(row, number, time, signals[name][answered], free[name][answered], one_step[name][answered])
        for name in outputs
    ]


def side_by_side(several: Sequence[Sequence[Model]], table: Table, spans: Sequence[Span]) -> list[list[DynamicRun]]:
    """`run_on` for several sets of models, of which all answer the same rows: those that the longest lag of any leaves."""
    longest = max(map(_warm_up, several))
    return [run_on(models, table, [(a + longest - _warm_up(models), b) for a, b in spans]) for models in several]


def _signals(models: Sequence[Model]) -> list[str]:
    """Columns that models read, and what they answer; of static ones only this."""
    read = [lag.signal for model in models if model.dynamics for lag in model.dynamics.lags]
    return list(dict.fromkeys([*read, *(model.output.name for model in models)]))


def _warm_up(models: Sequence[Model]) -> int:
    return max(dynamics_of(model).warm_up for model in models)


def last_value_held(run: DynamicRun, measured: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the last value says: the one before a run began, and the one before each row; shapes (n_row,) of the run.

    Parameters
    ----------
    run : DynamicRun
    measured : (n_row,) array
        The output in the whole log.
    """
    first = run.row[np.unique(run.number, return_index=True)[1]]
    return measured[first - 1][run.number], measured[run.row - 1]


@dataclass(frozen=True, eq=False)
class ModelRuns:
    """Dynamic models run on a log; ``str()`` says how far they went and how well.

    Attributes
    ----------
    models : list of Model
    runs : list of DynamicRun
        One per model.
    log : Table
    """

    models: list[Model]
    runs: list[DynamicRun]
    log: Table = field(repr=False)

    def to_table(self) -> Table:
        """Rows that were answered: time, run, and of each output what was measured, ``.run`` and ``.one_step``."""
        first = self.runs[0]
        columns, units = {"time": first.time, "run": first.number.astype(np.float64)}, {"time": "s", "run": "1"}
        if "time" not in self.log.names:
            units["time"] = "rows"
        for model, run in zip(self.models, self.runs, strict=True):
            name = model.output.name
            for ending, values in (("", run.measured), (".run", run.free), (".one_step", run.one_step)):
                columns[name + ending], units[name + ending] = values, model.output.unit
        return Table(columns, units)

    def text(self, units: str = DEFAULT) -> str:
        """How far the models went and how well."""
        first = self.runs[0]
        lines = [
            f"{first.n_run} free run(s) of up to {first.longest} rows, {len(first.row)} of {len(self.log)} rows answered"
        ]
        for model, run in zip(self.models, self.runs, strict=True):
            for name, values in (("free run", run.free), ("one step", run.one_step)):
                r2, rms, largest = errors_of(run.measured, values)
                sizes = (amount(size, model.output.unit, units) for size in (rms, largest))
                lines.append(f"{model.output.name}, {name}: {r2_text(r2)}, rms {next(sizes)}, largest {next(sizes)}")
        unused = unused_in_words(self.log)
        return "\n".join([*([f"warning: {unused}"] if unused else []), *lines])

    def __str__(self) -> str:
        return self.text()


def run_models(
    models: Sequence[Model] | str | Path,
    log: Table | str | Path | Sequence[Table | str | Path],
    *,
    every: float | None = None,
) -> ModelRuns:
    """Run dynamic models on a log: from measured inputs and their own predictions, next to what was measured.

    Of the outputs as many rows are read as the longest lag at the start of each segment; then the models go on by themselves.

    Parameters
    ----------
    models : sequence of Model, str or Path
        From `fit_dynamic`, or the model file: one for each output that they read of each other.
    log : Table, str, Path or sequence of them
        Or its file: the models' signals, at their raster, with a column ``time``.
    every : float, s, optional
        Restart from measured outputs after so much time; never within a segment if not given. Rows before a restart show how strong joints are.

    Returns
    -------
    ModelRuns

    Raises
    ------
    InputError
        A static model; a column that is missing; another raster; no rows that follow each other; a time shorter than the raster.
    """
    some = models_of(models)
    table, _ = table_of(log, [], [*TIMES, *_signals(some)])
    rows = rows_for(some, table)
    horizon = None if every is None else _rows_in(every, rows.raster)
    runs = run_on(some, table, spans_of(rows.segments, np.ones(len(table), dtype=bool)), horizon)
    return ModelRuns(some, runs, table)


def _rows_in(every: float, raster: float | None) -> int:
    if raster is None:
        raise InputError(f"every = {every:g} s: neither model nor log says how far apart rows are; leave it out")
    if not raster <= every < inf:
        raise InputError(f"every = {every:g} s: must be finite and no less than the raster of {raster:g} s")
    return round(every / raster)
