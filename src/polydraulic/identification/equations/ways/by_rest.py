"""Whether dry friction holds joints, from what they carry at rest; free where somebody asks for it, named where it shows and the file does not say so."""

from polydraulic.display import amount
from polydraulic.errors import InputError
from polydraulic.identification.equations.free_numbers import HOLDS
from polydraulic.identification.equations.mechanics.resting import Resting, at_rest
from polydraulic.identification.equations.ways.so_far import SoFar
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine, position_column
from polydraulic.tables import Table

_SHORT = "no joint rests away from its stops long enough, or noise of its position hides that it creeps"


def find_holding(so_far: SoFar, table: Table) -> None:
    """Let joints hold that do, where that is free; say so where it is not.

    Parameters
    ----------
    so_far : SoFar
    table : Table
        The log, in SI.
    """
    machine, lacking = so_far.machine, _lacking(so_far.machine, table)
    try:
        found = {} if lacking else at_rest(machine, table)
    except InputError as error:
        found, lacking = {}, str(error)
    for f in machine.functions:
        path, rest = f"functions.{f.name}.{HOLDS}", found.get(f.name)
        if rest is None:
            if so_far.may.has(path):
                so_far.lacks[path] = lacking or _SHORT
        elif so_far.may.has(path):
            so_far.declare(f.name, sticks=rest.holds)
            (so_far.remarks if rest.holds else so_far.kept).append(f"{path}: {_said(machine, f, rest)}")
        elif rest.holds and not f.effects.sticks:
            so_far.remarks.append(f"{_said(machine, f, rest)}, of which the machine knows nothing: free {path}")


def _lacking(machine: LayoutMachine, table: Table) -> str:
    """Why a log does not say what joints carry at rest, in words; empty if it does."""
    loose = [f.name for f in machine.functions if f.effects.backlash is not None]
    if loose:
        return f"functions.{loose[0]} has play, in which oil and joint part"
    wanted = [
        name for f in machine.functions for name in (position_column(machine, f), f"{f.name}.p_a", f"{f.name}.p_b")
    ]
    lacks = [name for name in wanted if name not in table.names]
    return f"the log has no {', '.join(lacks)}" if lacks else ""


def _said(machine: LayoutMachine, f: MachineFunction, rest: Resting) -> str:
    unit = "N" if machine.link(f.moves).joint == "prismatic" else "N m"
    carried, slides = (amount(value, unit, digits=2) for value in (rest.torque, rest.coulomb))
    does = "dry friction holds the joint" if rest.holds else "dry friction does not hold the joint"
    return f"{does} of {f.name}: at rest it carries {carried} half of the time, and {slides} where the joint slides"
