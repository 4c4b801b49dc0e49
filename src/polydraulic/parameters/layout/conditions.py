"""Conditions between several numbers of a machine of any layout."""

import itertools
from collections.abc import Mapping, Sequence
from math import pi
from typing import Any

from polydraulic import display
from polydraulic.parameters.layout.chassis import broken_chassis
from polydraulic.parameters.layout.geometry import is_plane, lever
from polydraulic.parameters.layout.parts import FEWEST_KNOTS, MOST_KNOTS, FourBar, LinkParameters, MachineFunction

_ANGLES = 65  # over the range of a joint, for what must hold everywhere in it


def broken_layout(machine: Any) -> list[str]:
    """Say which conditions a `LayoutMachine` does not meet; each number by itself lies in its range."""
    broken: list[str] = []
    for link in machine.links:
        broken += _inertia(link)
    for function in machine.functions:
        broken += _function(function, machine.link(function.moves), machine)
    for circuit in machine.circuits:
        pump, where = circuit.pump, circuit.pump_path
        if pump.relief <= machine.tank.return_pressure:
            broken.append(
                f"{where}.relief = {_bar(pump.relief)}: must be above tank.return_pressure = {_bar(machine.tank.return_pressure)}"
            )
    for x in machine.crossovers:
        fed = machine.function(machine.circuit(x.taking).functions[-1])
        if len(x.valve.conductance) != len(fed.valve.knots):
            broken.append(
                f"circuits.{x.name}.crossover.conductance: {len(x.valve.conductance)} numbers for the {len(fed.valve.knots)} "
                f"knots of functions.{fed.name}.valve, whose spool opens it; must be as many"
            )
    broken += broken_chassis(machine.chassis)
    if not any(link.mass > 0.0 for link in machine.links):
        broken.append("links: all masses are 0; give at least the last link of each arm a mass")
    return broken


def unequal_tables(where: str, tables: Mapping[str, Sequence[float]]) -> list[str]:
    """Say which tables of a valve have not one number for each of a possible number of knots.

    Parameters
    ----------
    where : str
        Path of the valve.
    tables : mapping
        The knots first, under ``knots``, then all that is given at them.
    """
    count = len(tables["knots"])
    broken = []
    if not FEWEST_KNOTS <= count <= MOST_KNOTS:
        broken.append(f"{where}.knots: {count} numbers; must be {FEWEST_KNOTS} to {MOST_KNOTS}")
    for key, values in tables.items():
        if len(values) != count:
            broken.append(f"{where}.{key}: {len(values)} numbers for {count} knots; must be as many")
    return broken


def _bar(pressure: float) -> str:
    return display.amount(pressure, "Pa")


def _inertia(link: LinkParameters) -> list[str]:
    i, where = link.inertia, f"links.{link.name}"
    xx, yy, zz, xy, xz, yz = (i.get(key, 0.0) for key in ("xx", "yy", "zz", "xy", "xz", "yz"))
    bad = [key for key, value in (("xx", xx), ("yy", yy), ("zz", zz)) if value < 0.0]
    if bad:
        return [f"{where}.inertia.{bad[0]} = {i[bad[0]]:g} kg m2: must not be negative"]
    slack = 1e-9 * (xx + yy + zz)
    if any(a > b + c + slack for a, b, c in ((xx, yy, zz), (yy, zz, xx), (zz, xx, yy))) and len(i) >= 3:
        return [
            f"{where}.inertia: xx, yy, zz = {xx:g}, {yy:g}, {zz:g} kg m2: no body has one above the sum of the others"
        ]
    minors = (xx * yy - xy * xy, xx * zz - xz * xz, yy * zz - yz * yz)
    if (xy or xz or yz) and min(minors) < -slack * slack:
        return [f"{where}.inertia: the products xy, xz, yz are too large for xx, yy, zz"]
    return []


def _function(f: MachineFunction, link: LinkParameters, machine: Any) -> list[str]:
    where, broken = f"functions.{f.name}", []

    def require(good: bool, what: str, allowed: str) -> None:
        if not good:
            broken.append(f"{where}.{what}: must be {allowed}")

    knots, unit = f.valve.knots, "m" if link.joint == "prismatic" else "rad"
    require(
        knots[0] == 0.0 and all(a < b for a, b in itertools.pairwise(knots)),
        f"valve.knots = {knots} m",
        "rising from 0",
    )
    for key in ("inlet", "outlet_positive", "outlet_negative"):
        require(getattr(f.valve, key)[0] == 0.0, f"valve.{key}[0]", "0 at the centred spool")
    require(f.friction.static >= f.friction.coulomb, f"friction.static = {f.friction.static:g}", "at least coulomb")
    low, high = (display.amount(value, unit) for value in f.stops)
    require(f.stops.low < f.stops.high, f"stops.low = {low}", f"below stops.high = {high}")
    start, where_at = display.amount(f.initial.angle, unit), "position" if unit == "m" else "angle"
    require(
        f.stops.low <= f.initial.angle <= f.stops.high,
        f"initial.{where_at} = {start}",
        f"within the stops, {low} to {high}",
    )
    floor, relief = machine.tank.floor, f.line.relief
    require(relief > machine.tank.return_pressure, f"line.relief = {_bar(relief)}", "above tank.return_pressure")
    for key in ("p_a", "p_b"):
        value = getattr(f.initial, key)
        require(floor <= value <= relief, f"initial.{key} = {_bar(value)}", f"in [{_bar(floor)}, {_bar(relief)}]")
    play, lag = f.effects.backlash, f.effects.hysteresis
    if play is not None:
        room = f.stops.high - f.stops.low
        require(
            play < room,
            f"backlash = {display.amount(play, unit)}",
            f"below the way between the stops, {display.amount(room, unit)}",
        )
    if lag is not None:
        require(
            lag < knots[-1],
            f"valve.hysteresis = {display.amount(lag, 'm')}",
            f"below the full travel, {display.amount(knots[-1], 'm')}",
        )
    if f.actuator != "motor":
        require(f.drive.number == int(f.drive.number), f"cylinder.number = {f.drive.number:g}", "a whole number")  # type: ignore[union-attr]
        require(f.drive.rod < f.drive.bore, "cylinder.rod", "below the bore")  # type: ignore[union-attr]
    if f.pins is not None and not broken:
        broken += _levers(f, link)
    return broken


def _levers(f: MachineFunction, link: LinkParameters) -> list[str]:
    """A cylinder must keep pushing the same way all over the joint's range."""
    where = f"functions.{f.name}"
    if isinstance(f.pins, FourBar) and not is_plane(f.pins, link):
        return [f"{where}: base, hinge, knee and pin must lie in one plane across the axis {link.axis} of {link.name}"]
    if f.stops.high - f.stops.low >= 2.0 * pi:
        return [f"{where}.stops: a {f.actuator} cannot turn a link all the way round"]
    signs = set()
    for k in range(_ANGLES):
        angle = f.stops.low + (f.stops.high - f.stops.low) * k / (_ANGLES - 1)
        arm, shown = lever(f, link, angle), display.amount(angle, "rad")
        if arm is None:
            return [
                f"{where}: rocker and coupler do not reach each other at {shown}; check base, hinge, knee, pin and stops"
            ]
        if abs(arm) < 1e-3:
            return [
                f"{where}: the lever arm is {display.amount(arm, 'm')} at {shown}, so that the cylinder cannot move the link; check pins and stops"
            ]
        signs.add(arm > 0.0)
    return [] if len(signs) == 1 else [f"{where}: the linkage turns over between the stops; check pins and stops"]
