"""What people read: one table says in which unit each kind of quantity is shown; dates, numbers and labels in one form.

The package computes in SI and writes SI. Whatever is printed, drawn or set into a page takes ``units``, the name of one of `SYSTEMS`,
and converts here, last of all. A column in a unit of its own (psi, degC, none) is not SI and stays as it is.
"""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np

from polydraulic.errors import InputError
from polydraulic.pages import html
from polydraulic.units import from_si

Value = TypeVar("Value", float, np.ndarray)

DEFAULT = "metric"
_LONGEST = 80  # letters of a name in a picture, which would have no room for more
_SHOWN_ROWS, _SHOWN_COLUMNS = 5, 30  # at both ends; of a table that is displayed
# SI unit of a kind of quantity -> the unit it is shown in; a kind that is left out is shown in SI
SYSTEMS: dict[str, dict[str, str]] = {
    "metric": {
        "m": "mm",
        "Pa": "bar",
        "m3/s": "l/min",
        "rad": "deg",
        "rad/s": "deg/s",
        "m/V": "mm/V",
        "Pa^0.5": "bar^0.5",
        "m3/Pa": "l/bar",
        "m3/s/Pa": "l/min/bar",
        "m3/s/Pa^0.5": "l/min/bar^0.5",
        "m3/rad": "cm3/rev",
        "N/m": "N/mm",
    },
    "field": {
        "m": "in",
        "Pa": "psi",
        "m3/s": "in3/s",
        "rad": "deg",
        "rad/s": "deg/s",
        "m/V": "in/V",
        "Pa^0.5": "psi^0.5",
        "m3/Pa": "in3/psi",
        "m3/s/Pa": "in3/s/psi",
        "m3/s/Pa^0.5": "in3/s/psi^0.5",
        "m3/rad": "in3/rev",
        "N/m": "lbf/in",
    },
    "si": {},
}
_DATED = 5e8  # s, November 1985: times above count from 1970, since no log runs for sixteen years
_LONG = 1e9  # numbers below are written out
# what columns of a machine's runs and logs measure, by the last part of their names
QUANTITIES = {
    "voltage": "joystick",
    "spool": "spool position",
    "travel": "spool travel",
    "q_in": "flow in",
    "q_out": "flow out",
    "p_in": "inlet pressure",
    "p_out": "outlet pressure",
    "p_a": "pressure A",
    "p_b": "pressure B",
    "p_pump": "pump pressure",
    "q_pump": "pump flow",
    "angle": "angle",
    "rate": "angular rate",
    "position": "position",
    "speed": "speed",
}


def checked_units(units: str) -> str:
    """The name of a system of units, or an InputError.

    Parameters
    ----------
    units : str
        ``"metric"`` (bar, l/min, mm, deg), ``"field"`` (psi, in3/s, in, deg) or ``"si"``.

    Raises
    ------
    InputError
        Another name.
    """
    if units not in SYSTEMS:
        raise InputError(f"units = {units!r}: choose one of {list(SYSTEMS)}")
    return units


def shown_unit(unit: str, units: str = DEFAULT) -> str:
    """The unit in which a quantity in `unit` is shown; `unit` itself where it is not SI, or shown in SI.

    Raises
    ------
    InputError
        An unknown system of units.
    """
    return SYSTEMS[checked_units(units)].get(unit, unit)


def as_shown(value: Value, unit: str, units: str = DEFAULT) -> Value:
    """A value in `unit` as it is shown; scalar or array of any shape."""
    other = shown_unit(unit, units)
    return value if other == unit else from_si(value, other)


def readable(value: float, digits: int = 4) -> str:
    """A number of this many digits, without a power of ten where it can be written out."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _LONG else text


def amount(value: float, unit: str, units: str = DEFAULT, *, digits: int = 4) -> str:
    """A value in `unit` as it is shown, with its unit: ``"143.2 bar"``."""
    other = shown_unit(unit, units)
    text = readable(as_shown(float(value), unit, units), digits)
    return text if other in ("", "1") else f"{text} {other}"


def with_unit(name: str, unit: str) -> str:
    """Name and unit as they stand at an axis or above a column: ``"pump pressure [bar]"``."""
    return f"{name} [{unit}]" if unit not in ("", "1") else name


def as_drawn(text: str) -> str:
    """A name as text of a picture: letter by letter, for matplotlib would set what stands between dollars as a formula, or fail at it."""
    return (text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…").replace("$", r"\$")


def quantity_of(column: str) -> str:
    """What a column of a run measures, in words: ``"pump pressure"`` for ``boom.p_pump``; the column's name if that is not known."""
    return QUANTITIES.get(column.rpartition(".")[2], column)


def dated(seconds: float) -> bool:
    """Whether a time counts from 1970, so that it has a date."""
    return bool(seconds >= _DATED)


def moment(seconds: float) -> str:
    """A time of a log in words: its date where it has one, else its seconds."""
    if not dated(seconds):
        return f"{readable(seconds, 6)} s"
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S")


def time_axis(seconds: np.ndarray, began: float = 0.0) -> tuple[Any, str]:
    """Times as matplotlib draws them, and the label of the axis: dates where they have dates.

    Parameters
    ----------
    seconds : array, s
    began : float, s since 1970
        When the log's time was zero; 0 if that is not known.
    """
    at = seconds + began
    if not (at.size and dated(float(np.nanmin(at)))):
        return seconds, "time [s]"
    dates = (1e6 * at).astype("datetime64[us]")
    first, last = (str(np.datetime64(end, "D")) for end in (np.nanmin(dates), np.nanmax(dates)))
    return dates, f"time of day, {first}" if first == last else f"date and time, {first} to {last}"


def head(name: str, unit: str) -> str:
    """Name and unit of a column as files have them: ``"boom.p_in [Pa]"``."""
    return f"{name} [{unit}]" if unit else name


def columns_text(columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> str:
    """Names, units and the first and last value of columns of equal length, in lines."""
    heads = [head(name, units.get(name, "")) for name in list(columns)[:_SHOWN_COLUMNS]]
    width, n_row = max(map(len, heads), default=0), _rows_of(columns)
    lines = [f"Table of {n_row} rows and {len(columns)} columns"]
    for text, values in zip(heads, columns.values(), strict=False):
        ends = f"{values[0]:.6g} ... {values[-1]:.6g}" if n_row > 1 else ", ".join(f"{v:.6g}" for v in values)
        lines.append(f"  {text.ljust(width)}  {ends}".rstrip())
    rest = len(columns) - len(heads)
    return "\n".join([*lines, *([f"  and {rest} more"] if rest else [])])


def columns_html(columns: Mapping[str, np.ndarray], units: Mapping[str, str]) -> str:
    """Rows at both ends of columns of equal length, under names and units: what a notebook displays."""
    names, n = list(columns)[:_SHOWN_COLUMNS], _rows_of(columns)
    at = range(n) if n <= 2 * _SHOWN_ROWS else [*range(_SHOWN_ROWS), *range(n - _SHOWN_ROWS, n)]
    rows = [[str(row), *(f"{columns[name][row]:.6g}" for name in names)] for row in at]
    if n > len(rows):
        rows.insert(_SHOWN_ROWS, ["..."] * (1 + len(names)))
    more = ", the first shown" if len(names) < len(columns) else ""
    return html.table(
        f"{n} rows, {len(columns)} columns{more}",
        ["row", *(head(name, units.get(name, "")) for name in names)],
        rows,
    )


def _rows_of(columns: Mapping[str, np.ndarray]) -> int:
    return len(next(iter(columns.values()), ()))
