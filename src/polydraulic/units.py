"""The only conversions: the package computes in SI, the field speaks in bar, inches and degrees.

A text is taken apart by `polydraulic.unit_grammar`, its names are looked up in `polydraulic.unit_table`. What comes of it is a factor and
exponents of base units, and those must be of a kind that the table has: what cannot be measured at a machine is refused, with the
nearest units that are known. Pressures of the package are gauge pressures: from one that says it is absolute, the atmosphere is taken.
"""

import re
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from math import prod
from typing import NamedTuple, TypeVar

import numpy as np

from polydraulic.errors import InputError
from polydraulic.unit_grammar import LONGEST, UnknownError, names_of, plain_text, split_mark
from polydraulic.unit_table import (
    ATMOSPHERE,
    BASE,
    DOUBTFUL,
    DOUBTFUL_ALONE,
    GRAVITY,
    KINDS,
    LOGARITHMIC,
    ZEROS,
    Exponents,
    UnitKind,
)

Value = TypeVar("Value", float, np.ndarray)


class Symbol(NamedTuple):
    """A single unit: SI units in one of it, exponents of base units, and the SI unit of its kind."""

    factor: float
    base: Exponents
    si: str


class Conversion(NamedTuple):
    """SI = factor value + offset; `si` is the package's name of the SI unit, `unit` the text that was read."""

    factor: float
    offset: float
    si: str
    unit: str

    def to_si(self, values: Value) -> Value:
        """Convert to SI."""
        return values * self.factor + self.offset if self.offset else values * self.factor

    def from_si(self, values: Value) -> Value:
        """Convert from SI."""
        return (values - self.offset) / self.factor if self.offset else values / self.factor

    @property
    def absolute(self) -> bool:
        """Whether it is an absolute pressure, so that the atmosphere is in the offset."""
        return self.si == "Pa" and self.offset != 0.0


class _Reading(NamedTuple):
    """What a text says: `zero` is that of a temperature, in K; `absolute` that of a pressure."""

    factor: float
    si: str
    zero: float = 0.0
    absolute: bool = False


Library = Callable[[str], Symbol | None]  # what else knows single names

_KIND_OF = {kind.si: kind for kind in KINDS}
_SYMBOLS = {
    name: Symbol(factor, kind.base, kind.si)
    for kind in KINDS
    for factor, names in kind.symbols.items()
    for name in names.split()
}
_SI_OF_BASE = {kind.base: kind.si for kind in reversed(KINDS)}
_SI_OF_BASE[(*_KIND_OF["N m s"].base[:-1], -1.0)] = "N m s"  # also written as N m s/rad


def _folded() -> dict[str, str]:
    """Names by their small letters, where only one unit has these."""
    found: dict[str, set[str]] = {}
    for name in _SYMBOLS:
        found.setdefault(name.lower(), set()).add(name)
    doubtful = {name.lower() for name in (*DOUBTFUL, *DOUBTFUL_ALONE)}
    return {
        key: min(names)
        for key, names in found.items()
        if len(key) > 1 and key not in doubtful and len({_SYMBOLS[name] for name in names}) == 1
    }


_FOLDED = _folded()


def read_unit(
    text: str, *, kind: str = "", atmosphere: float = ATMOSPHERE, library: Library | None = None
) -> Conversion:
    """How a unit converts to SI.

    Parameters
    ----------
    text : str
        As the field writes it: ``l/min``, ``cm³/U``, ``bar(g)``, ``psia``, ``deg C``, ``kN·m``, ``kgf/cm2``. Empty for plain numbers.
    kind : str
        SI unit of what is known to be measured; ``"Pa"`` makes ``kg/cm2`` the technical atmosphere. Not checked otherwise.
    atmosphere : float, Pa
        Subtracted from absolute pressures.
    library : function (name) -> Symbol or None, optional
        Asked for single names of three letters or more that the table does not have.

    Returns
    -------
    Conversion
        To the SI unit of the kind. ``degC`` and ``degF`` alone are temperatures, with their zero; in products, and written as
        ``delta_degC``, they are differences. ``1/min`` is a speed of rotation. Pressures are gauge pressures.

    Raises
    ------
    InputError
        A text that is not a unit, can be read in several ways, or measures what no machine's log has; the nearest units are named.

    Examples
    --------
    >>> read_unit("bar(a)")
    Conversion(factor=100000.0, offset=-101325.0, si='Pa', unit='bar(a)')
    """
    found = _read(text, kind, library)
    return Conversion(found.factor, -atmosphere if found.absolute else found.zero, found.si, text)


