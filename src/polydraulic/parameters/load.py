"""TOML -> Machine: each number is converted to SI once, and anything doubtful is one clear error.

Every entry of a parameter file is ``key = { value = ..., unit = "...", source = "..." }``; switches have no unit.
"""

import tomllib
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_type_hints

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.parameters.conditions import broken_conditions
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.quantity import Quantity, is_number, leaf_of
from polydraulic.parameters.schema import Machine

Tree = TypeVar("Tree", bound=tuple)
_SETS = Path(__file__).parent / "sets"


class Entry(NamedTuple):
    """One number of a parameter file, as written there."""

    key: str
    value: Any
    unit: str
    source: str


def load_machine(source: str | Path) -> Machine:
    """Load a parameter set.

    Parameters
    ----------
    source : str or Path
        Name of a set that comes with the package (``"cat215b"``), or the path of a TOML file.

    Returns
    -------
    Machine
        In SI units.

    Raises
    ------
    InputError
        Unknown or missing key, wrong unit, value out of range or not finite: file, key, value and what is allowed.
    """
    path = find(source, _SETS, "parameter set")
    machine = build(Machine, read_toml(path), where="", path=path)
    broken = broken_conditions(machine)
    if broken:
        raise InputError(f"{path}: " + "; ".join(broken))
    return machine


def as_machine(machine: Machine | str | Path) -> Machine:
    """Return a machine that is given, or load the parameter set of that name or path."""
    return machine if isinstance(machine, Machine) else load_machine(machine)


def machine_entries(source: str | Path) -> list[Entry]:
    """Every number of a parameter set as its file gives it, with its source: for tables and documentation."""
    found: list[Entry] = []

    def walk(tree: dict[str, Any], where: str) -> None:
        for key, item in tree.items():
            if "value" in item:
                found.append(Entry(where + key, item["value"], item.get("unit", ""), item["source"]))
            else:
                walk(item, f"{where}{key}.")

    walk(read_toml(find(source, _SETS, "parameter set")), "")
    return found


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
    """Parse a TOML file; whole numbers have 64 bits at most, as the format has it."""
    try:
        found = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    except (
        ValueError,
        RecursionError,
    ) as error:  # of texts that are no TOML, numbers of thousands of digits, lists in lists
        raise InputError(f"{path}: not a TOML file ({error})") from error
    waiting: list[tuple[str, Any]] = [("", found)]
    while waiting:
        where, item = waiting.pop()
        if isinstance(item, dict):
            waiting += [(f"{where}.{key}" if where else key, inner) for key, inner in item.items()]
        elif isinstance(item, list):
            waiting += [(f"{where}[{place}]", inner) for place, inner in enumerate(item)]
        elif isinstance(item, int) and not -(2**63) <= item < 2**63:
            raise InputError(
                f"{path}: {where} is a whole number of more than 64 bits; write it with a decimal point or an exponent"
            )
    return found


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
            values[key] = _switch(data[key], f"{where}{key}", path)
        else:
            values[key] = read_quantity(data[key], leaf.quantity, f"{where}{key}", path, leaf.size)
    return cls(**values)


def read_quantity(item: Any, quantity: Quantity, key: str, path: Path, size: int = 0) -> Any:
    """Return one entry in SI: a float, or a tuple of `size` floats (-1: any number of them)."""
    _entry(item, key, path, {"value", "unit", "source"})
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
            raise InputError(f"{path}: {key} = {value!r}: must be a list of {size if size > 0 else 'some'} numbers")
        return tuple(_number(v, known, quantity, f"{key}[{i}]", path) for i, v in enumerate(value))
    return _number(value, known, quantity, key, path)


def _number(value: Any, unit: units.Conversion, quantity: Quantity, key: str, path: Path) -> float:
    if not is_number(value):
        raise InputError(f"{path}: {key} = {value!r}: must be a number")
    si = unit.to_si(float(value))
    if not quantity.allows(si):
        here = Quantity(unit.unit, *map(unit.from_si, (quantity.low, quantity.high, quantity.above)))
        raise InputError(f"{path}: {key} = {value} {unit.unit}: {here.demand}")
    return si


def _switch(item: Any, key: str, path: Path) -> bool:
    _entry(item, key, path, {"value", "source"})
    if not isinstance(item["value"], bool):
        raise InputError(f"{path}: {key} = {item['value']!r}: must be true or false")
    return item["value"]


def _entry(item: Any, key: str, path: Path, needed: set[str]) -> None:
    check_keys(item, needed, needed, key, str(path))
    texts = [name for name in needed - {"value"} if not isinstance(item[name], str) or not item[name].strip()]
    if texts:
        raise InputError(f"{path}: {key}.{texts[0]} = {item[texts[0]]!r}: must be a string")
