"""A machine file with links, functions and circuits -> LayoutMachine: all that is wrong in it, in one message."""

from collections.abc import Mapping
from math import inf
from pathlib import Path
from typing import Any

from polydraulic.errors import InputError
from polydraulic.parameters.entries import read_quantity
from polydraulic.parameters.layout.chassis import read_chassis
from polydraulic.parameters.layout.conditions import broken_layout, unequal_tables
from polydraulic.parameters.layout.effects import read_effects
from polydraulic.parameters.layout.names import name_trouble
from polydraulic.parameters.layout.parts import (
    AXES,
    CONDUCTANCE,
    COORDINATES,
    GRAVITY,
    GROUND,
    JOINTS,
    MASS,
    MOMENT,
    MOMENTS,
    MOST_FUNCTIONS,
    MOST_IN_SERIES,
    MOST_LINKS,
    OPENING,
    POINT,
    ROLES,
    TRAVEL,
    Crossover,
    CrossoverValve,
    CylinderSize,
    FourBar,
    LinkParameters,
    MachineFunction,
    Pins,
    Point,
    PumpParameters,
    Seen,
    SlideFriction,
    SlideInitial,
    SlideStops,
    SupplyCircuit,
    ValveCurves,
)
from polydraulic.parameters.layout.reader import Reader
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import Friction, Initial, Line, Pilot, Stops, SwingMotor, Tank

CIRCUIT_KINDS = {
    "series": "1 to 6 valves in series: what passes a valve's bypass reaches the next one, the first has priority",
    "crossover": "two pumps: the giving one feeds 1 or 2 valves in series, the taking one 2, and through an orifice and a check valve "
    "the giving one feeds the last of these as well",
}
_SECTIONS = ("title", "gravity", "tank", "links", "functions", "circuits", "tip", "chassis")
_LINK = ("parent", "joint", "axis", "at", "mass", "cg", "inertia")
_ACTUATORS = {"motor": SwingMotor, "cylinder": CylinderSize, "four_bar": CylinderSize, "ram": CylinderSize}
_HELD: dict[str, tuple[str, ...]] = {"cylinder": ("base", "rod_pin"), "four_bar": ("base", "hinge", "knee", "pin")}
_PARTS = ("pilot", "valve", "line", "friction", "stops", "initial")
_CURVES = ("inlet", "bypass", "outlet_positive", "outlet_negative")


def build_layout(data: Mapping[str, Any], path: Path) -> LayoutMachine:
    """Machine of the tables of a file.

    Parameters
    ----------
    data : mapping
        What the TOML file holds.
    path : Path
        For messages.

    Raises
    ------
    InputError
        Everything that is wrong in the file, a line each: key, value in the unit of the file, what is allowed.
    """
    reader = Reader(path)
    top = reader.table(data, _SECTIONS, _SECTIONS[:-1], "")
    reader.require(isinstance(top.get("title", ""), str), f"title = {top.get('title')!r}: must be a string")
    gravity = reader.tried(
        lambda: read_quantity(top["gravity"], GRAVITY, "gravity", path) if "gravity" in top else 0.0,
        0.0,
    )
    tank = reader.part(Tank, top, "tank", "")
    links = _ordered([_link(reader, name, item) for name, item in _named(reader, top, "links", MOST_LINKS)], reader)
    functions = _functions(reader, top, links)
    circuits, crossovers = _circuits(reader, top)
    tip, chassis = _tip(reader, top, links), read_chassis(reader, top)
    if not reader.wrong and tank is not None:
        machine = LayoutMachine(str(top["title"]), gravity, tank, links, functions, circuits, tip, crossovers, chassis)
        reader.wrong += broken_layout(machine)
    if reader.wrong or tank is None:
        lines = list(dict.fromkeys(reader.wrong))
        raise InputError(f"{path}: " + (lines[0] if len(lines) == 1 else "\n  ".join(["what is wrong:", *lines])))
    return machine


def _named(reader: Reader, top: Mapping[str, Any], key: str, most: int) -> list[tuple[str, Mapping[str, Any]]]:
    """Tables below a section with the names that they have."""
    section = top.get(key, {})
    if not reader.require(isinstance(section, Mapping), f"{key} = {section!r}: must hold tables [{key}.NAME]"):
        return []
    if key in top:
        reader.require(0 < len(section) <= most, f"{key}: {len(section)} of them; must be 1 to {most}")
    found = []
    for name, item in section.items():
        trouble = name_trouble(name)
        usable = reader.require(not trouble, f"{key}.{name}: the name {name!r} {trouble}")
        usable = reader.require(isinstance(item, Mapping), f"{key}.{name} = {item!r}: must be a table") and usable
        if usable:
            found.append((name, item))
    folded = [name.lower() for name, _ in found]
    for name in dict.fromkeys(name for name in folded if folded.count(name) > 1):
        reader.require(False, f"{key}: the name {name!r} appears twice, but for upper and lower case")
    return found


