"""Every number of a machine of any layout by its path in a file: listed, and replaced by others."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar, get_type_hints

from polydraulic.errors import InputError
from polydraulic.parameters.layout.chassis import WEIGHT, Chassis
from polydraulic.parameters.layout.conditions import broken_layout, unequal_tables
from polydraulic.parameters.layout.parts import (
    CONDUCTANCE,
    GRAVITY,
    MASS,
    MOMENT,
    OPENING,
    POINT,
    TRAVEL,
    TURN,
    Crossover,
    LinkParameters,
    MachineFunction,
    Point,
    SlideFriction,
    SlideInitial,
    SlideStops,
)
from polydraulic.parameters.quantity import LeafKind, Quantity, leaf_of
from polydraulic.parameters.values import checked_values, of_kind

Layout = TypeVar("Layout", bound=Any)  # a LayoutMachine, which asks for this
Part = TypeVar("Part", bound=tuple)
Visit = Callable[[str, LeafKind, Any], Any]  # path, kind and value -> the value to put there
_SWITCH = LeafKind(None)
_TABLES = {"knots": TRAVEL} | dict.fromkeys(("inlet", "bypass", "outlet_positive", "outlet_negative"), CONDUCTANCE)


class MachineNumber(NamedTuple):
    """A number of a machine.

    Attributes
    ----------
    path : str
        Where it stands in a machine file, ``functions.boom.valve.inlet[3]``.
    value : float
        In SI.
    quantity : Quantity
        Its SI unit, and the range that it must lie in.
    """

    path: str
    value: float
    quantity: Quantity


def numbers_of(machine: Any) -> tuple[MachineNumber, ...]:
    """Every number of a `LayoutMachine`; see `LayoutMachine.numbers`."""
    found: list[MachineNumber] = []
    for path, (kind, value) in _leaves(machine).items():
        if kind.quantity is not None:
            each = [(path, value)] if not kind.size else [(f"{path}[{i}]", item) for i, item in enumerate(value)]
            found += [MachineNumber(where, item, kind.quantity) for where, item in each]
    return tuple(found)


def replaced_layout(machine: Layout, values: Mapping[str, Any]) -> Layout:
    """Return a machine with other values; see `LayoutMachine.with_values`."""
    leaves = _leaves(machine)
    known = {path: kind for path, (kind, _) in leaves.items()}
    changes, wrong = checked_values(values, known, lambda path: leaves[path][1])
    if not wrong:
        found = _visited(machine, lambda path, _, value: of_kind(changes.get(path, value), value))
        for f in found.functions:
            wrong += unequal_tables(f"functions.{f.name}.valve", f.valve._asdict())
        wrong = wrong or broken_layout(found)
    if wrong:
        raise InputError("a machine with these values cannot be made: " + "; ".join(wrong))
    return found


def _leaves(machine: Any) -> dict[str, tuple[LeafKind, Any]]:
    found: dict[str, tuple[LeafKind, Any]] = {}

    def noted(path: str, kind: LeafKind, value: Any) -> Any:
        found[path] = kind, value
        return value

    _visited(machine, noted)
    return found


def _visited(machine: Layout, visit: Visit) -> Layout:
    """The machine with what `visit` gives in place of each value; the one walk through all of them."""
    slides = {link.name: link.joint == "prismatic" for link in machine.links}
    return machine._replace(
        gravity=visit("gravity", LeafKind(GRAVITY), machine.gravity),
        tank=_part(machine.tank, "tank", visit),
        links=tuple(_link(link, f"links.{link.name}", visit) for link in machine.links),
        functions=tuple(_function(f, slides[f.moves], f"functions.{f.name}", visit) for f in machine.functions),
        circuits=tuple(c._replace(pump=_part(c.pump, c.pump_path, visit)) for c in machine.circuits),
        tip=(machine.tip[0], _named(machine.tip[1], POINT, "tip.at", visit)),
        crossovers=tuple(_crossover(x, f"circuits.{x.name}.crossover", visit) for x in machine.crossovers),
        chassis=machine.chassis if machine.chassis is None else _chassis(machine.chassis, visit),
    )


def _link(link: LinkParameters, where: str, visit: Visit) -> LinkParameters:
    return link._replace(
        at=_named(link.at, POINT, f"{where}.at", visit),
        mass=visit(f"{where}.mass", LeafKind(MASS), link.mass),
        cg=_named(link.cg, POINT, f"{where}.cg", visit),
        inertia=_named(link.inertia, MOMENT, f"{where}.inertia", visit),
    )


def _function(f: MachineFunction, slides: bool, where: str, visit: Visit) -> MachineFunction:
    pins, of = f.pins, f.effects
    if pins is not None:
        keys = [{"rod": "rod_pin"}.get(key, key) for key in pins._fields]
        points = [_named(p, POINT, f"{where}.{key}", visit) for key, p in zip(keys, pins, strict=True)]
        pins = type(pins)(*points)
    tables = {
        key: visit(
            f"{where}.valve.{key}", LeafKind(quantity, len(getattr(f.valve, key)), resizes=True), getattr(f.valve, key)
        )
        for key, quantity in _TABLES.items()
    }
    sticks = visit(f"{where}.friction.sticks", _SWITCH, of.sticks)
    play, lag, force = of.backlash, of.hysteresis, of.flow_force
    return f._replace(
        drive=_part(f.drive, f"{where}.{'motor' if f.actuator == 'motor' else 'cylinder'}", visit),
        pins=pins,
        pilot=_part(f.pilot, f"{where}.pilot", visit),
        valve=f.valve._replace(**tables),
        line=_part(f.line, f"{where}.line", visit),
        friction=_part(f.friction, f"{where}.friction", visit, SlideFriction if slides else None),
        stops=_part(f.stops, f"{where}.stops", visit, SlideStops if slides else None),
        initial=_part(f.initial, f"{where}.initial", visit, SlideInitial if slides else None),
        effects=of._replace(
            sticks=sticks,
            backlash=play if play is None else visit(f"{where}.backlash", LeafKind(TRAVEL if slides else TURN), play),
            hysteresis=lag if lag is None else visit(f"{where}.valve.hysteresis", LeafKind(TRAVEL), lag),
            flow_force=force if force is None else _part(force, f"{where}.valve.flow_force", visit),
        ),
    )


def _chassis(chassis: Chassis, visit: Visit) -> Chassis:
    tracks, where = chassis.tracks, "chassis.tracks"
    return chassis._replace(
        mass=visit("chassis.mass", LeafKind(WEIGHT), chassis.mass),
        cg=_named(chassis.cg, POINT, "chassis.cg", visit),
        tracks=tracks if tracks is None else _part(tracks, where, visit),
        middle=_named(chassis.middle, POINT, f"{where}.at", visit),
        contacts={
            name: _named(point, POINT, f"chassis.contacts.{name}", visit) for name, point in chassis.contacts.items()
        },
        slope=chassis.slope if chassis.slope is None else _part(chassis.slope, "chassis.slope", visit),
    )


def _crossover(x: Crossover, where: str, visit: Visit) -> Crossover:
    curve = x.valve.conductance
    return x._replace(
        valve=x.valve._replace(
            conductance=visit(f"{where}.conductance", LeafKind(CONDUCTANCE, len(curve), resizes=True), curve),
            opening_pressure=visit(f"{where}.opening_pressure", LeafKind(OPENING), x.valve.opening_pressure),
        )
    )


def _part(part: Part, where: str, visit: Visit, called: type | None = None) -> Part:
    """A named tuple of quantities and switches; `called` is another one that has the names and units of a file."""
    hints = get_type_hints(called or type(part), include_extras=True)
    kinds = [(key, leaf_of(hint) or _SWITCH) for key, hint in hints.items()]
    return type(part)(*(visit(f"{where}.{key}", kind, value) for (key, kind), value in zip(kinds, part, strict=True)))


def _named(values: Point, quantity: Quantity, where: str, visit: Visit) -> dict[str, float]:
    return {key: visit(f"{where}.{key}", LeafKind(quantity), value) for key, value in values.items()}
