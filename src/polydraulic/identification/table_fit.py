"""Fit a table: one model an output, with its error and the coverage of its intervals on rows that were held out."""

from collections.abc import Mapping, Sequence
from math import ceil, inf
from typing import Any, NamedTuple

import numpy as np
from sklearn.base import clone

from polydraulic.errors import InputError
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.partition import region_of
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

FOLD = 5  # one of so many rows, or blocks of time, is held out
BLOCKS = 20  # of a log
LEVEL = 0.9  # of the intervals


class Errors(NamedTuple):
    """Errors of answers next to what was measured, in the output's unit."""

    r2: float
    rms: float
    largest: float


class HeldOut(NamedTuple):
    """Rows that were held out: inputs, output, and what a model fitted without them says."""

    X: np.ndarray
    y: np.ndarray
    predicted: np.ndarray
    by_time: bool  # whether they are blocks of time, or every fifth row


class TableFit(NamedTuple):
    """A model of all rows, and how one without the rows held out does on these; in the output's unit.

    Attributes
    ----------
    model : Model
        Its `training` states all of the following.
    r2, rms, largest : float
        Of the errors on the rows held out.
    half_widths : list of float
        Of the intervals at `LEVEL`, by region; from half of the rows held out.
    covered : float
        Share of the other half that lies in its interval.
    held : HeldOut
    """

    model: Model
    r2: float
    rms: float
    largest: float
    half_widths: list[float]
    covered: float
    held: HeldOut


def fit_table(
    table: Table,
    inputs: Sequence[str],
    outputs: Sequence[str],
    estimator: AbductiveRegressor,
    edges: Mapping[str, Sequence[float]],
    max_regions: int = 1,
    progress: Progress = quiet,
) -> list[TableFit]:
    """Fit each output column from the input columns.

    Parameters
    ----------
    table : Table
        With a column ``time`` it is a log: blocks of time are held out, since neighbours in time are no independent witnesses.
    inputs, outputs : sequence of str
    estimator : AbductiveRegressor
        Cloned for every fit.
    edges : mapping from input name to edges
        Regions; empty to find them, or for one network.
    max_regions : int
        Without edges, so many regions may be found.
    progress : Progress, optional
        Called twice an output.

    Raises
    ------
    InputError
        A column that is both input and output, a constant column, too few rows, edges of an unknown column.
    """
    check_columns(table, inputs, outputs)
    unknown = [name for name in edges if name not in inputs]
    if unknown:
        raise InputError(f"edges name the column {unknown[0]!r}; the inputs are {list(inputs)}")
    if len(table) <= FOLD:
        raise InputError(f"the table has {len(table)} rows; fitting and holding out takes more than {FOLD}")
    by_index = {list(inputs).index(name): cuts for name, cuts in edges.items()}
    X = table.matrix(inputs)
    by_time = "time" in table.names
    held = held_out(len(table), by_time=by_time)
    fits = []
    for number, output in enumerate(outputs):
        y = table[output]
        regressor = RegionRegressor(estimator, edges=by_index or None, max_regions=max_regions)
        progress(f"{output}: hold out", 2 * number, 2 * len(outputs))
        predicted = clone(regressor).fit(X[~held], y[~held]).predict(X[held])
        progress(f"{output}: all rows", 2 * number + 1, 2 * len(outputs))
        fitted = clone(regressor).fit(X, y)
        model = fitted.to_model([Variable(n, table.unit(n)) for n in inputs], Variable(output, table.unit(output)))
        fits.append(judged(model, HeldOut(X[held], y[held], predicted, by_time), len(y)))
    return fits


