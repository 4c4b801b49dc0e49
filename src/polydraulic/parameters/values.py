"""Single values of a parameter tree, by paths such as ``links.boom.mass`` or ``functions.boom.valve.knots[2]``."""

import re
from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any, get_type_hints

from polydraulic.errors import briefly
from polydraulic.parameters.quantity import LeafKind, is_number, leaf_of

_PATH = re.compile(r"(?P<name>[^\[\]]+)(?:\[(?P<place>\d+)\])?")


def checked_values(
    values: Mapping[str, Any], known: Mapping[str, LeafKind], now: Callable[[str], Any]
) -> tuple[dict[str, Any], list[str]]:
    """Values by their whole paths, tables complete, and what is wrong with them.

    Parameters
    ----------
    values : mapping from path to value in SI
    known : mapping from path to LeafKind
        All paths that there are.
    now : callable
        Gives what stands at one of these.
    """
    changes: dict[str, Any] = {}
    wrong: list[str] = []
    for path, value in values.items():
        match = _PATH.fullmatch(str(path))
        name = match["name"] if match else str(path)
        if match is None or name not in known:
            wrong.append(f"{path}: {_instead(str(path), known)}")
            continue
        leaf, place = known[name], match["place"]
        if place is not None:
            size = len(changes[name]) if name in changes and leaf.size else leaf.size
            if int(place) >= size:
                wrong.append(f"{path}: {f'the last one is {name}[{size - 1}]' if size else 'is a single value'}")
                continue
            leaf = LeafKind(leaf.quantity)
        refusals = _refusals(str(path), value, leaf)
        wrong += refusals
        if place is not None:
            changes.setdefault(name, list(now(name)))[int(place)] = value
        elif not refusals:
            changes[name] = list(value) if leaf.size else value
    return changes, wrong


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
        if not _is_list(value) or (len(value) != leaf.size and not leaf.resizes) or len(value) == 0:
            return [f"{path} = {briefly(value)}: must be {'a list of' if leaf.resizes else leaf.size} numbers"]
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


def of_kind(value: Any, before: Any) -> Any:
    """A value as what stood there before it: a float, a switch, or a tuple of floats."""
    return tuple(map(float, value)) if isinstance(before, tuple) else type(before)(value)