def _link(reader: Reader, name: str, item: Mapping[str, Any]) -> LinkParameters:
    where = f"links.{name}"
    data = reader.table(item, _LINK, ("parent", "joint", "axis", "mass", "cg"), where)
    parent = data.get("parent", GROUND)
    return LinkParameters(
        name,
        str(parent),
        reader.word(data, "joint", JOINTS, where),
        reader.word(data, "axis", AXES, where),
        reader.components(data, "at", COORDINATES, POINT, where),
        reader.number(data, "mass", MASS, where),
        reader.components(data, "cg", COORDINATES, POINT, where),
        reader.components(data, "inertia", MOMENTS, MOMENT, where),
    )


def _ordered(links: list[LinkParameters], reader: Reader) -> tuple[LinkParameters, ...]:
    """Links with parents first, otherwise as in the file; those whose parent cannot be found, and loops, are named and stand last."""
    done: list[LinkParameters] = []
    known = {GROUND}
    waiting = list(links)
    for _ in links:
        ready = next((link for link in waiting if link.parent in known), None)
        if ready is None:
            break
        waiting.remove(ready)
        done.append(ready)
        known.add(ready.name)
    above = {link.name: link.parent for link in links}
    for link in waiting:
        where = f"links.{link.name}.parent = {link.parent!r}"
        if link.parent not in above:
            allowed = [GROUND, *(name for name in above if name != link.name)]
            reader.require(False, f"{where}: must be one of {allowed}")
            continue
        chain = [link.name]
        while (parent := above[chain[-1]]) in above and parent not in chain:
            chain.append(parent)
        if parent == link.name:  # what only hangs on a loop, or on a link without a parent, is good itself
            what = f"{', '.join(chain)} form a loop" if len(chain) > 1 else "a link is not its own parent"
            reader.require(False, f"{where}: {what}; {GROUND!r} must be above every link")
    return (*done, *waiting)


def _functions(
    reader: Reader, top: Mapping[str, Any], links: tuple[LinkParameters, ...]
) -> tuple[MachineFunction, ...]:
    found = [_function(reader, name, item, links) for name, item in _named(reader, top, "functions", MOST_FUNCTIONS)]
    order = {link.name: place for place, link in enumerate(links)}
    moved = [f.moves for f in found if f is not None]
    for link in links:
        count = moved.count(link.name)
        if moved and count != 1 and None not in found:
            what = "is moved by no function" if not count else f"is moved by {count} functions"
            reader.require(
                False, f"links.{link.name}: {what}; each link needs one, [functions.NAME] with moves = {link.name!r}"
            )
    return tuple(sorted((f for f in found if f is not None), key=lambda f: order[f.moves]))


def _function(
    reader: Reader, name: str, item: Mapping[str, Any], links: tuple[LinkParameters, ...]
) -> MachineFunction | None:
    where, before = f"functions.{name}", len(reader.wrong)
    actuator = reader.word(item, "actuator", tuple(_ACTUATORS), where)
    actuator = actuator if item.get("actuator") == actuator else _meant(item)
    drive_key = "motor" if actuator == "motor" else "cylinder"
    needed = ("moves", "actuator", drive_key, *_PARTS, *_HELD.get(actuator, ()))
    data = reader.table(item, (*needed, "backlash", "role", "seen"), needed, where)
    names = [link.name for link in links]
    moves = reader.word(data, "moves", names, where)
    slides = any(link.name == moves and link.joint == "prismatic" for link in links)
    if names and "moves" in data:
        fits = (actuator in ("ram", "motor")) if slides else (actuator != "ram")
        joint = "prismatic" if slides else "revolute"
        reader.require(fits, f"{where}.actuator = {actuator!r}: cannot move {moves}, whose joint is {joint}")
    pins = {key: reader.components(data, key, COORDINATES, POINT, where) for key in _HELD.get(actuator, ())}
    drive = reader.part(_ACTUATORS[actuator], data, drive_key, where)
    pilot, line = reader.part(Pilot, data, "pilot", where), reader.part(Line, data, "line", where)
    valve = _valve(reader, data, where)
    friction = reader.part(SlideFriction if slides else Friction, data, "friction", where, ("sticks",))
    stops = reader.part(SlideStops if slides else Stops, data, "stops", where)
    initial = reader.part(SlideInitial if slides else Initial, data, "initial", where)
    effects, seen = read_effects(reader, data, where, slides), _seen(reader, data, f"{where}.seen")
    role = reader.word(data, "role", ROLES, where) if "role" in data else name if name in ROLES else ""
    if len(reader.wrong) > before or not links or None in (drive, pilot, line, valve, friction, stops, initial):
        return None
    return MachineFunction(  # a prismatic joint's numbers go by the same names
        name, moves, actuator, drive, _pins(actuator, pins), pilot, valve, line,  # type: ignore[arg-type]
        Friction(*friction), Stops(*stops), Initial(*initial), effects, role, seen,  # type: ignore[misc]
    )  # fmt: skip


