"""Entries of TOML files as numbers in SI: each is converted once, and anything doubtful is one clear error.

Every entry of a parameter file is ``key = { value = ..., unit = "...", source = "..." }``; switches have no unit. Besides, an entry may say
that an identification may change it (``free``), how far it may be off (``spread``, a standard deviation), and how far it was left unsure
(``uncertainty``, a standard error, or one for each number of a table), all in its own unit.
"""

import re
import tomllib
from math import inf
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from polydraulic import units
from polydraulic.errors import InputError, briefly
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.quantity import Quantity, is_number, leaf_of

Tree = TypeVar("Tree", bound=tuple)
_OF_A_FIT = {"free", "spread", "uncertainty"}  # what an identification may change, how far, and what it left unsure
_DEEPEST = 20  # levels of tables and lists
# A key of a hundred parts, for which a parser of TOML takes time with the square of their number.
_LONG_KEY = re.compile(r"""(?<![\w."'-])(?:(?:[\w-]++|"[^"\n]{0,99}+"|'[^'\n]{0,99}+')[ \t]*+\.[ \t]*+){100}""")


def find(source: str | Path, folder: Path, what: str, more: str = "") -> Path:
    """Path of a TOML file given by path, or by its name in a folder of the package; `more` says what else may be given."""
    if not isinstance(source, str | Path):
        raise InputError(f"a {what} is given by its name or the path of a .toml file, not as {type(source).__name__}")
    if Path(source).suffix == ".toml":
        if not Path(source).is_file():
            raise InputError(f"{what} {source}: no such file")
        return Path(source)
    path = folder / f"{source}.toml"
    if not path.is_file():
        raise InputError(
            f"unknown {what} {str(source)!r}; choose one of {sorted(p.stem for p in folder.glob('*.toml'))} "
            f"or give the path of a .toml file{more}"
        )
    return path


