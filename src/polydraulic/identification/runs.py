"""Dynamic models run on a log: what they answer on their own and one step ahead, next to what was measured."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks.dynamic.free_run import dynamics_of, free_run
from polydraulic.networks.dynamic.spans import Span, rows_of
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
        Measured; answered from the model's own answers; answered from measured values.
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
        Begin anew from measured outputs after so many rows.

    Returns
    -------
    list of DynamicRun
        One an output.

    Raises
    ------
    InputError
        A signal that is missing, or no span that is long enough.
    """
    warm_up = max(dynamics_of(model).warm_up for model in models)
    kept = [(a, b) for a, b in spans if b - a > warm_up]
    if not kept:
        longest = max((b - a for a, b in spans), default=0)
        raise InputError(
            f"at most {longest} rows of the table follow each other; a run needs more than {warm_up}, the longest lag"
        )
    rows, length = rows_of(kept), np.array([b - a for a, b in kept])
    labels, place = np.repeat(np.arange(len(kept)), length), np.concatenate([np.arange(n) - warm_up for n in length])
    outputs = [model.output.name for model in models]
    names = dict.fromkeys([*(lag.signal for model in models for lag in dynamics_of(model).lags), *outputs])
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


def lags_in_words(model: Model) -> str:
    """What a dynamic model reads, and when: "valve 0, 1; pressure 1 to 3 rows ago"."""
    steps: dict[str, list[int]] = {}
    for lag in dynamics_of(model).lags:
        steps.setdefault(lag.signal, []).append(lag.steps)
    return "; ".join(f"{name} {_counted(sorted(some))}" for name, some in steps.items()) + " rows ago"


def _counted(steps: list[int]) -> str:
    """Numbers in words: 1 to 4 where none is missing."""
    if len(steps) > 2 and all(b - a == 1 for a, b in pairwise(steps)):
        return f"{steps[0]} to {steps[-1]}"
    return ", ".join(str(step) for step in steps)


def run_table(models: Sequence[Model], runs: Sequence[DynamicRun], table: Table) -> Table:
    """Rows that were answered: time, run, and of each output what was measured, ``.run`` and ``.one_step``."""
    columns, units = {"time": runs[0].time, "run": runs[0].number.astype(np.float64)}, {"time": "s", "run": "1"}
    if "time" not in table.names:
        units["time"] = "rows"
    for model, run in zip(models, runs, strict=True):
        name = model.output.name
        for ending, values in (("", run.measured), (".run", run.free), (".one_step", run.one_step)):
            columns[name + ending], units[name + ending] = values, model.output.unit
    return Table(columns, units)
