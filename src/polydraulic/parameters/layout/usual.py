"""What is usual for machines of this class: values outside are possible, but more often a wrong unit or a slipped digit."""

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

from polydraulic.display import amount, readable
from polydraulic.parameters.layout.chassis import Chassis
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import SwingMotor


class Usual(NamedTuple):
    """Range in SI in which nearly all machines lie, from a mini excavator to a large mining shovel."""

    low: float
    high: float
    unit: str


LENGTH = Usual(0.0, 15.0, "m")
MASS = Usual(1.0, 60_000.0, "kg")
FLOW = Usual(5e-5, 2e-2, "m3/s")
RELIEF = Usual(5e6, 5e7, "Pa")
RETURN = Usual(0.0, 3e6, "Pa")
BORE = Usual(0.02, 0.5, "m")
TRAVEL = Usual(1e-3, 4e-2, "m")
TIME_CONSTANT = Usual(5e-3, 1.0, "s")
DEAD_TIME = Usual(0.0, 0.5, "s")
COMPLIANCE = Usual(1e-14, 1e-9, "m3/Pa")
DISPLACEMENT = Usual(1e-5, 5e-2, "m3/rad")
FULL_LEVER = Usual(0.1, 40.0, "V")
GYRATION = Usual(0.05, 15.0, "m")
CONDUCTANCE = Usual(0.0, 1e-4, "m3/s/Pa^0.5")
OPENING = Usual(0.0, 1e6, "Pa")
HYSTERESIS = Usual(0.0, 2e-3, "m")
BACKLASH = Usual(0.0, 0.03, "rad")
SLIDE_BACKLASH = Usual(0.0, 0.01, "m")
SPRING_RATE = Usual(1e3, 5e5, "N/m")
DENSITY = Usual(750.0, 1200.0, "kg/m3")
CHASSIS = Usual(100.0, 500_000.0, "kg")
STANCE = Usual(0.5, 12.0, "m")
SLOPE = Usual(0.0, 0.35, "rad")
GRAVITY = Usual(9.7, 9.9, "m/s2")


def unusual(machine: LayoutMachine) -> list[str]:
    """Say which values of a machine are far from usual: path, value, and what is usual; an empty list if none is."""
    far = [
        f"{path} = {_said(value, usual)}: usual is {_said(usual.low, usual)} to {_said(usual.high, usual)}; "
        "check the unit and the digits"
        for path, value, usual in _values(machine)
        if not usual.low <= abs(value) <= usual.high
    ]
    return far + [line for f in machine.functions for line in _wrong_ways(f)]


def _said(value: float, usual: Usual) -> str:
    """A value as it is shown; lengths of links in metres, since nobody reads thousands of kilometres in mm."""
    return f"{readable(value)} m" if usual.unit == "m" and usual.high >= 1.0 else amount(value, usual.unit)


def _wrong_ways(f: MachineFunction) -> Iterator[str]:
    """Which orifices of a valve close where those of nearly all valves open, or the other way round."""
    for name in ("inlet", "bypass", "outlet_positive", "outlet_negative"):
        way, usual, sign = ("rises", "falls", -1.0) if name == "bypass" else ("falls", "rises", 1.0)
        areas = getattr(f.valve, name)
        at = next((k for k in range(1, len(areas)) if sign * (areas[k] - areas[k - 1]) < 0.0), None)
        if at is not None:
            yield (
                f"functions.{f.name}.valve.{name} {way} with travel at {amount(f.valve.knots[at], 'm')}: usual is that it {usual}; "
                "check the order of the numbers"
            )


def _values(machine: LayoutMachine) -> Iterator[tuple[str, float, Usual]]:
    yield "gravity", machine.gravity, GRAVITY
    yield "tank.return_pressure", machine.tank.return_pressure, RETURN
    for link in machine.links:
        where = f"links.{link.name}"
        if link.mass > 0.0:
            yield f"{where}.mass", link.mass, MASS
            for key, inertia in link.inertia.items():
                if len(set(key)) == 1 and inertia > 0.0:
                    yield f"{where}.inertia.{key}: radius of gyration", sqrt(inertia / link.mass), GYRATION
        for key, point in (("at", link.at), ("cg", link.cg)):
            for c, value in point.items():
                yield f"{where}.{key}.{c}", value, LENGTH
    for f in machine.functions:
        where = f"functions.{f.name}"
        yield f"{where}.pilot.gain: voltage of full travel", f.valve.knots[-1] / f.pilot.gain, FULL_LEVER
        yield f"{where}.pilot.time_constant", f.pilot.time_constant, TIME_CONSTANT
        yield f"{where}.pilot.dead_time", f.pilot.dead_time, DEAD_TIME
        yield f"{where}.valve.knots", f.valve.knots[-1], TRAVEL
        yield f"{where}.line.relief", f.line.relief, RELIEF
        yield f"{where}.line.compliance_a", f.line.compliance_a, COMPLIANCE
        yield f"{where}.line.compliance_b", f.line.compliance_b, COMPLIANCE
        yield from _effects(f, where, machine.link(f.moves).joint == "prismatic")
        if isinstance(f.drive, SwingMotor):
            yield (
                f"{where}.motor: displacement times gear ratio",
                f.drive.displacement * f.drive.gear_ratio,
                DISPLACEMENT,
            )
        else:
            yield f"{where}.cylinder.bore", f.drive.bore, BORE
        for points in (f.pins._asdict() if f.pins is not None else {}).items():
            for c, value in points[1].items():
                yield f"{where}.{points[0]}.{c}", value, LENGTH
    for circuit in machine.circuits:
        where = circuit.pump_path
        yield f"{where}.flow", circuit.pump.flow, FLOW
        yield f"{where}.relief", circuit.pump.relief, RELIEF
    for crossover in machine.crossovers:
        where = f"circuits.{crossover.name}.crossover"
        yield f"{where}.conductance", max(crossover.valve.conductance), CONDUCTANCE
        yield f"{where}.opening_pressure", crossover.valve.opening_pressure, OPENING

    if machine.chassis is not None:
        yield from _chassis(machine.chassis)


def _chassis(chassis: Chassis) -> Iterator[tuple[str, float, Usual]]:
    yield "chassis.mass", chassis.mass, CHASSIS
    places = {"cg": chassis.cg, "tracks.at": chassis.middle}
    places |= {f"contacts.{name}": point for name, point in chassis.contacts.items()}
    for where, point in places.items():
        for c, value in point.items():
            yield f"chassis.{where}.{c}", value, LENGTH
    for key, value in (chassis.tracks._asdict() if chassis.tracks is not None else {}).items():
        yield f"chassis.tracks.{key}", value, STANCE
    for key, value in (chassis.slope._asdict() if chassis.slope is not None else {}).items():
        yield f"chassis.slope.{key}", value, SLOPE


def _effects(f: MachineFunction, where: str, slides: bool) -> Iterator[tuple[str, float, Usual]]:
    of = f.effects
    if of.backlash is not None:
        yield f"{where}.backlash", of.backlash, SLIDE_BACKLASH if slides else BACKLASH
    if of.hysteresis is not None:
        yield f"{where}.valve.hysteresis", of.hysteresis, HYSTERESIS
    if of.flow_force is not None:
        yield f"{where}.valve.flow_force.spring_rate", of.flow_force.spring_rate, SPRING_RATE
        yield f"{where}.valve.flow_force.density", of.flow_force.density, DENSITY