def read_toml(path: Path) -> dict[str, Any]:
    """Parse a TOML file.

    Raises
    ------
    InputError
        It is none, is nested too deep, or holds a whole number beyond the 64 bits that TOML has for them.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")  # editors of Windows write a byte order mark
        if _LONG_KEY.search(text):
            raise RecursionError
        data = tomllib.loads(text)
    except RecursionError as error:
        raise InputError(f"{path}: not a machine or scenario file: tables or lists are nested too deep") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: not a text in UTF-8, which a TOML file must be: save it with that encoding"
        ) from error
    except ValueError as error:  # also whole numbers of thousands of digits
        raise InputError(f"{path}: not a TOML file ({error}){_about_commas(text, str(error))}") from error
    _check_sizes(data, path)
    return data


def _about_commas(text: str, error: str) -> str:
    """What to do about the line of an error, where it has a number with a decimal comma."""
    at = re.search(r"at line (\d+)", error)
    line = text.splitlines()[int(at[1]) - 1] if at else ""
    found = re.search(r"= *([+-]?\d+),(\d+)", line)
    return f"; decimals have a point: {found[1]}.{found[2]}, not {found[1]},{found[2]}" if found else ""


def _check_sizes(data: dict[str, Any], path: Path) -> None:
    """Refuse whole numbers that TOML does not have and depths at which nobody looks, without going deep oneself."""
    level: list[tuple[str, Any]] = list(data.items())
    for _ in range(_DEEPEST):
        for key, item in level:
            if isinstance(item, int) and not -(2**63) <= item < 2**63:
                raise InputError(
                    f"{path}: {key} = {briefly(item)}: a whole number has 64 bits; write a larger one with a point"
                )
        inner: list[tuple[str, Any]] = []
        for key, item in level:
            if isinstance(item, dict):
                inner += [(f"{key}.{name}", part) for name, part in item.items()]
            elif isinstance(item, list):
                inner += [(f"{key}[{place}]", part) for place, part in enumerate(item)]
        level = inner
    if level:
        raise InputError(f"{path}: {level[0][0][:60]} ...: tables or lists are nested too deep")


def build(cls: type[Tree], data: Any, *, where: str, path: Path, base: Tree | None = None) -> Tree:
    """Build a named tuple from nested dicts; keys that are missing are taken from `base`, if one is given."""
    hints = get_type_hints(cls, include_extras=True)
    check_keys(data, hints, hints if base is None else (), where.rstrip("."), str(path))
    values = {}
    for key, hint in hints.items():
        if key not in data:
            values[key] = getattr(base, key)
        elif (leaf := leaf_of(hint)) is None:
            part = None if base is None else getattr(base, key)
            values[key] = build(hint, data[key], where=f"{where}{key}.", path=path, base=part)
        elif leaf.quantity is None:
            values[key] = read_switch(data[key], f"{where}{key}", path)
        else:
            values[key] = read_quantity(data[key], leaf.quantity, f"{where}{key}", path, leaf.size)
    return cls(**values)


def read_quantity(item: Any, quantity: Quantity, key: str, path: Path, size: int = 0) -> Any:
    """Return one entry in SI: a float, or a tuple of `size` floats (-1: any number of them)."""
    _entry(item, key, path, {"value", "unit", "source"}, quantity.unit)
    unit, value = item["unit"], item["value"]
    try:
        known = units.read_unit(unit, kind=quantity.unit)
    except InputError as error:
        raise InputError(f"{path}: {key}: {error}") from error
    if known.si != quantity.unit:
        allowed = [*units.FACTORS[quantity.unit], *units.unit_kind(quantity.unit).products]
        raise InputError(
            f"{path}: {key} has unit {unit!r}; allowed: {allowed}, or another unit of {units.unit_kind(quantity.unit).name}"
        )
    if size:
        if not isinstance(value, list) or (size > 0 and len(value) != size) or not value:
            raise InputError(
                f"{path}: {key} = {briefly(value)}: must be a list of {size if size > 0 else 'some'} numbers"
            )
        return tuple(_number(v, known, quantity, f"{key}[{i}]", path) for i, v in enumerate(value))
    return _number(value, known, quantity, key, path)


def _number(value: Any, unit: units.Conversion, quantity: Quantity, key: str, path: Path) -> float:
    if not is_number(value):
        raise InputError(f"{path}: {key} = {briefly(value)}: must be a number")
    si = unit.to_si(float(value))
    if not quantity.allows(si):
        here = Quantity(unit.unit, *map(unit.from_si, (quantity.low, quantity.high, quantity.above)))
        raise InputError(f"{path}: {key} = {value} {unit.unit}: {here.demand(si)}")
    return si


def read_switch(item: Any, key: str, path: Path) -> bool:
    """Return one switch, true or false."""
    _entry(item, key, path, {"value", "source"})
    if not isinstance(item["value"], bool):
        raise InputError(f"{path}: {key} = {briefly(item['value'])}: must be true or false")
    return item["value"]


def _entry(item: Any, key: str, path: Path, needed: set[str], unit: str = "") -> None:
    if not isinstance(item, dict):
        value = str(item).lower() if isinstance(item, bool) else briefly(item) if is_number(item) else "..."
        parts = [f"value = {value}", *([f'unit = "{unit}"'] if unit else []), 'source = "..."']
        raise InputError(f"{path}: {key} = {briefly(item)}: must be a table such as {{ {', '.join(parts)} }}")
    check_keys(item, needed | _OF_A_FIT if "unit" in needed else needed, needed, key, str(path))
    texts = [name for name in needed - {"value"} if not isinstance(item[name], str) or not item[name].strip()]
    if texts:
        raise InputError(f"{path}: {key}.{texts[0]} = {briefly(item[texts[0]])}: must be a string")
    if not isinstance(item.get("free", False), bool):
        raise InputError(f"{path}: {key}.free = {briefly(item['free'])}: must be true or false")
    if "spread" in item and not (is_number(item["spread"]) and 0.0 < item["spread"] < inf):
        raise InputError(f"{path}: {key}.spread = {briefly(item['spread'])}: must be a number above 0")
    errors = item.get("uncertainty", 0.0)
    if not all(is_number(error) and error >= 0.0 for error in (errors if isinstance(errors, list) else [errors])):
        raise InputError(
            f"{path}: {key}.uncertainty = {briefly(errors)}: must be 0 or more, inf where nothing is known"
        )
