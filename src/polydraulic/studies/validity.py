"""Whether a model still holds on new data: its errors next to those it was released with, in words."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.networks import Model
from polydraulic.networks.partition import region_of
from polydraulic.studies.fit import errors_by_region
from polydraulic.tables import Table

_WORSE = 1.5  # times the error on rows held out, above which a model no longer holds
_FEWER = 0.1  # by which the share of rows in their intervals may fall below the level
_OUTSIDE = 0.05  # share of rows outside the domain that is worth a word


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
        As `errors_by_region`.
    """

    holds: bool
    statements: list[str]
    rms: float
    largest: float
    covered: float | None
    outside: float
    regions: list[dict[str, Any]]


def validity(model: Model, table: Table) -> Validity:
    """Judge a model by data that it has not seen.

    Parameters
    ----------
    model : Model
        From `fit_table`, or its file: its training states what to expect.
    table : Table
        With its inputs and its output, in the same units.

    Raises
    ------
    InputError
        A column is missing, or has another unit.
    """
    for variable in (*model.inputs, model.output):
        if table.unit(variable.name) != variable.unit and variable.unit and table.unit(variable.name):
            raise InputError(
                f"column {variable.name!r} is in {table.unit(variable.name)!r}; the model was fitted in {variable.unit!r}"
            )
    X, y = table.matrix([variable.name for variable in model.inputs]), table[model.output.name]
    error = model.predict(X) - y
    rms, largest = float(np.sqrt(np.mean(error * error))), float(np.abs(error).max())
    outside = float(np.mean(~model.inside(X)))
    covered = _covered(model, X, error)
    statements, holds = [], True
    unit = f" {model.output.unit}".rstrip()
    expected, level = model.training.get("held_out_rms"), model.training.get("interval_level")
    if isinstance(expected, float):
        worse = rms > _WORSE * expected and rms > 1e-9 * max(float(np.abs(y).max()), 1e-300)
        holds &= not worse
        statements.append(
            f"rms error {rms:.4g}{unit}, {expected:.4g} on rows held out when it was fitted: "
            f"{'it errs more than it did' if worse else 'as good as it was'}"
        )
    else:
        statements.append(f"rms error {rms:.4g}{unit}; the model does not state what it was when it was fitted")
    if covered is not None and isinstance(level, float):
        few = covered < level - _FEWER
        holds &= not few
        statements.append(
            f"{covered:.0%} of the rows lie in their {level:.0%} intervals: "
            f"{'the intervals no longer hold' if few else 'the intervals hold'}"
        )
    if outside > 0.0:
        known = "inputs were moved to the border of what it knows" if outside > _OUTSIDE else "few"
        statements.append(f"{outside:.1%} of the rows lie outside its domain: {known}")
        holds &= outside <= 0.5
    regions = errors_by_region(model, X, error)
    unseen = [r["region"] for r in regions if r["rows"] == 0]
    if unseen:
        statements.append(f"no rows in {len(unseen)} of its {len(regions)} regions: nothing is said about these")
    return Validity(bool(holds), statements, rms, largest, covered, outside, regions)


def _covered(model: Model, X: np.ndarray, error: np.ndarray) -> float | None:
    """Share of the rows in their intervals."""
    widths = model.training.get("interval_half_widths")
    if not isinstance(widths, list) or len(widths) != len(model.networks):
        return None
    return float(np.mean(np.abs(error) <= np.array(widths)[region_of(model.partition, X)]))
