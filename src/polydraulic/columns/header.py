"""Names and units in the header of a text file.

``name [unit]``, ``name (unit)``, ``name <unit>``, ``name {unit}``, ``[unit] name``, ``name/unit`` (the quotient of DIN and ISO),
``name in unit``, ``name, unit``, ``name - unit``, or units in a line of their own. What could be something else stays a name: ``p_bar``, ``km/h``, ``pulses/s``, ``valve/A``.
"""

import re
from collections import Counter
from collections.abc import Sequence

from polydraulic.errors import InputError, briefly
from polydraulic.units import FACTORS, read_unit

_BRACKETS = re.compile(r"^\s*(?P<name>.*?)\s*\[(?P<unit>[^\]]*)\]\s*$")
_OTHER_BRACKETS = re.compile(r"^\s*(?P<name>.*?\S)\s*(?:<(?P<angle>[^<>]+)>|\{(?P<curly>[^{}]+)\})\s*$")
_BEFORE = re.compile(r"^\s*\[(?P<unit>[^\]]+)\]\s*(?P<name>\S.*?)\s*$")
_PARENTHESES = re.compile(r"^\s*(?P<name>.*?\S)\s*\((?P<unit>[^()]*(?:\([^()]*\))?)\)\s*$")
# What may be a unit in parentheses; single letters that are names of ports (A, B, C, P, T) are none.
_SYMBOLS = frozenset(
    "s ms us µs ns min h sec m mm cm km µm um in ft bar mbar barg bara psi psig psia Pa hPa kPa MPa Nm N kN MN J kJ W kW V mV kV "
    "mA kg t l L ml cc cm3 m3 rev U deg ° grad rad rpm RPM 1/min Hz kHz °C degC degF K % gpm GPM lpm LPM lbf lb hp PS g Ω Ohm".split()
) | {unit for units in FACTORS.values() for unit in units if len(unit) > 1}
# units but for capitals; In, Min, HP and Rev are as often inlet, least value, high pressure and reverse
_FOLDED = frozenset(symbol.casefold() for symbol in _SYMBOLS if len(symbol) > 1) - {"in", "min", "hp", "rev"}
_WITH_UNIT = re.compile(r"^\s*[+-]?[0-9][0-9.,]*([eE][+-]?[0-9]+)?\s*(?P<unit>[^\s0-9.,].*?)\s*$")
_HEXADECIMAL = re.compile(r"^\s*(0[xX][0-9a-fA-F]+|[0-9A-F]{2,8}[hH]?)\s*$")
_ALSO = ("A", "bar(g)", "bar(a)", "psi(g)", "psi(a)")  # units in parentheses, but for ports of pressures
_FORMS = (
    re.compile(r"^(?P<name>[^/]*[^/\s])\s*/\s*(?P<unit>\([^()]+\)|[^()\s]+(\([^()]*\))?)$"),
    re.compile(r"(?i)^(?P<name>.*\S)\s+in\s+(?P<unit>\S+)$"),
    re.compile(r"^(?P<name>.*[^\s,])\s*,\s*(?P<unit>[^\s,]+)$"),
    re.compile(r"^(?P<name>.*\S)\s+-\s+(?P<unit>\S+)$"),
)
_BARE = re.compile(r"^(\[[^\]]*\]|\([^()]*\))$")  # a unit by its brackets
_TYPE = re.compile(  # F1, I1 and U1 are names of forces, currents and voltages
    r"(?i)^(smp|avg|tot|std|u?int(8|16|32|64)?|float(32|64)?|(?-i:[fiu][1248])|double|single|real|bool(ean)?|string|text|numeric|number)$"
)
# what a unit must measure where a name says what is measured; elsewhere rates are divided by times, and A is a port
_TIME = re.compile(r"^(t|(?i:time|timestamp|zeit|zeitstempel|dauer|duration))([ _]|$)")
_CURRENT = re.compile(r"(?i)^(i|current|strom)([ _]|$)")
_PRESSURE = re.compile(r"(?i)^(p|pressure|druck)([ _]|$)")
_POWER = re.compile(r"[\^*]*-?[\d²³]+$")


