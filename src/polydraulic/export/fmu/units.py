"""Units of an FMU: by base units, and in what else they can be displayed."""

from xml.etree.ElementTree import Element, SubElement

from polydraulic.units import FACTORS, from_si, si_unit

# Exponents of the base units of each SI unit; those of roots are no whole numbers, which FMI cannot say.
_BASE = {
    "1": {},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "s": {"s": 1},
    "m": {"m": 1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "kg": {"kg": 1},
    "kg m2": {"kg": 1, "m": 2},
    "m/s2": {"m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2},
    "N m s": {"kg": 1, "m": 2, "s": -1},
    "m/V": {"kg": -1, "m": -1, "s": 3, "A": 1},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "m3/s": {"m": 3, "s": -1},
    "m3/Pa": {"kg": -1, "m": 4, "s": 2},
    "m3/s/Pa": {"kg": -1, "m": 4, "s": 1},
    "m3/rad": {"m": 3, "rad": -1},
}
_DISPLAYED = {"Pa": "bar", "m3/s": "l/min", "m": "mm", "rad": "deg", "rad/s": "deg/s"}


def display_unit(unit: str) -> str | None:
    """Unit in which people read it, where that is another one."""
    return _DISPLAYED.get(unit)


def unit_element(unit: str) -> Element:
    """The definition of a unit; one that is not known has a name only."""
    found = Element("Unit", name=unit)
    if not any(unit in same for same in FACTORS.values()):
        return found
    si = si_unit(unit)
    factor = FACTORS[si][unit]
    if si in _BASE:
        base = {name: str(exponent) for name, exponent in _BASE[si].items()}
        SubElement(found, "BaseUnit", base | ({} if factor == 1.0 else {"factor": repr(factor)}))
    for other in FACTORS[si]:
        if other != unit:
            SubElement(found, "DisplayUnit", name=other, factor=repr(from_si(factor, other)))
    return found
