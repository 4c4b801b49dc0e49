"""What a MAT file holds, whatever its version: columns of numbers by name, and what is none."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

DEEPEST = 20  # structures in structures
EMPTY = "an empty array"
SPARSE = "a sparse matrix: save p = full(p)"
CELL = "a cell array: save what is in it, as p = c{1}"
COMPLEX = "complex numbers: save real(z) or abs(z)"
TEXTS = "texts: save numbers, times as seconds(t - t(1))"
CUBE = "an array of more than two dimensions: save matrices of it, as p = a(:, :, 1)"
# what MATLAB must be asked for, since only MATLAB reads its objects
_HINTS = {
    "timetable": "writetimetable(tt, 'log.csv'), or s = table2struct(timetable2table(tt), 'ToScalar', true) with s.Time = seconds(tt.Time)",
    "table": "writetable(t, 'log.csv'), or s = table2struct(t, 'ToScalar', true)",
    "timeseries": "t = ts.Time; p = ts.Data",
}


class Arrays(NamedTuple):
    """Columns of a file.

    Attributes
    ----------
    lengths : dict from str to int
        Number of values of each column.
    left_out : dict from str to str
        What is no column of numbers, and why.
    read : function (name, first row, end) -> array of float
    close : function ()
    """

    lengths: dict[str, int]
    left_out: dict[str, str]
    read: Callable[[str, int, int], np.ndarray]
    close: Callable[[], None]


def axis_of_time(shape: tuple[int, ...], rows: int | None) -> int | None:
    """Which axis of an array is time.

    Parameters
    ----------
    shape : tuple of int
        As MATLAB has it; one or two dimensions, or more with time as the last.
    rows : int, optional
        Number of values of the time that it belongs to.

    Returns
    -------
    int or None
        None where an array of more than two dimensions has another last side than its time.
    """
    if len(shape) > 2:
        return len(shape) - 1 if shape[-1] == rows else None
    if rows in shape:
        return shape.index(rows)
    return int(shape[-1] > shape[0]) if len(shape) == 2 else 0


def labels(name: str, count: int) -> list[str]:
    """Names of the columns of an array."""
    return [name] if count == 1 else [f"{name}[{number}]" for number in range(1, count + 1)]


def object_of(kind: str) -> str:
    """Why an object of a class is not read."""
    if not kind:  # SciPy does not tell its class
        return f"an object, such as a timetable or a string: {_HINTS['timetable']}"
    return f"an object of class {kind}" + (f": {_HINTS[kind]}" if kind in _HINTS else "")
