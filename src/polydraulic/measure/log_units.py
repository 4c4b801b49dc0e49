"""Units of logs: anything pint can read, and what the field writes; SI as the package names it inside.

pint takes long to start and is slow on single numbers, so that it is asked once for each channel.
"""

import re
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.units import FACTORS

# Pressures of the package are gauge pressures. Logs say so, or say nothing and mean it; absolute ones lose an atmosphere.
_DEFINITIONS = (
    "gpm = gallon / minute",
    "lpm = liter / minute",
    "cfm = foot ** 3 / minute",
    "rev = 2 * pi * radian",
    "barg = bar",
    "psig = psi",
    "bara = bar; offset: -1.01325",
    "psia = psi; offset: -14.695948775513",
    "Nm = newton * meter",
)
_PLAIN = {"": "dimensionless", "-": "dimensionless", "1": "dimensionless", "U/min": "rev/min", "rpm": "rev/min"}
_PLAIN |= {"RPM": "rev/min", "PSI": "psi", "Bar": "bar", "BAR": "bar", "GPM": "gpm", "LPM": "lpm"}
_NAMED = ("N", "W")  # SI units with a name of their own that the package itself does not convert
_LETTERS = re.compile(r"[\w/*^.()·%° \-²³Ω]*")
_POWER = re.compile(r"(?<=[A-Za-zµ])\^?(-?\d(?:\.\d+)?)(?![A-Za-z\d])")


Value = TypeVar("Value", float, np.ndarray)


class Conversion(NamedTuple):
    """SI = factor value + offset; `si` is the package's name of the SI unit, `unit` the log's."""

    factor: float
    offset: float
    si: str
    unit: str

    def to_si(self, values: Value) -> Value:
        """Convert from the log's unit."""
        return values * self.factor + self.offset

    def from_si(self, values: Value) -> Value:
        """Convert to the log's unit."""
        return (values - self.offset) / self.factor


def need(module: str) -> Any:
    """Import a library of the extra `measure`, or say how to get it."""
    from importlib import import_module

    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"{module} is not installed; logs need the extra: pip install 'polydraulic[measure]'"
        ) from error


@cache
def conversion(unit: str) -> Conversion:
    """How a unit converts to SI.

    Parameters
    ----------
    unit : str
        As pint reads it, or as the field writes it: ``l/min``, ``gpm``, ``barg``, ``psia``, ``in3/s``, ``rpm``, ``kg m2``. Empty
        for plain numbers.

    Returns
    -------
    Conversion
        To the unit of `polydraulic.units` of the same kind, or to SI base units where that has none. Pressures are gauge
        pressures: of ``bara`` and ``psia`` the standard atmosphere is taken.

    Raises
    ------
    InputError
        If the unit is not known.

    Examples
    --------
    >>> conversion("l/min").si, round(conversion("barg").factor)
    ('m3/s', 100000)
    """
    base = _base(unit)
    zero, one, two = (float(_registry().Quantity(v, _parse(unit)).to(base).magnitude) for v in (0.0, 1.0, 2.0))
    if abs(two - 2.0 * one + zero) > 1e-9 * (abs(one) + abs(zero)):
        raise InputError(f"unit {unit!r} is not proportional to what it measures; convert the channel first")
    name = _si_names().get(str(base))
    if name is None:
        name = format(base, "~C").replace("**", "").replace("*", " ")
    factor = one - zero
    own = FACTORS.get(name, {})  # the package's own factors, where it has one
    return Conversion(own.get(unit, factor), zero, name, unit)


def conversion_shown(unit: str, units: str = DEFAULT) -> Conversion:
    """How a column in `unit` converts to what it is shown in, by a system of units of `polydraulic.display`."""
    return Conversion(1.0 / as_shown(1.0, unit, units), 0.0, unit, shown_unit(unit, units))


def same_kind(unit: str) -> list[str]:
    """Units of the field that measure the same thing, for a unit that may be the wrong one."""
    return [u for u in FACTORS.get(conversion(unit).si, {}) if u != unit]


def quantity(text: Any, kind: str, where: str) -> float:
    """Read a number with its unit, such as ``"10 ms"``, as SI of the kind `kind` (an SI unit).

    Raises
    ------
    InputError
        If it is no text of that form, not finite, or of another kind.
    """
    match = re.match(r"^\s*([-+\d.eE]+)\s*(.*?)\s*$", text) if isinstance(text, str) else None
    try:
        number = float(match[1]) if match else np.nan
    except ValueError:
        number = np.nan
    if match is None or not np.isfinite(number):
        raise InputError(f'{where} = {text!r}: must be a number with its unit in quotes, such as "10 {kind}"')
    found = conversion(match[2])
    if found.si != kind:
        raise InputError(f"{where} = {text!r}: must be in {kind} or a unit of that kind, not in {match[2]!r}")
    return number * found.factor + found.offset


@cache
def _registry() -> Any:
    pint = need("pint")
    registry = pint.UnitRegistry(on_redefinition="ignore", autoconvert_offset_to_baseunit=True)
    for definition in _DEFINITIONS:
        registry.define(definition)
    return registry


@cache
def _parse(unit: str) -> Any:
    if not _LETTERS.fullmatch(unit):
        raise InputError(f"unknown unit {unit!r}: it holds characters that no unit has")
    text = _PLAIN.get(unit.strip(), unit.strip())
    text = re.sub(r"(?<=[\w²³)])[ ·](?=[A-Za-z(])", "*", text.replace("²", "2").replace("³", "3"))
    try:
        parsed = _registry().parse_units(_POWER.sub(r"**\1", text))
    except Exception as error:  # pint raises errors of many kinds on odd text
        raise InputError(
            f"unknown unit {unit!r}; write it as in 'bar', 'l/min', 'gpm', 'barg', 'in3/s', 'deg/s', 'kg m2'"
        ) from error
    return parsed


def _base(unit: str) -> Any:
    return _registry().get_base_units(_parse(unit))[1]


@cache
def _si_names() -> dict[str, str]:
    """Name of the package for base units of pint; the first where two measure in the same."""
    return {str(_base(si)): si for si in (*_NAMED, *reversed(FACTORS))}
