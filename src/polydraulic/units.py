"""The only conversions: the package computes in SI, the field speaks in inches, psi and degrees.

`FACTORS` lists, for each SI unit, the units that measure the same thing and how many SI units one of them is.
"""

from math import pi
from typing import TypeVar

import numpy as np

from polydraulic.errors import InputError

Value = TypeVar("Value", float, np.ndarray)

INCH = 0.0254
CUBIC_INCH = INCH**3
PSI = 4.4482216152605 / INCH**2  # one pound-force on a square inch
DEGREE = pi / 180.0

FACTORS: dict[str, dict[str, float]] = {
    "1": {"1": 1.0, "%": 0.01},
    "V": {"V": 1.0, "mV": 1e-3},
    "s": {"s": 1.0, "ms": 1e-3},
    "m": {"m": 1.0, "mm": 1e-3, "in": INCH},
    "rad": {"rad": 1.0, "deg": DEGREE},
    "rad/s": {"rad/s": 1.0, "deg/s": DEGREE, "rpm": 2 * pi / 60},
    "kg": {"kg": 1.0},
    "kg m2": {"kg m2": 1.0},
    "m/s2": {"m/s2": 1.0},
    "N m": {"N m": 1.0, "kN m": 1e3},
    "N m s": {"N m s": 1.0},
    "m/V": {"m/V": 1.0, "mm/V": 1e-3, "in/V": INCH},
    "Pa": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "bar": 1e5, "psi": PSI},
    "Pa^0.5": {"Pa^0.5": 1.0, "bar^0.5": 1e5**0.5, "psi^0.5": PSI**0.5},
    "m3/s": {"m3/s": 1.0, "l/min": 1e-3 / 60, "in3/s": CUBIC_INCH},
    "m3/Pa": {"m3/Pa": 1.0, "l/bar": 1e-8, "in3/psi": CUBIC_INCH / PSI},
    "m3/s/Pa": {"m3/s/Pa": 1.0, "l/min/bar": 1e-8 / 60, "in3/s/psi": CUBIC_INCH / PSI},
    "m3/s/Pa^0.5": {
        "m3/s/Pa^0.5": 1.0,
        "l/min/bar^0.5": 1e-3 / 60 / 1e5**0.5,
        "in3/s/psi^0.5": CUBIC_INCH / PSI**0.5,
    },
    "m3/rad": {"m3/rad": 1.0, "cm3/rev": 1e-6 / (2 * pi), "in3/rev": CUBIC_INCH / (2 * pi)},
}

_SI_OF = {unit: si for si, same in FACTORS.items() for unit in same}


def si_unit(unit: str) -> str:
    """Return the SI unit that measures the same thing as `unit`.

    Raises
    ------
    InputError
        If the unit is not known.
    """
    if unit not in _SI_OF:
        raise InputError(f"unknown unit {unit!r}; choose one of {sorted(_SI_OF)}")
    return _SI_OF[unit]


def to_si(value: Value, unit: str) -> Value:
    """Convert from `unit` to the SI unit of the same kind."""
    return value * FACTORS[si_unit(unit)][unit]


def from_si(value: Value, unit: str) -> Value:
    """Convert from SI to `unit`."""
    return value / FACTORS[si_unit(unit)][unit]
