"""A machine file of the older form, three links on two pumps, as one that describes links, functions and circuits.

`older_form.toml` says what stands where. What is wrong in such a file is said in its own words: every path of a message is put back.
"""

import re
import tomllib
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from importlib.resources import files
from math import cos, radians, sin
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.parameters.entries import read_quantity
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.layout.load import build_layout
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.quantity import Quantity

_POLAR = ("r", "from", "angle", "sign")
_LENGTH = Quantity("m", above=0.0)


def build_older(data: Mapping[str, Any], path: Path) -> LayoutMachine:
    """Machine of the tables of a file of the older form; the numbers have the same bits in SI.

    Parameters
    ----------
    data : mapping
        What the TOML file holds.
    path : Path
        For messages; the machine is called by its name.

    Raises
    ------
    InputError
        An unknown or missing key, alone, or everything else that is wrong: keys and units are those of the file.
    """
    template = _template()
    places = dict(_places(template, ""))
    _check_tables(data, list(places.values()), path)
    edges = {key: _taken(entry, data, path) for key, entry in template["edges"].items()}
    parts = {key: _taken(part, data, path) for key, part in template.items() if key != "edges"}
    try:
        machine = build_layout({"title": path.stem, **parts}, path)
    except InputError as error:
        raise InputError(_in_older_words(str(error), places)) from None
    wrong = _broken_edges(machine, **{key: read_quantity(e, _LENGTH, f"spool.{key}", path) for key, e in edges.items()})
    if wrong:
        raise InputError(f"{path}: " + "; ".join(wrong))
    return machine


def is_older(data: Collection[str]) -> bool:
    """Whether a parameter file has any table of the older form."""
    return any(place.partition(".")[0] in data for _, place in _places(_template(), ""))


@cache
def _template() -> dict[str, Any]:
    text = (files(__package__) / "older_form.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def _places(node: Any, where: str) -> Iterator[tuple[str, str]]:
    """Paths in the layout form, each with the path in the older form that its number comes from."""
    if isinstance(node, str) and node.startswith("@"):
        yield where, node[1:]
    elif isinstance(node, dict):
        for key, part in node.items():
            yield from _places(part, f"{where}.{key}".lstrip("."))


def _check_tables(data: Mapping[str, Any], known: list[str], path: Path, where: str = "") -> None:
    """Check the keys of all tables above the parts that are taken whole."""
    keys: dict[str, list[str]] = {name.split(".")[0]: [] for name in known}
    for name in known:
        first, _, rest = name.partition(".")
        keys[first] += [rest] if rest else []
    check_keys(data, keys, keys, where.rstrip("."), str(path))
    for key, below in keys.items():
        if below:
            _check_tables(data[key], below, path, f"{where}{key}.")


def _taken(node: Any, data: Mapping[str, Any], path: Path) -> Any:
    """A part of the template with what the file has at the places that it names."""
    if isinstance(node, str) and node.startswith("@"):
        found: Any = data
        for key in node[1:].split("."):
            found = found[key]
        return found
    if not isinstance(node, dict):
        return node
    parts = {key: _taken(part, data, path) for key, part in node.items() if key not in _POLAR}
    return parts if "r" not in node else parts | _from_polar(node, data, path)


def _from_polar(node: Mapping[str, Any], data: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Coordinates x and z of a point that is given by length and angle, from the one that `node` gives besides."""

    def read(key: str, quantity: Quantity) -> float:
        return (
            float(read_quantity(_taken(node[key], data, path), quantity, node[key][1:], path)) if key in node else 0.0
        )

    x, r = read("x", Quantity("m")), read("r", _LENGTH)
    angle = radians(node.get("from", 0)) + node.get("sign", 0) * read("angle", Quantity("rad"))
    values = {"x": x + r * cos(angle), "z": r * sin(angle)}
    return {key: {"value": value, "unit": "m", "source": node["r"][1:]} for key, value in values.items()}


def _in_older_words(message: str, places: Mapping[str, str]) -> str:
    """A message with the paths of the file in place of those of the layout form."""
    words = dict(places)
    for name in {place.split(".")[1] for place in places if place.startswith("functions.")}:
        words |= {f"functions.{name}.{part}": f"{name}.cylinder" for part in ("base", "rod_pin")}
        words |= {f"functions.{name}.valve": f"{name}.valve", f"functions.{name}.cylinder": f"{name}.cylinder"}
        words |= {f"functions.{name}": name, f"links.{name}": f"{name}.body"}
    for place in sorted(words, key=len, reverse=True):
        message = re.sub(rf"(?<![\w.]){re.escape(place)}(?!\w)", words[place], message)
    return "\n  ".join(dict.fromkeys(message.split("\n  ")))


def _broken_edges(machine: LayoutMachine, deadband: float, bypass_closed: float) -> list[str]:
    """Say where valves do not open and close at the travels that the file gives for all of them."""
    broken = []
    knots = machine.functions[0].valve.knots
    for key, value in (("deadband", deadband), ("bypass_closed", bypass_closed)):
        if value not in knots:
            broken.append(f"spool.{key} = {value} m: must be one of the knots {knots}")
    if deadband >= bypass_closed:
        broken.append(f"spool.deadband = {deadband} m: must be below spool.bypass_closed")
    for f in machine.functions:
        for key in ("inlet", "outlet_positive", "outlet_negative"):
            curve = getattr(f.valve, key)
            if any(v != 0.0 for v, x in zip(curve, knots, strict=True) if x <= deadband):
                broken.append(f"{f.name}.valve.{key} = {curve}: must be 0 up to spool.deadband")
        if any(v != 0.0 for v, x in zip(f.valve.bypass, knots, strict=True) if x >= bypass_closed):
            broken.append(f"{f.name}.valve.bypass = {f.valve.bypass}: must be 0 from spool.bypass_closed on")
    return broken