def _meant(item: Mapping[str, Any]) -> str:
    """The actuator whose tables a function has, where it names none: what else is wrong of it is said as of that one."""
    marks = {"hinge": "four_bar", "base": "cylinder", "cylinder": "ram"}
    return next((actuator for mark, actuator in marks.items() if mark in item), "motor")


def _pins(actuator: str, pins: dict[str, Point]) -> Pins | FourBar | None:
    if actuator == "cylinder":
        return Pins(pins["base"], pins["rod_pin"])
    return FourBar(**pins) if actuator == "four_bar" else None


def _valve(reader: Reader, data: Mapping[str, Any], where: str) -> ValveCurves | None:
    where, before = f"{where}.valve", len(reader.wrong)
    if "valve" not in data:
        return None
    needed = ("knots", *_CURVES)
    found = reader.table(data["valve"], (*needed, "hysteresis", "flow_force"), needed, where)
    knots = reader.numbers(found, "knots", TRAVEL, where)
    curves = [reader.numbers(found, key, CONDUCTANCE, where) for key in _CURVES]
    if len(reader.wrong) > before:
        return None
    reader.wrong += unequal_tables(where, {"knots": knots, **dict(zip(_CURVES, curves, strict=True))})
    return ValveCurves(knots, *curves) if len(reader.wrong) == before else None


def _seen(reader: Reader, data: Mapping[str, Any], where: str) -> Seen | None:
    if "seen" not in data:
        return None
    before, found = len(reader.wrong), reader.table(data["seen"], ("travel", "pressure"), ("travel",), where)
    travel = reader.number(found, "travel", TRAVEL, where)
    pressure = reader.number(found, "pressure", OPENING, where) if "pressure" in found else inf
    return Seen(travel, pressure) if len(reader.wrong) == before else None


def _circuits(reader: Reader, top: Mapping[str, Any]) -> tuple[tuple[SupplyCircuit, ...], tuple[Crossover, ...]]:
    found: list[SupplyCircuit] = []
    crossovers = []
    names = list(top["functions"]) if isinstance(top.get("functions"), Mapping) else []
    for name, item in _named(reader, top, "circuits", MOST_FUNCTIONS):
        where = f"circuits.{name}"
        kind = reader.word(item, "kind", tuple(CIRCUIT_KINDS), where)
        joined = kind == "crossover"
        keys = ("kind", "functions", *(("giving", "taking", "crossover") if joined else ("pump",)))
        data = reader.table(item, keys, keys, where)
        fed = data.get("functions", [])
        good = isinstance(fed, list) and all(isinstance(f, str) for f in fed)
        few, many = (3, 4) if joined else (1, MOST_IN_SERIES)
        good = reader.require(good and few <= len(fed) <= many,
            f"{where}.functions = {fed!r}: must be a list of {few} to {many} names of functions") and good  # fmt: skip
        for f in fed if good else []:
            reader.require(f in names or not names, f"{where}.functions: {f!r} is not a function; there are {names}")
        pumps = [
            reader.part(PumpParameters, data, key, where) for key in (("giving", "taking") if joined else ("pump",))
        ]
        valve = _crossover(reader, data, where) if joined else None
        if not good or None in pumps or (joined and valve is None):
            continue
        if valve is not None:
            called = f"{name}_giving", f"{name}_taking"
            crossovers.append(Crossover(name, *called, valve))
            parts = [(called[0], fed[:-2], pumps[0]), (called[1], fed[-2:], pumps[1])]
        else:
            parts = [(name, fed, pumps[0])]
        found += [SupplyCircuit(part, kind, tuple(of), pump) for part, of, pump in parts]  # type: ignore[arg-type]
    called_twice = [c.name for c in found]
    for name in dict.fromkeys(name for name in called_twice if called_twice.count(name) > 1):
        reader.require(
            False, f"circuits: {name!r} is what a pump of a circuit with crossover is called; rename one of both"
        )
    fed_at = [f for circuit in found for f in circuit.functions]
    for name in names:
        count = fed_at.count(name)
        what = "appears in no circuit" if not count else f"appears {count} times in the circuits"
        reader.require(count == 1 or not found, f"functions.{name}: {what}; it must appear once")
    return tuple(found), tuple(crossovers)


def _crossover(reader: Reader, data: Mapping[str, Any], where: str) -> CrossoverValve | None:
    where, before, keys = f"{where}.crossover", len(reader.wrong), ("conductance", "opening_pressure")
    found = reader.table(data.get("crossover", {}), keys, keys if "crossover" in data else (), where)
    curve = reader.numbers(found, "conductance", CONDUCTANCE, where)
    opening = reader.number(found, "opening_pressure", OPENING, where)
    return CrossoverValve(curve, opening) if curve and len(reader.wrong) == before else None


def _tip(reader: Reader, top: Mapping[str, Any], links: tuple[LinkParameters, ...]) -> tuple[str, Point]:
    data = reader.table(top.get("tip", {}), ("link", "at"), ("link", "at"), "tip")
    link = reader.word(data, "link", [link.name for link in links], "tip")
    return link, reader.components(data, "at", COORDINATES, POINT, "tip")
