"""What people read: one table says in which unit each kind of quantity is shown; dates, numbers and labels in one form.

The package computes in SI and writes SI. Whatever is printed, drawn or set into a page takes ``units``, the name of one of `SYSTEMS`,
and converts here, last of all. A column in a unit of its own (psi, degC, none) is not SI and stays as it is.
"""

from datetime import UTC, datetime
from typing import Any, TypeVar

import numpy as np

from polydraulic.errors import InputError
from polydraulic.units import from_si

Value = TypeVar("Value", float, np.ndarray)

DEFAULT = "metric"
_LONGEST = 80  # letters of a name in a picture, which would have no room for more
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
