"""A machine in a few lines: what hangs where, what moves it, who is fed by whom."""

from collections.abc import Iterator
from math import pi

from polydraulic.display import amount
from polydraulic.parameters.layout.chassis import Chassis, edge_names
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.schema import SwingMotor

_THROUGH = {"cylinder": "", "four_bar": " through a four-bar linkage", "ram": " along its joint"}
_TURN = 2.0 * pi
_SHOWN_DROP = 1e6  # Pa


def described(machine: LayoutMachine) -> list[str]:
    """Lines that let a person see whether a file says what was meant: links, functions with their levers, circuits.

    Parameters
    ----------
    machine : LayoutMachine
    """
    mass = sum(link.mass for link in machine.links)
    lines = [machine.title, f"links, {amount(mass, 'kg')} in all:"]
    for link in machine.links:
        way = "about" if link.joint == "revolute" else "along"
        lines.append(f"  {link.name}: {link.joint} {way} {link.axis} on {link.parent}, {amount(link.mass, 'kg')}")
    lines.append("functions:")
    lines += [f"  {_function(f, machine)}" for f in machine.functions]
    lines.append("circuits:")
    for c in machine.circuits:
        limit = f", torque limit from {amount(c.pump.torque_limit_start, 'Pa')}" if c.pump.torque_limit_enabled else ""
        lines.append(
            f"  {c.name}: {amount(c.pump.flow, 'm3/s')}, relief {amount(c.pump.relief, 'Pa')}{limit}; feeds {', then '.join(c.functions)}"
        )
    for x in machine.crossovers:
        fed = machine.circuit(x.taking).functions[-1]
        passes, opens = (
            amount(max(x.valve.conductance) * _SHOWN_DROP**0.5, "m3/s"),
            amount(x.valve.opening_pressure, "Pa"),
        )
        lines.append(
            f"  {x.name}: crossover from {x.giving} to before {fed}, at most {passes} at {amount(_SHOWN_DROP, 'Pa')}, opens at {opens}"
        )
    if machine.chassis is not None:
        lines += ["chassis:", *(f"  {line}" for line in _chassis(machine.chassis))]
    return lines


def _chassis(chassis: Chassis) -> Iterator[str]:
    yield f"{amount(chassis.mass, 'kg')} that no joint moves"
    if chassis.tracks is not None:
        yield f"tracks of {amount(chassis.tracks.length, 'm')}, {amount(chassis.tracks.gauge, 'm')} apart"
    else:
        yield f"stands on {', '.join(chassis.contacts)}"
    yield f"tips {', '.join(edge_names(chassis))}"
    if chassis.slope is not None:
        yield f"on ground that rises by {amount(chassis.slope.pitch, 'rad')} along x and {amount(chassis.slope.roll, 'rad')} along y"


def _function(f: MachineFunction, machine: LayoutMachine) -> str:
    link = machine.link(f.moves)
    slides = link.joint == "prismatic"
    unit = "m" if slides else "rad"
    text = f"{f.name}: {_actuator(f)} on {f.moves}"
    if slides or f.stops.high - f.stops.low < _TURN:
        text += f", {amount(f.stops.low, unit)} to {amount(f.stops.high, unit)}"
    if f.pins is not None:
        middle = 0.5 * (f.stops.low + f.stops.high)
        arms = [abs(lever(f, link, angle) or 0.0) for angle in (f.stops.low, middle, f.stops.high)]
        text += f", lever arm {', '.join(amount(arm, 'm') for arm in arms)} (low, middle, high)"
    if f.effects.declared:
        text += f"; with {', '.join(f.effects.declared)}"
    return text


def _actuator(f: MachineFunction) -> str:
    if isinstance(f.drive, SwingMotor):
        return "a motor"
    cylinders = "a cylinder" if f.drive.number == 1.0 else f"{f.drive.number:.0f} cylinders"
    return cylinders + _THROUGH[f.actuator]
