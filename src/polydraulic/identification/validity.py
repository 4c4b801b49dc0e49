"""Whether a model still holds on new data: its errors next to those it was released with, in words."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, amount
from polydraulic.errors import InputError
from polydraulic.identification.judging import errors_by_region, errors_of
from polydraulic.identification.log_rows import rows_for
from polydraulic.identification.runs import run_on
from polydraulic.networks.dynamic.free_run import dynamics_of
from polydraulic.networks.dynamic.spans import spans_of
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import region_of
from polydraulic.tables import Table

_WORSE = 1.5  # times the error on rows held out, above which a model no longer holds
_AS_GOOD = 1.1  # times that error, up to which nothing need be said of the difference
_FEWER = 0.1  # by which the share of rows in their intervals may fall below the level, or what it was
_OUTSIDE = 0.05  # share of rows outside the domain that is worth a word
_NAMED = 3  # inputs that leave it, at most; those that do half as often as the first


class Validity(NamedTuple):
    """How a model does on a table.

    Attributes
    ----------
    holds : bool
    statements : list of str
        Why, in words.
    rms, largest : float
        In the output's unit.
    covered : float or None
        Share of the rows in their intervals; None if the model states none.
    outside : float
        Share of the rows outside its domain.
    regions : list of dict
        As `errors_by_region`; empty for a dynamic model.
    """

    holds: bool
    statements: list[str]
    rms: float
    largest: float
    covered: float | None
    outside: float
    regions: list[dict[str, Any]]


def validity(model: Model, table: Table, units: str = DEFAULT) -> Validity:
    """Judge a static model by data that it has not seen.

    Parameters
    ----------
    model : Model
        From `fit_table`, or its file: its training states what to expect.
    table : Table
        With its inputs and its output, in the same units.
    units : str
        Of the statements: ``"metric"``, ``"field"`` or ``"si"``; what is in a unit of its own stays.

    Raises
    ------
    InputError
        A column is missing, or has another unit.
    """
    _check_units(table, (*model.inputs, model.output))
    X, y = table.matrix([variable.name for variable in model.inputs]), table[model.output.name]
    error = model.predict(X) - y
    regions = errors_by_region(model, X, error)
    found = _judged(model, y, error, "rms error", "held_out_rms", X, regions, units)
    unseen = [r["region"] for r in regions if r["rows"] == 0]
    if unseen:
        found.statements.append(f"no rows in {len(unseen)} of its {len(regions)} regions: nothing is said about these")
    return found


def run_validity(models: Sequence[Model], table: Table, units: str = DEFAULT) -> list[Validity]:
    """Judge dynamic models by a log that they have not seen: they run on their own as they did when they were fitted.

    Free runs restart after as many rows as the ones that were stated, since errors grow with the length of a run.

    Parameters
    ----------
    models : sequence of Model
        All of a file, from `fit_dynamic`.
    table : Table
        With their signals, in the same units, at their raster; a column ``time`` unless the models do not state their raster.
    units : str
        Of the statements, as for `validity`.

    Returns
    -------
    list of Validity
        One per output.

    Raises
    ------
    InputError
        A column is missing, or has another unit; another raster; rows that do not follow each other.
    """
    for model in models:
        signals = [lag.signal for lag in dynamics_of(model).lags]
        read = [Variable(name, variable.unit) for name, variable in zip(signals, model.inputs, strict=True)]
        _check_units(table, (*read, model.output))
    spans = spans_of(rows_for(models, table).segments, np.ones(len(table), dtype=bool))
    stated = models[0].training.get("free_run_rows")
    horizon = stated if isinstance(stated, int) and stated > 0 else None
    whole = run_on(models, table, spans)
    runs = whole if horizon is None else run_on(models, table, spans, horizon)
    found = []
    for model, run, long in zip(models, runs, whole, strict=True):
        unit = model.output.unit
        lags = dynamics_of(model).lags
        X = np.column_stack([table[lag.signal][run.row - lag.steps] for lag in lags])
        what = f"{run.n_run} free run(s) of up to {run.longest} rows: rms error"
        judged = _judged(model, run.measured, run.free - run.measured, what, "free_run_rms", X, [], units)
        once, stated_once = errors_of(run.measured, run.one_step), model.training.get("one_step_rms")
        before = f", {amount(stated_once, unit, units)} when it was fitted" if isinstance(stated_once, float) else ""
        judged.statements.append(f"one step ahead: rms error {amount(once.rms, unit, units)}{before}")
        if long.longest > run.longest:
            rms = errors_of(long.measured, long.free).rms
            judged.statements.append(
                f"run through without a restart, up to {long.longest} rows: {amount(rms, unit, units)}"
            )
        found.append(judged)
    return found


def _verdict(ratio: float, *, worse: bool) -> str:
    """What is said of an error so many times as large as it was."""
    if worse:
        return "it errs more than it did"
    if ratio <= _AS_GOOD:
        return "as good as it was"
    return f"{ratio:.2g} times what it was, and it holds up to {_WORSE:g} times"


def _judged(
    model: Model, y: np.ndarray, error: np.ndarray, what: str, stated: str, X: np.ndarray,
    regions: list[dict[str, Any]], units: str,
) -> Validity:  # fmt: skip
    """Errors next to what the model states under the name `stated`, and whether its inputs lie where it was learnt."""
    rms, largest = float(np.sqrt(np.mean(error * error))), float(np.abs(error).max())
    outside = float(np.mean(~model.inside(X)))
    covered = _covered(model, X, error)
    statements, holds = [], True
    unit = model.output.unit
    expected, level = model.training.get(stated), model.training.get("interval_level")
    if isinstance(expected, float):
        worse = rms > _WORSE * expected and rms > 1e-9 * max(float(np.abs(y).max()), 1e-300)
        holds &= not worse
        statements.append(
            f"{what} {amount(rms, unit, units)}, {amount(expected, unit, units)} on rows held out when it was fitted: "
            f"{_verdict(rms / expected if expected > 0.0 else 1.0, worse=worse)}"
        )
    else:
        statements.append(f"{what} {amount(rms, unit, units)}; the model does not state what it was when it was fitted")
    if covered is not None and isinstance(level, float):
        before = model.training.get("interval_covered")
        reached = before if isinstance(before, float) else level
        least = min(level, reached) - _FEWER
        holds &= covered >= least
        once = f"{before:.0%} did when it was fitted, " if isinstance(before, float) else ""
        verdict = "the intervals hold" if covered >= level - _FEWER else "about as many as when it was fitted"
        statements.append(
            f"{covered:.0%} of the rows lie in their {level:.0%} intervals ({once}{least:.0%} must): "
            f"{verdict if covered >= least else 'the intervals no longer hold'}"
        )
    if outside > 0.0:
        known = "inputs were moved to the border of what it knows" if outside > _OUTSIDE else "few"
        statements.append(
            f"{outside:.1%} of the rows lie outside its domain: {known}; {_inputs_outside(model, X, units)}"
        )
        holds &= outside <= 0.5
    return Validity(bool(holds), statements, rms, largest, covered, outside, regions)


def _inputs_outside(model: Model, X: np.ndarray, units: str) -> str:
    """Inputs that leave the domain most often, all lags of a signal as one: their share of the rows, and the range that is known."""
    signals = [lag.signal for lag in model.dynamics.lags] if model.dynamics else [v.name for v in model.inputs]
    beyond, domain = model.beyond(X), model.domain()
    found = []
    for signal in dict.fromkeys(signals):
        columns = [k for k, name in enumerate(signals) if name == signal]
        worst = max(columns, key=lambda k: float(beyond[:, k].mean()))
        found.append((float(beyond[:, columns].any(axis=1).mean()), signal, worst))
    found.sort(key=lambda one: -one[0])
    told = []
    for share, signal, k in found[:_NAMED]:
        if share >= 0.5 * found[0][0]:
            low, high = (amount(end, model.inputs[k].unit, units) for end in domain[k].tolist())
            told.append(f"{signal} in {share:.1%}, known from {low} to {high}")
    return ", ".join(told)


def _check_units(table: Table, variables: Sequence[Variable]) -> None:
    """Refuse a column whose unit is another than the one that the model was fitted in."""
    for variable in variables:
        if table.unit(variable.name) != variable.unit and variable.unit and table.unit(variable.name):
            raise InputError(
                f"column {variable.name!r} is in {table.unit(variable.name)!r}; the model was fitted in {variable.unit!r}"
            )


def _covered(model: Model, X: np.ndarray, error: np.ndarray) -> float | None:
    """Share of the rows in their intervals."""
    widths = model.training.get("interval_half_widths")
    if not isinstance(widths, list) or len(widths) != len(model.networks):
        return None
    return float(np.mean(np.abs(error) <= np.array(widths)[region_of(model.partition, X)]))
