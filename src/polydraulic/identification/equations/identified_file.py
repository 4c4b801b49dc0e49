"""A machine as the text of its file: entries in the units that they had, what was identified with its source and standard errors."""

import re
from collections.abc import Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.units import read_unit

_DIGITS = 10
# unit and source of the numbers of a flow force that no file declared
_FLOW_FORCE = {
    "spring_rate": ("N/mm", "found"),
    "density": ("kg/m3", "usual for oil; the spring rate holds for it"),
    "jet_angle": ("deg", "usual for sharp edges; the spring rate holds for it"),
}


class Identified(NamedTuple):
    """A new value of an entry.

    Attributes
    ----------
    value : float or sequence of float
        In SI.
    uncertainty : float or sequence of float
        Standard error, in SI; inf where the log does not say.
    source : str
    """

    value: float | Sequence[float]
    uncertainty: float | Sequence[float]
    source: str


def machine_data(machine: LayoutMachine) -> dict[str, Any]:
    """What a file of a machine would hold, in SI: for machines that were made without one."""
    data: dict[str, Any] = {"title": machine.title}
    entries: dict[str, tuple[Any, str]] = {}
    for number in machine.numbers:
        path, _, place = number.path.partition("[")
        if place:
            entries.setdefault(path, ([], number.quantity.unit))[0].append(number.value)
        else:
            entries[path] = (number.value, number.quantity.unit)
    for path, (value, unit) in entries.items():
        _put(data, path, {"value": value, "unit": unit, "source": "given"})
    for link in machine.links:
        own = data["links"][link.name]
        own |= {"parent": link.parent, "joint": link.joint, "axis": link.axis}
        own.setdefault("cg", {})
    for f in machine.functions:
        own = data["functions"][f.name]
        own |= {"moves": f.moves, "actuator": f.actuator} | ({"role": f.role} if f.role else {})
        if f.effects.sticks:
            own["friction"]["sticks"] = {"value": True, "source": "given"}
    for c in machine.circuits:
        if c.kind == "series":
            data["circuits"][c.name] |= {"kind": c.kind, "functions": list(c.functions)}
        limited = {"value": c.pump.torque_limit_enabled, "source": "given"}
        _put(data, f"{c.pump_path}.torque_limit_enabled", limited)
    for x in machine.crossovers:
        fed = [*machine.circuit(x.giving).functions, *machine.circuit(x.taking).functions]
        data["circuits"][x.name] |= {"kind": "crossover", "functions": fed}
    data.setdefault("tip", {})["link"] = machine.tip[0]
    return with_found(data, machine)


def with_found(data: Mapping[str, Any], machine: LayoutMachine) -> dict[str, Any]:
    """What a file holds, how far the log went that its curves were identified from, and effects as the machine has them."""
    whole = _copied(data)
    for f in machine.functions:
        valve, force = whole["functions"][f.name]["valve"], f.effects.flow_force
        if f.effects.hysteresis is not None:
            valve.setdefault("hysteresis", _entry(f.effects.hysteresis, "mm", "found"))
        if force is None:
            valve.pop("flow_force", None)
        elif "flow_force" not in valve:
            valve["flow_force"] = {key: _entry(getattr(force, key), *said) for key, said in _FLOW_FORCE.items()}
        friction = whole["functions"][f.name]["friction"]
        if f.effects.sticks != friction.get("sticks", {}).get("value", False):
            friction["sticks"] = {"value": f.effects.sticks, "source": "found"}
        for key, unit in (("travel", "mm"), ("pressure", "bar")):
            if f.seen is not None and getattr(f.seen, key) < inf:
                seen = whole["functions"][f.name].setdefault("seen", {})
                seen[key] = _entry(getattr(f.seen, key), unit, "largest one of the log")
    return whole


def _entry(value: float, unit: str, source: str) -> dict[str, Any]:
    return {"value": _short(read_unit(unit).from_si(value)), "unit": unit, "source": source}


def file_text(data: Mapping[str, Any], changes: Mapping[str, Identified], remarks: Sequence[str]) -> str:
    """Text of a machine file with other values in some entries.

    Parameters
    ----------
    data : mapping
        What the file held before, units and sources included; units are kept.
    changes : mapping from path to Identified
    remarks : sequence of str
        Comments at the top.
    """
    whole = _copied(data)
    for path, new in changes.items():
        item = _at(whole, path)
        unit = read_unit(item["unit"])
        zero = unit.to_si(0.0)
        many = not isinstance(new.value, int | float)
        values = [_short(unit.from_si(value)) for value in _listed(new.value)]
        errors = [_short(unit.from_si(error + zero)) for error in _listed(new.uncertainty)]
        entry = {"value": values if many else values[0], "unit": item["unit"], "source": new.source}
        entry["uncertainty"] = errors if many else errors[0]
        entry |= {key: item[key] for key in ("free", "spread") if key in item}
        item.clear()
        item |= entry
    head = [f"# {line}" for line in remarks]
    return "\n".join([*head, *([""] if head else []), *_table(whole, "")]) + "\n"


def _listed(values: float | Sequence[float]) -> list[float]:
    return [float(values)] if isinstance(values, int | float) else [float(value) for value in values]


def _short(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


def _copied(tree: Mapping[str, Any]) -> dict[str, Any]:
    return {key: _copied(item) if isinstance(item, Mapping) else item for key, item in tree.items()}


def _at(tree: dict[str, Any], path: str) -> dict[str, Any]:
    for key in path.split("."):
        tree = tree[key]
    return tree


def _put(tree: dict[str, Any], path: str, item: Any) -> None:
    *above, last = path.split(".")
    for key in above:
        tree = tree.setdefault(key, {})
    tree[last] = item


def _is_table(item: Any) -> bool:
    return isinstance(item, dict) and "value" not in item


def _table(tree: Mapping[str, Any], where: str) -> list[str]:
    """Lines of a table: its own keys, then the tables below it."""
    lines = [f"{_key(key)} = {_text(item)}" for key, item in tree.items() if not _is_table(item)]
    below = [(key, item) for key, item in tree.items() if _is_table(item)]
    if where and (lines or not below):
        lines = ["", f"[{where}]", *lines]
    for key, item in below:
        lines += _table(item, f"{where}.{_key(key)}" if where else _key(key))
    return lines


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _text(key)


def _text(item: Any) -> str:
    if isinstance(item, bool):
        return str(item).lower()
    if isinstance(item, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_text(value)}" for key, value in item.items()) + " }"
    if isinstance(item, list | tuple):
        return "[" + ", ".join(map(_text, item)) + "]"
    if isinstance(item, str):
        inner = "".join(
            f"\\u{ord(c):04x}" if ord(c) < 32 or ord(c) == 127 else c
            for c in item.replace("\\", "\\\\").replace('"', '\\"')
        )
        return f'"{inner}"'
    return repr(item)