def names_and_units(header: Sequence[str], width: int) -> tuple[list[str], list[str]]:
    """Names and units of `width` columns; a column without a name is called by its number."""
    heads = [*header, *[""] * width][:width]
    split = [_split(head) for head in heads]
    count = Counter(name for name, _ in split)
    raw = Counter(heads)
    names, units = [], []
    for number, (head, (name, unit)) in enumerate(zip(heads, split, strict=True), 1):
        if count[name] > 1 and raw[head] == 1 and not _BRACKETS.match(head):
            name, unit = head, ""  # what stands in the parentheses tells columns apart
        names.append(name or f"column {number}")
        units.append(unit)
    return names, units


def unit_line(cells: Sequence[str], header: Sequence[str]) -> bool:
    """Whether a line beside the header gives units: short texts, as many as there are names at most, one of them a unit for sure."""
    given = [cell for cell in cells if cell]
    short = bool(given) and len(cells) <= len(header) + 1 and all(len(cell) <= 12 for cell in given)
    return short and any(_BARE.match(cell) or is_unit(cell) or _kind(cell) for cell in given)


def type_line(cells: Sequence[str]) -> bool:
    """Whether a line gives kinds of data, as ``float``, ``int32`` and ``Avg``."""
    given = [cell for cell in cells if cell]
    return bool(given) and all(_TYPE.match(cell) for cell in given)


def is_unit(text: str) -> bool:
    """Whether a text looks like a unit, such as ``bar``, ``l/min`` or ``m/s^2``."""
    parts = [part for part in re.split(r"[/·* ]", text.strip()) if part]
    return bool(parts) and all(
        part in _SYMBOLS or _POWER.sub("", part) in _SYMBOLS or (part == "1" and len(parts) > 1) for part in parts
    )


def says_time(name: str) -> bool:
    """Whether a name says that times stand below it."""
    return _TIME.match(name.strip()) is not None


def example(cell: str) -> str:
    """Words on a cell that is not a number, and on what to do where it is one with its unit, or a hexadecimal one."""
    match = _WITH_UNIT.match(cell)
    unit = match["unit"] if match else ""
    more = ""
    if _HEXADECIMAL.match(cell) and not cell.isalpha():
        more = ": hexadecimal numbers, or some with a unit; write plain decimal ones"
    elif is_unit(unit) or _kind(unit):
        more = f": numbers with their unit; leave {unit!r} out of the cells"
    return f"such as {briefly(cell)}{more}"


def _split(head: str) -> tuple[str, str]:
    match = _BRACKETS.match(head)
    if match:
        return match["name"], match["unit"].strip()
    match = _PARENTHESES.match(head)
    if match:
        inner = match["unit"].strip()
        pressure = re.match(r"(?i)^(p|pressure|druck)\b", match["name"])
        known = is_unit(inner) or _is_capital_unit(inner) or inner in _ALSO
        if known and not (pressure and inner == "A"):
            return match["name"].rstrip("/ "), inner
    match = _OTHER_BRACKETS.match(head) or _BEFORE.match(head)
    if match:
        found = match.groupdict()
        inner = next(text.strip() for key, text in found.items() if key != "name" and text)
        if is_unit(inner) or _is_capital_unit(inner):
            return match["name"], inner
    head = head.strip()
    for form in _FORMS:
        match = form.match(head)
        if match:
            name, unit = match["name"], re.sub(r"^\((.*)\)$", r"\1", match["unit"]).strip()
            if _measured_in(name, unit, head):
                return name, unit
    return head, ""


def _is_capital_unit(text: str) -> bool:
    """Whether a text is a unit but for capital letters, as ``Bar``, ``PSI`` or ``Deg``."""
    return text.casefold() in _FOLDED and bool(_kind(text))


def _measured_in(name: str, unit: str, head: str) -> bool:
    """Whether a name and a unit stand in a head, not a unit alone, a rate, or a port."""
    found, is_time = _kind(unit), _TIME.match(name) is not None
    if found == "s" or is_time:
        return found == "s" and is_time
    if not found or _kind(head):
        return False
    return (found == "Pa" or not _PRESSURE.match(name)) and (found != "A" or _CURRENT.match(name) is not None)


def _kind(text: str) -> str:
    """SI unit of what a unit of the table measures; empty for any other text."""
    try:
        return read_unit(text, kind="Pa").si if text and text != "1" else ""
    except InputError:
        return ""