def si_unit(unit: str) -> str:
    """Return the SI unit that measures the same thing as `unit`.

    Raises
    ------
    InputError
        If the unit is not known.
    """
    return read_unit(unit).si


def to_si(value: Value, unit: str) -> Value:
    """Convert from `unit` to the SI unit of the same kind."""
    return read_unit(unit).to_si(value)


def from_si(value: Value, unit: str) -> Value:
    """Convert from SI to `unit`."""
    return read_unit(unit).from_si(value)


def unit_kind(si: str) -> UnitKind:
    """The kind that an SI unit of the table measures."""
    return _KIND_OF[si]


@lru_cache(maxsize=4096)
def near(text: str) -> list[str]:
    """The three known units that are spelled most like a text."""
    from difflib import get_close_matches

    products = (unit for kind in KINDS for unit in (kind.si, *kind.offered, *kind.products))
    known = list(dict.fromkeys([*products, "barg", "bara", "psig", "psia", *_SYMBOLS]))
    return get_close_matches(text[:LONGEST], known, n=3, cutoff=0.0)


class _DoubtfulError(Exception):
    """What to write instead of a text that can be read in several ways."""


@lru_cache(maxsize=4096)
def _read(text: str, kind: str, library: Library | None) -> _Reading:
    shown = repr(text) if len(text) <= LONGEST else f"{text[:LONGEST]!r}..."
    try:
        return _reading(text, kind, library)
    except _DoubtfulError as error:
        raise InputError(f"unit {shown} {error}") from error
    except UnknownError as error:
        why = f": {error}" if str(error) else ""
        raise InputError(
            f"unknown unit {shown}{why}; nearest known units: {', '.join(map(repr, near(text)))}"
        ) from error


def _reading(text: str, kind: str, library: Library | None) -> _Reading:
    plain = plain_text(text)
    if plain in ("", "-", "1"):
        return _Reading(1.0, "1")
    marked = _marked(plain, library)
    if marked is not None:
        return marked
    try:
        return _unmarked(plain, kind, library)
    except (UnknownError, _DoubtfulError):
        if plain.isupper() and "/" in plain:  # capitals throughout, as in MM/S
            return _unmarked(plain.lower(), kind, library)
        raise


def _marked(plain: str, library: Library | None) -> _Reading | None:
    """A pressure that says whether it is gauge, absolute or a difference; None if it is none."""
    parts = split_mark(plain)
    if parts is None:
        return None
    try:
        found = _unmarked(parts[0], "Pa", library)
    except (UnknownError, _DoubtfulError):
        return None
    return found._replace(absolute=parts[1] == "a") if found.si == "Pa" else None


