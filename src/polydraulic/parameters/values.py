"""Single values of a parameter tree, by paths such as ``boom.body.mass`` or ``spool.knots[2]``."""

import re
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any, TypeVar, get_type_hints

from polydraulic.errors import InputError, briefly
from polydraulic.parameters.conditions import broken_conditions
from polydraulic.parameters.quantity import LeafKind, is_number, leaf_of

Tree = TypeVar("Tree", bound=tuple)
_PATH = re.compile(r"(?P<name>[^\[\]]+)(?:\[(?P<place>\d+)\])?")


def replaced(machine: Tree, values: Mapping[str, Any]) -> Tree:
    """Return a machine with other values; see `Machine.with_values`."""
    known, wrong = leaves_of(type(machine)), list[str]()
    changes: dict[str, Any] = {}
    for path, value in values.items():
        match = _PATH.fullmatch(str(path))
        name = match["name"] if match else str(path)
        if match is None or name not in known:
            wrong.append(f"{path}: {_instead(str(path), known)}")
            continue
        leaf, place = known[name], match["place"]
        if place is not None:
            if int(place) >= leaf.size:
                wrong.append(
                    f"{path}: {f'the last one is {name}[{leaf.size - 1}]' if leaf.size else 'is a single value'}"
                )
                continue
            leaf = LeafKind(leaf.quantity)
        refusals = _refusals(str(path), value, leaf)
        wrong += refusals
        if place is not None:
            changes.setdefault(name, list(_at(machine, name)))[int(place)] = value
        elif not refusals:
            changes[name] = list(value) if leaf.size else value
    if not wrong:
        found = _put(machine, changes)
        wrong = broken_conditions(found)
    if wrong:
        raise InputError("a machine with these values cannot be made: " + "; ".join(wrong))
    return found


@cache
def leaves_of(cls: type, where: str = "") -> dict[str, LeafKind]:
    """Every value of a parameter tree, by its path."""
    found: dict[str, LeafKind] = {}
    for name, hint in get_type_hints(cls, include_extras=True).items():
        leaf = leaf_of(hint)
        found |= leaves_of(hint, f"{where}{name}.") if leaf is None else {where + name: leaf}
    return found


def _refusals(path: str, value: Any, leaf: LeafKind) -> list[str]:
    """What is wrong with a value in SI."""
    if leaf.quantity is None:
        return [] if isinstance(value, bool) else [f"{path} = {briefly(value)}: must be True or False"]
    if leaf.size:
        if not _is_list(value) or len(value) != leaf.size:
            return [f"{path} = {briefly(value)}: must be {leaf.size} numbers"]
        one = LeafKind(leaf.quantity)
        return [line for i, item in enumerate(value) for line in _refusals(f"{path}[{i}]", item, one)]
    if not is_number(value):
        return [f"{path} = {briefly(value)}: must be a number"]
    return [] if leaf.quantity.allows(value) else [f"{path} = {briefly(value)}: {leaf.quantity.demand(value)}"]


def _is_list(value: Any) -> bool:
    return hasattr(value, "__len__") and hasattr(value, "__getitem__") and not isinstance(value, str | Mapping)


def _instead(path: str, known: Mapping[str, LeafKind]) -> str:
    """Say what may be meant by a path that is none."""
    below = [name for name in known if name.startswith(f"{path}.")]
    if below:
        return f"holds {', '.join(below)}; give one of them"
    near = get_close_matches(path, known, n=3) or [name for name in known if name.endswith("." + path.split(".")[-1])]
    return f"there is no such value; near it: {', '.join(near)}" if near else "there is no such value"


def _at(tree: Any, path: str) -> Any:
    for name in path.split("."):
        tree = getattr(tree, name)
    return tree


def _put(tree: Any, changes: Mapping[str, Any], where: str = "") -> Any:
    """A tree with changed values, as plain floats, tuples of them, and switches."""
    parts = []
    for name, part in zip(tree._fields, tree, strict=True):
        if hasattr(part, "_fields"):
            part = _put(part, changes, f"{where}{name}.")
        elif where + name in changes:
            value = changes[where + name]
            part = tuple(map(float, value)) if isinstance(part, tuple) else type(part)(value)
        parts.append(part)
    return type(tree)(*parts)
