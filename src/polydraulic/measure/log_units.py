"""Units of logs: the table of the field first, single names that it does not have from pint.

pint takes long to start, and reads what no engineer means (`PS` as petasiemens): so it sees only names of three letters or more, whole
and without prefixes of one letter, never a text of a file. What it answers must be proportional, and of a kind that the table has.
"""

import re
from functools import cache, lru_cache
from typing import Any

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit
from polydraulic.errors import InputError
from polydraulic.unit_table import ATMOSPHERE, BASE, KINDS
from polydraulic.units import FACTORS, Conversion, Symbol, read_unit

_OF_BASE = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "radian": "rad"}
# names of pint that mean something else where a log of a machine has them: a standard flow is no power, a cup no volume
_WORDS = set(
    "slm slpm spl sound_pressure_level abc abv are bag blob bp chain circle cup cycle fifth gamma hand jig line link mas minim point pole "
    "rod section shake shot toe".split()
)
_NOT_ASKED = {"Pa^0.5"}  # kinds: gauss and oersted have these base units in pint
_PRESSURE = re.compile(r"(?:^|[^a-z0-9])p_|pressure|druck", re.IGNORECASE)


def need(module: str, extra: str = "measure") -> Any:
    """Import a library of an extra, or say how to get it."""
    from importlib import import_module

    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"{module} is not installed; this log needs an extra: pip install 'polydraulic[{extra}]'"
        ) from error


def conversion(unit: str, *, kind: str = "", atmosphere: float = ATMOSPHERE) -> Conversion:
    """How a unit converts to SI.

    Parameters
    ----------
    unit : str
        As the field writes it, see `polydraulic.units.read_unit`; or in words that pint has. Empty for plain numbers.
    kind : str
        SI unit of what is known to be measured: ``"Pa"`` makes ``kg/cm2`` the technical atmosphere.
    atmosphere : float, Pa
        Subtracted from absolute pressures: those of the package are gauge pressures.

    Returns
    -------
    Conversion

    Raises
    ------
    InputError
        If the unit is not known, or can be read in several ways; the nearest ones are named.

    Examples
    --------
    >>> conversion("l/min").si, round(conversion("bar(g)").factor)
    ('m3/s', 100000)
    """
    return read_unit(unit, kind=kind, atmosphere=atmosphere, library=_library)


def says_pressure(name: str) -> bool:
    """Whether a channel's name says that it is a pressure: ``p_head``, ``boom.p_a``, ``PumpPressure``, ``Druck A``."""
    return _PRESSURE.search(name) is not None


def conversion_shown(unit: str, units: str = DEFAULT) -> Conversion:
    """How a column in `unit` converts to what it is shown in, by a system of units of `polydraulic.display`."""
    return Conversion(1.0 / as_shown(1.0, unit, units), 0.0, unit, shown_unit(unit, units))


def same_kind(unit: str) -> list[str]:
    """Units of the field that measure the same thing, for a unit that may be the wrong one."""
    return [u for u in FACTORS.get(conversion(unit).si, {}) if u != unit]


def quantity(text: Any, kind: str, where: str, *, atmosphere: float = ATMOSPHERE) -> float:
    """Read a number with its unit, such as ``"10 ms"``, as SI of the kind `kind` (an SI unit); `atmosphere` as in `conversion`.

    Raises
    ------
    InputError
        If it is not a text of that form, not finite, or of another kind.
    """
    match = re.match(r"^\s*([-+\d.eE]+)\s*(.*?)\s*$", text) if isinstance(text, str) else None
    try:
        number = float(match[1]) if match else np.nan
    except ValueError:
        number = np.nan
    if match is None or not np.isfinite(number):
        raise InputError(f'{where} = {text!r}: must be a number with its unit in quotes, such as "10 {kind}"')
    found = conversion(match[2], kind=kind, atmosphere=atmosphere)
    if found.si != kind:
        raise InputError(f"{where} = {text!r}: must be in {kind} or a unit of that kind, not in {match[2]!r}")
    si = found.to_si(number)
    if si != 0.0 and not 1e-30 <= abs(si) <= 1e20:
        raise InputError(f"{where} = {text!r}: must be 0 or between 1e-30 and 1e20 in size, in SI units")
    return si


@cache
def _registry() -> Any:
    return need("pint").UnitRegistry(autoconvert_offset_to_baseunit=True)


@lru_cache(maxsize=1024)
def _library(name: str) -> Symbol | None:
    """A single name that pint knows and that is proportional to something in the table; None if there is none."""
    registry = _registry()
    if name.lower() in _WORDS or not any(not prefix for prefix, _, _ in registry.parse_unit_name(name)):
        return None
    try:
        zero, one = (registry.Quantity(value, name).to_base_units() for value in (0.0, 1.0))
        parts = {str(part): float(power) for part, power in one.unit_items()}
        factor = float(one.magnitude)
    except Exception:  # pint raises errors of many kinds; what it cannot convert is no unit for us
        return None
    if zero.magnitude != 0.0 or not set(parts) <= set(_OF_BASE) or not 1e-12 < factor < 1e12:
        return None
    powers = {_OF_BASE[part]: power for part, power in parts.items()}
    base = tuple(powers.get(letter, 0.0) for letter in BASE)
    kinds = [kind.si for kind in KINDS if kind.base == base and parts and kind.si not in _NOT_ASKED]
    return Symbol(factor, base, kinds[-1]) if kinds else None  # the last: a foot_pound is an energy
