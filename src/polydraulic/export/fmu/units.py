"""Units of an FMU: by base units, and in what else they can be displayed; all of it from the table of units."""

from xml.etree.ElementTree import Element, SubElement

from polydraulic.errors import InputError
from polydraulic.unit_table import BASE
from polydraulic.units import FACTORS, from_si, read_unit, unit_kind

_DISPLAYED = {"Pa": "bar", "m3/s": "l/min", "m": "mm", "rad": "deg", "rad/s": "deg/s"}


def display_unit(unit: str) -> str | None:
    """Unit in which people read it, where that is another one."""
    return _DISPLAYED.get(unit)


def unit_element(unit: str) -> Element:
    """The definition of a unit; one that is not known, or whose zero is not that of the SI unit, has a name only."""
    found = Element("Unit", name=unit)
    try:
        factor, offset, si, _ = read_unit(unit)
    except InputError:
        return found
    if offset != 0.0:
        return found
    base = dict(zip(BASE, unit_kind(si).base, strict=True))
    if all(exponent == int(exponent) for exponent in base.values()):  # FMI has no roots
        exponents = {name: str(int(exponent)) for name, exponent in base.items() if exponent}
        SubElement(found, "BaseUnit", exponents | ({} if factor == 1.0 else {"factor": repr(factor)}))
    for other in FACTORS[si]:
        if other != unit:
            SubElement(found, "DisplayUnit", name=other, factor=repr(from_si(factor, other)))
    return found