def _unmarked(plain: str, kind: str, library: Library | None) -> _Reading:
    names = names_of(plain)
    alone = len(names) == 1 and names[0][1] == 1.0
    found = [(_symbol(name, alone, library), power) for name, power in names]
    first, power = found[0]
    if alone:
        return _Reading(first.factor, first.si, ZEROS.get(names[0][0], ZEROS.get(names[0][0].lower(), 0.0)))
    if len(found) == 1 and power == -1.0 and (first.si, first.factor) == ("s", 60.0):
        return _Reading(_SYMBOLS["rpm"].factor, "rad/s")  # 1/min
    si = _SI_OF_BASE.get(_base(found))
    if si is not None:
        if si == "N m" and any(symbol.si in ("W", "J") for symbol, _ in found):
            si = "J"
        if si == "kg/s" and any(symbol.si == "N" for symbol, _ in found):  # a force over a speed
            si = "N s/m"
        return _Reading(_factor(found), si)
    # a mass where only a force makes sense: pounds of a torque are; kilograms on an area are where a pressure is known
    weights = [name.lower().rstrip("s") in ("kg", "lb", "t") for name, _ in names]
    heavy = [(_weight(s) if is_weight else s, p) for (s, p), is_weight in zip(found, weights, strict=True)]
    as_force = _SI_OF_BASE.get(_base(heavy), "")
    if (as_force == "Pa" == kind) or (as_force == "N m" and any(name.lower().startswith("lb") for name, _ in names)):
        return _Reading(_factor(heavy), as_force)
    if as_force in ("Pa", "N m"):
        force = re.sub(r"\b(kg|lb|t)s?(?![a-z])", r"\1f", plain.lower() if plain.isupper() else plain)
        raise _DoubtfulError(f"is a unit of mass, not of force: write {force!r} for a {_KIND_OF[as_force].name}")
    raise UnknownError("nothing in a machine's log is measured in it")


def _symbol(name: str, alone: bool, library: Library | None) -> Symbol:
    if alone and name in DOUBTFUL_ALONE:
        raise _DoubtfulError(f"can be read in several ways; write {DOUBTFUL_ALONE[name]}")
    if name in _SYMBOLS:
        return _SYMBOLS[name]
    if name[0] == "K" and "k" + name[1:] in _SYMBOLS:
        return _SYMBOLS["k" + name[1:]]
    said = DOUBTFUL.get(name) or DOUBTFUL.get(name.lower())
    if said:
        raise _DoubtfulError(f"can be read in several ways; write {said}")
    if name.lower() in LOGARITHMIC:
        raise _DoubtfulError("is not proportional to what it measures; convert the channel first")
    mega = name[0] in "GM" and name[1:] in _SYMBOLS  # Mbar is not mbar
    if (name.isupper() or name.islower() or name.istitle()) and name.lower() in _FOLDED and not mega:
        return _SYMBOLS[_FOLDED[name.lower()]]
    found = library(name) if library is not None and re.fullmatch(r"[A-Za-z_]{3,24}", name) else None
    if found is None:
        raise UnknownError("" if alone else f"{name!r} is not a known unit")
    return found


def _weight(mass: Symbol) -> Symbol:
    return Symbol(mass.factor * GRAVITY, _KIND_OF["N"].base, "N")


def _base(found: list[tuple[Symbol, float]]) -> Exponents:
    return tuple(sum(power * symbol.base[n] for symbol, power in found) for n in range(len(BASE)))


def _factor(found: list[tuple[Symbol, float]]) -> float:
    """Product of factors; whole powers are taken of the decimal numbers, so that cm3 is 1e-6, and divided by last."""
    if any(power != int(power) for _, power in found):
        above, below = (prod(s.factor ** (p * side) for s, p in found if p * side > 0.0) for side in (1.0, -1.0))
        return above / below
    up, down = (
        prod((Fraction(repr(s.factor)) ** int(p * side) for s, p in found if p * side > 0.0), start=Fraction(1))
        for side in (1, -1)
    )
    # what is divided by is a whole part of 1 for areas and volumes: then the factor is multiplied, and stays exact
    return float(up) * down.denominator if down.numerator == 1 else float(up) / float(down)


# SI unit -> units in which people are shown the same thing, and how many SI units one of them is.
FACTORS: dict[str, dict[str, float]] = {
    kind.si: {unit: read_unit(unit).factor for unit in (kind.si, *kind.offered)} for kind in KINDS
}
