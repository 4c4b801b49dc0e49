"""Values of a target that lie so far from all others that they decide alone what is learnt: named, never left out.

Least squares weighs a row by the square of its distance. One value of a million among values of some ten, such as a logger writes for
"not available", holds nearly all of the variance, beside which what the others say is too little to be learnt.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

_TIMES = 10.0  # the range of the others, from the nearer end of it
_MOST = 20  # such values at most, and one of a hundred rows
_NAMED = 3


class FarTargetWarning(UserWarning):
    """That few values of a target lie far from all others."""


class FarValues(NamedTuple):
    """Rows whose values lie far from all others."""

    rows: np.ndarray  # (n_far,), rising
    values: np.ndarray
    low: float  # of all other values
    high: float

    def sentence(self, name: str, first: int = 0) -> str:
        """Which rows hold what, how far that is, and what to do.

        Parameters
        ----------
        name : str
            Of the column.
        first : int
            Number of the first row.
        """
        n = len(self.rows)
        named = ", ".join(
            f"{value:g} in row {row + first}"
            for row, value in zip(self.rows[:_NAMED].tolist(), self.values[:_NAMED].tolist(), strict=True)
        )
        named += "" if first else ", counted from 0"
        more = f" and {n - _NAMED} more rows" if n > _NAMED else ""
        span = self.high - self.low
        times = float(np.min(np.maximum(self.low - self.values, self.values - self.high)) / span)
        return (
            f"{name} holds {named}{more}, {times:.3g} times the range of all others ({self.low:g} to {self.high:g}) away from them: "
            f"{'they decide' if n > 1 else 'it decides'} nearly alone what is learnt, and the others next to nothing; if "
            f"{'these are no measurements' if n > 1 else 'this is no measurement'}, leave the row{'s' if n > 1 else ''} out"
        )


def far_values(y: np.ndarray) -> FarValues | None:
    """Few values that lie beyond all others by ten times the range of these or more, and outweigh them; None where there are none.

    Parameters
    ----------
    y : (n_row,) array
        NaN counts for nothing. Of others that are all the same, as where a signal is seldom on, nothing is far.
    """
    given = np.flatnonzero(~np.isnan(y))
    y = y[given]
    most = min(_MOST, len(y) // 4, 1 + len(y) // 100)
    if most < 1:
        return None
    scale = float(np.abs(y).max()) or 1.0
    middle = float(np.median(y))
    away = np.abs(y / scale - middle / scale)
    squares = away * away
    if most * squares.max() < 0.5 * squares.sum():
        return None
    order = np.argsort(-away, kind="stable")
    for n in range(most, 0, -1):
        others = y[order[n:]]
        low, high = float(others.min()), float(others.max())
        far = np.sort(order[:n])
        beyond = np.maximum(low - y[far], y[far] - high)
        if high > low and beyond.min() >= _TIMES * (high - low) and squares[far].sum() > 0.5 * squares.sum():
            return FarValues(given[far], y[far], low, high)
    return None


def warn_of_far_values(y: np.ndarray, stacklevel: int) -> None:
    """Warn of them in targets of shape (n_row,) or (n_row, n_output); rows count from zero, as arrays do.

    The warning is of the line that is `stacklevel` calls up: 2 for whoever called the function that looks here.
    """
    columns = y.reshape(len(y), -1).T
    for k, column in enumerate(columns):
        if (found := far_values(column)) is not None:
            warnings.warn(found.sentence(f"y{k}" if len(columns) > 1 else "y"), FarTargetWarning, stacklevel + 1)


@contextmanager
def far_values_untold() -> Iterator[None]:
    """Context of fits to parts of rows that were looked at as a whole before, and to what a function answers, which is no damaged measurement."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FarTargetWarning)
        yield
