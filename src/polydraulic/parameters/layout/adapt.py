"""A machine of any layout with what a scenario changes: pilots and initial states of its functions."""

from typing import Any

from polydraulic.errors import InputError
from polydraulic.parameters.entries import build
from polydraulic.parameters.keys import check_keys
from polydraulic.parameters.layout.conditions import broken_layout
from polydraulic.parameters.layout.parts import MachineFunction, SlideInitial
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Initial


def adapted(machine: LayoutMachine, scenario: Scenario) -> LayoutMachine:
    """Return the machine with a scenario's pilots and initial state.

    Raises
    ------
    InputError
        A function that the machine does not have, or values that it cannot have.
    """
    check_keys(scenario.changes, machine.names, (), "change", str(scenario.path))
    changed = tuple(_changed(f, machine, scenario) for f in machine.functions)
    found = machine._replace(functions=changed)
    broken = broken_layout(found) if scenario.changes else []
    if broken:
        raise InputError(f"{scenario.path}: " + "; ".join(broken))
    return found


def _changed(f: MachineFunction, machine: LayoutMachine, scenario: Scenario) -> MachineFunction:
    parts: dict[str, Any] = scenario.changes.get(f.name, {})
    path, where = scenario.path, f"change.{f.name}"
    if "pilot" in parts:
        f = f._replace(pilot=build(type(f.pilot), parts["pilot"], where=f"{where}.pilot.", path=path, base=f.pilot))
    if "initial" in parts:
        slides = machine.link(f.moves).joint == "prismatic"
        base = SlideInitial(*f.initial) if slides else f.initial
        start = build(type(base), parts["initial"], where=f"{where}.initial.", path=path, base=base)
        f = f._replace(initial=Initial(*start))
    return f


def full_stroke(machine: LayoutMachine) -> float:
    """Voltage that drives every spool of a machine to its end, V, with a tenth to spare for hands that hold it for a short time."""
    return 1.1 * max(f.valve.knots[-1] / f.pilot.gain for f in machine.functions)


def at_full_stroke(source: str, machine: LayoutMachine) -> str:
    """A scenario's name as it is, that of a random operator with `full_stroke` where it says no voltage.

    Examples
    --------
    >>> from polydraulic import load_machine
    >>> at_full_stroke("random:1:600", load_machine("wheel_loader"))
    'random:1:600:0.88'
    """
    parts = source.split(":")
    if parts[0] != "random" or len(parts) > 3:
        return source
    return ":".join([*parts, *["60"][len(parts) - 2 :], f"{full_stroke(machine):.6g}"])
