"""Fit a table: one model per output, with its error and the coverage of its intervals on rows that were held out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from sklearn.base import clone

from polydraulic.display import DEFAULT, amount
from polydraulic.errors import InputError
from polydraulic.identification.arguments import check_columns, parts_of, table_of, unused_in_words
from polydraulic.identification.judging import HeldOut, OutputFit, far_from_others, judged
from polydraulic.measure.log_units import conversion_shown
from polydraulic.networks.growth.far_values import far_values_untold
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.growth.synthesis import FEWEST_ROWS
from polydraulic.networks.growth.workers import in_processes, one_after_the_other
from polydraulic.networks.hold_out import BLOCKS, held_distinct_rows, held_rows
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.regions.region_regressor import RegionRegressor
from polydraulic.progress import Progress, quiet
from polydraulic.tables import Table

if TYPE_CHECKING:
    from polydraulic.measure.checks.deadband import Deadband


_COPY = 1e-10  # below one, of a correlation: no two sensors agree so well
_NOISE = 0.05  # of the span of bounds, by which noise may lie beyond them
_MANY = 0.1  # of all rows: where so many lie beyond bounds, these are why little was learnt
_TIMED = "time is an input: the models know the times of this table alone, and others lie outside of their domain"
_LONG = 100_000  # rows times regions: with fewer, processes take longer to start than the fits take


@dataclass(frozen=True, eq=False)
class TableFit:
    """Models of a table; ``str()`` says how good they are.

    Attributes
    ----------
    outputs : list of OutputFit
        One per output.
    deadbands : list of Deadband
        Empty if they were not asked for.
    table : Table
        What the models were fitted to.
    source : str
        Where it came from.
    asked : int
        Regions that might have been found.
    """

    outputs: list[OutputFit]
    deadbands: list["Deadband"]
    table: Table = field(repr=False)
    source: str
    asked: int = 1

    @property
    def models(self) -> list[Model]:
        """The models, to be saved, exported or run."""
        return [found.model for found in self.outputs]

    @property
    def doubts(self) -> list[str]:
        """What makes the models doubtful, in sentences: rows that are not used; values far from all others; outputs beyond bounds, or that inputs do not determine, or are."""
        return self._doubts(DEFAULT)

    def _doubts(self, units: str) -> list[str]:
        far = far_from_others(self.table, self.models)  # beside these, nothing shows whether inputs determine an output
        of_outputs = [
            doubt
            for found in self.outputs
            for doubt in (
                *_of_bounds(found, self.table, units, told=found.model.output.name in far),
                _copied(found, self.table),
            )
            if doubt
        ]
        timed = any(variable.name == "time" for found in self.outputs for variable in found.model.inputs)
        unused = unused_in_words(self.table)
        return [*([unused] if unused else []), *far.values(), *of_outputs, *([_TIMED] if timed else [])]

    def text(self, units: str = DEFAULT) -> str:
        """What was found, in lines."""
        deadbands = [d.statement(conversion_shown(self.table.unit(d.input), units)) for d in self.deadbands]
        warnings = [f"warning: {doubt}" for doubt in self._doubts(units)]
        outputs = [line for found in self.outputs for line in (found.text(units), *self._one_region(found))]
        return "\n".join([*deadbands, *outputs, *warnings])

    def _one_region(self, found: OutputFit) -> list[str]:
        """A line where regions were asked for, and none was found."""
        if self.asked == 1 or len(found.model.networks) > 1:
            return []
        return [
            f"  up to {self.asked} regions were asked for: no cut lowers the predicted squared error enough, so it stays one"
        ]

    def __str__(self) -> str:
        return self.text()


def fit_table(
    table: Table | str | Path | Sequence[Table | str | Path],
    inputs: Sequence[str],
    outputs: Sequence[str],
    *,
    edges: Mapping[str, Sequence[float]] | None = None,
    max_regions: int = 1,
    deadbands: bool = False,
    estimator: AbductiveRegressor | None = None,
    progress: Progress = quiet,
) -> TableFit:
    """Fit each output column from the input columns.

    A fifth of the rows is held out to state the error; the models are then fitted on all rows, in the regions that the others gave.

    Parameters
    ----------
    table : Table, str, Path or sequence of them
        Or its file. With a column ``time`` it is a log: blocks of time are held out, since neighbours in time are not
        independent. Of several tables, or a pattern such as ``day*.parquet``, no block crosses the end of one.
    inputs, outputs : sequence of str
        Columns.
    edges : mapping from input name to edges, optional
        Regions, in the column's unit.
    max_regions : int
        Without edges, this many regions may be found.
    deadbands : bool
        Whether regions also end where an imported log (``time``, ``segment``) shows a deadband.
    estimator : AbductiveRegressor, optional
        Cloned for every fit; one whose outputs are bounded by the data if not given.
    progress : Progress, optional
        Called as the fits of each output begin.

    Returns
    -------
    TableFit

    Raises
    ------
    InputError
        A column that is missing, constant, or both input and output; values that are not finite; too few rows; edges of an unknown
        column; deadbands without a log; tables of which one lacks a column or has it in another unit.

    Examples
    --------
    >>> rng = np.random.default_rng(0)
    >>> a, b = rng.uniform(size=(2, 100))
    >>> found = fit_table(Table({"a": a, "b": b, "y": a * b}, {"y": "Pa"}), ["a", "b"], ["y"])
    >>> print(found.models[0].output, found.outputs[0].r2 > 0.99)
    y [Pa] True
    """
    rows, source = table_of(table, [*inputs, *outputs], ["time", "segment"])
    check_columns(rows, inputs, outputs)
    borders, found = _with_deadbands(edges or {}, rows, inputs, outputs) if deadbands else (edges or {}, [])
    unknown = [name for name in borders if name not in inputs]
    if unknown:
        raise InputError(f"edges name the column {unknown[0]!r}; the inputs are {list(inputs)}")
    for name, cuts in borders.items():
        _check_edges(name, cuts, rows[name], rows.unit(name))
    if not isinstance(max_regions, Integral) or isinstance(max_regions, bool) or max_regions < 1:
        raise InputError(f"max_regions = {max_regions!r}: must be a whole number, at least 1")
    base = AbductiveRegressor() if estimator is None else estimator
    by_index = {list(inputs).index(name): cuts for name, cuts in borders.items()}
    regressor = RegionRegressor(base, edges=by_index or None, max_regions=max_regions)
    by_time = "time" in rows.names
    X = rows.matrix(inputs)
    if by_time and len(rows) >= 10 * BLOCKS:
        held = held_rows(len(rows), BLOCKS, parts_of(rows))
    else:
        held = held_distinct_rows(np.c_[X, rows.matrix(outputs)], FEWEST_ROWS)
    names = [Variable(name, rows.unit(name)) for name in inputs]
    learn, everything = ~held, np.ones(len(rows), dtype=bool)
    # regions that are given need not wait for each other
    kept = [(learn,), (everything,)] if by_index else [(learn, everything)]
    wanted = [(output, parts) for output in outputs for parts in kept]

    def tell(done: int) -> None:
        if done < len(wanted):
            progress(wanted[done][0], done, len(wanted))

    work = [(clone(regressor), X, rows[output], parts) for output, parts in wanted]
    long = len(rows) * len(by_index or range(max_regions)) >= _LONG
    pieces = (in_processes if long else one_after_the_other)(_fitted, work, tell)
    learnt = iter([fitted for piece in pieces for fitted in piece])
    fits: list[OutputFit] = []
    for output, without, final in zip(outputs, learnt, learnt, strict=True):
        y, model = rows[output], final.to_model(names, Variable(output, rows.unit(output)))
        fits.append(judged(model, HeldOut(X[held], y[held], without.predict(X[held]), by_time), len(y)))
    return TableFit(fits, found, rows, source, 1 if by_index else int(max_regions))


def _check_edges(name: str, cuts: Sequence[float], values: np.ndarray, unit: str) -> None:
    """Refuse edges that do not rise, or beyond which a column has no rows."""
    given = np.asarray(cuts) if not isinstance(cuts, str) else np.array([cuts])
    if (
        given.ndim != 1
        or given.dtype.kind not in "fiu"
        or not np.isfinite(given).all()
        or (np.diff(given) <= 0.0).any()
    ):
        raise InputError(f"edges of {name!r} = {cuts!r}: must be rising finite numbers")
    beyond = given[(given < values.min()) | (given >= values.max())]
    if beyond.size:
        edge, low, high = (amount(value, unit) for value in (beyond[0], values.min(), values.max()))
        plain = f"; an edge without a unit is in {unit}" if unit not in ("", "1") else ""
        raise InputError(
            f"edges of {name!r}: no rows lie beyond {edge}, the column goes from {low} to {high}: add data there, or move the edge{plain}"
        )


def _copied(found: OutputFit, table: Table) -> str:
    """Sentence on an input that is the output itself but for scale and offset; empty if none is."""
    y = table[found.model.output.name]
    for variable in found.model.inputs:
        x = table[variable.name]
        together = np.corrcoef(x / np.abs(x).max(), y / np.abs(y).max())  # squares of tiny numbers are 0
        if 1.0 - abs(float(together[0, 1])) < _COPY:
            return (
                f"{found.model.output.name}: {variable.name} is the same but for scale and offset: if it is made of it, or of what it is made of, "
                "the model says nothing; leave it out then"
            )
    return ""


def _of_bounds(found: OutputFit, table: Table, units: str, *, told: bool) -> list[str]:
    """Sentences on rows that bounds of the output keep out of reach, and on what was learnt, unless many such rows or others `told` are why."""
    y, networks, output = table[found.model.output.name], found.model.networks, found.model.output
    low, high = min(n.y_low for n in networks), max(n.y_high for n in networks)
    beyond = int(np.sum((y < low - _NOISE * (high - low)) | (y > high + _NOISE * (high - low))))
    learnt = "" if told or beyond > _MANY * len(y) else found.doubt
    if not beyond:
        return [learnt]
    ends = " to ".join(amount(end, output.unit, units) for end in (low, high))
    return [
        f"{output.name}: {beyond} of {len(y)} rows lie beyond its bounds, {ends}, which the model cannot leave: widen them, unless these rows "
        "are wrong",
        learnt,
    ]


def _fitted(work: tuple[RegionRegressor, np.ndarray, np.ndarray, tuple[np.ndarray, ...]]) -> list[RegionRegressor]:
    """Of some rows, and of others in the regions that these gave, so that errors of the first are stated of the same regions."""
    regressor, X, y, (first, *others) = work
    with far_values_untold():
        fitted = regressor.fit(X[first], y[first])
        return [fitted, *(fitted.refitted(X[rows], y[rows]) for rows in others)]


def _with_deadbands(
    edges: Mapping[str, Sequence[float]], table: Table, inputs: Sequence[str], outputs: Sequence[str]
) -> tuple[dict[str, list[float]], list["Deadband"]]:
    """Edges, and those of the deadbands that an imported log shows; also the deadbands."""
    from polydraulic.measure.checks.deadband import find_deadbands  # only a log needs the extra that comes with it

    if not {"time", "segment"} <= set(table.names):
        raise InputError("deadbands are found in an imported log, with the columns 'time' and 'segment'; give edges")
    raster = float(np.median(np.diff(table["time"])))
    found = {name: list(cuts) for name, cuts in edges.items()}
    deadbands = find_deadbands(table, inputs, outputs, raster)
    for deadband in (deadband for deadband in deadbands if deadband.found):
        found[deadband.input] = sorted({*found.get(deadband.input, []), deadband.low, deadband.high})
    return found, deadbands