def check_columns(table: Table, inputs: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse a column that is both input and output, or constant."""
    both = set(inputs) & set(outputs)
    if both:
        raise InputError(f"column {sorted(both)[0]!r} is both input and output")
    for name in [*inputs, *outputs]:
        if len(table) and np.ptp(table[name]) == 0.0:
            role = "cannot explain anything: leave it out" if name in inputs else "needs no model"
            raise InputError(f"column {name!r} is {table[name][0]:g} in all {len(table)} rows; it {role}")


def with_deadbands(
    edges: Mapping[str, Sequence[float]], table: Table, inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[dict[str, list[float]], list[str]]:
    """Edges, and those of the deadbands that an imported log shows; also what was found, in words.

    Raises
    ------
    InputError
        A table without the columns ``time`` and ``segment``.
    """
    from polydraulic.measure.checks.deadband import find_deadbands  # only a log needs the extra that comes with it

    if not {"time", "segment"} <= set(table.names):
        raise InputError("deadbands are found in an imported log, with the columns 'time' and 'segment'; give edges")
    raster = float(np.median(np.diff(table["time"])))
    found = {name: list(cuts) for name, cuts in edges.items()}
    deadbands = find_deadbands(table, inputs, outputs, raster)
    for deadband in (deadband for deadband in deadbands if deadband.found):
        found[deadband.input] = sorted({*found.get(deadband.input, []), deadband.low, deadband.high})
    return found, [deadband.statement() for deadband in deadbands]


def held_out(n: int, *, by_time: bool) -> np.ndarray:
    """Which of `n` rows are held out, (n,) array of bool: every fifth row, or of a log every fifth block of time."""
    place = np.arange(n) * BLOCKS // n if by_time and n >= 10 * BLOCKS else np.arange(n)
    return np.asarray(place % FOLD == FOLD - 1)


def errors_of(measured: np.ndarray, predicted: np.ndarray) -> Errors:
    """R2, rms and largest error of rows, both of shape (n_row,)."""
    error = predicted - measured
    mean_square, spread = float(np.mean(error * error)), float(np.var(measured))
    r2 = 1.0 - mean_square / spread if spread > 0.0 else 0.0  # as scikit-learn: nothing to explain
    return Errors(r2, mean_square**0.5, float(np.abs(error).max()))


def unit_after(variable: Variable) -> str:
    """Unit as it stands after a number in a sentence; nothing where there is none."""
    return "" if variable.unit in ("", "1") else f" {variable.unit}"


def errors_by_region(model: Model, X: np.ndarray, error: np.ndarray) -> list[dict[str, Any]]:
    """Rows, rms and largest error in each region of a model."""
    region = region_of(model.partition, X)
    found = []
    for k, name in enumerate(model.region_names()):
        e = error[region == k]
        sizes = (float(np.sqrt(np.mean(e * e))), float(np.abs(e).max())) if len(e) else (0.0, 0.0)
        found.append({"region": name, "rows": len(e), "rms": sizes[0], "largest": sizes[1]})
    return found


def half_width(sizes: np.ndarray) -> float:
    """Half width of an interval at `LEVEL`, split-conformal; infinite where the rows are too few to state it."""
    rank = ceil((len(sizes) + 1) * LEVEL)
    return float(np.sort(sizes)[rank - 1]) if rank <= len(sizes) else inf


def judged(model: Model, held: HeldOut, rows: int) -> TableFit:
    """Errors and intervals of a model fitted to `rows` rows, by those held out; written into the model's training, too."""
    error = held.predicted - held.y
    region = region_of(model.partition, held.X)
    # blocks of time, or rows, in turn: one half sets the widths, the other one says whether they hold
    sets = np.arange(len(error)) * 4 // len(error) % 2 == 0 if held.by_time else np.arange(len(error)) % 2 == 0
    sizes = np.abs(error)
    everywhere = half_width(sizes[sets])
    widths = []
    for k in range(len(model.networks)):
        own = half_width(sizes[sets & (region == k)])
        widths.append(own if np.isfinite(own) else everywhere)  # too few rows of its own
    covered = float(np.mean(sizes[~sets] <= np.array(widths)[region[~sets]]))
    errors = errors_of(held.y, held.predicted)
    model.training.update(
        {
            "rows": rows,
            "held_out": "blocks of time" if held.by_time else "every fifth row",
            **{f"held_out_{name}": value for name, value in errors._asdict().items()},
            "held_out_by_region": errors_by_region(model, held.X, error),
            "interval_level": LEVEL,
            "interval_half_widths": widths if np.all(np.isfinite(widths)) else [],
            "interval_covered": covered,
        }
    )
    return TableFit(model, *errors, widths, covered, held)
