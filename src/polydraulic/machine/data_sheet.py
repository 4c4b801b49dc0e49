"""What a data sheet or a gauge says of a machine, worked out from its file: strokes, times from stop to stop, pressures that hold it."""

from collections.abc import Iterator
from math import pi
from typing import NamedTuple

import numpy as np

from polydraulic.display import amount
from polydraulic.machine.stability.statics import Levers, function_levers, holding_pressures
from polydraulic.parameters.layout.geometry import lever
from polydraulic.parameters.layout.parts import MachineFunction
from polydraulic.parameters.layout.schema import LayoutMachine

_POSITIONS = 129  # of a joint between its stops, over which volumes and strokes are summed
_TURN = 2.0 * pi
_JOLT = 0.1  # of the line's relief pressure: initial pressures this far from those that hold the machine are named


class FunctionSheet(NamedTuple):
    """What can be looked up or measured of one function.

    Attributes
    ----------
    stroke : float or None, m
        Of the cylinder between the stops; None of a motor.
    to_high, to_low : float, s
        From stop to stop, or a whole turn of what turns further, with all the oil of its pump and no load.
    hold_a, hold_b : float, Pa
        Pressures with which it stands at the initial positions, the lesser at that of the return line.
    """

    stroke: float | None
    to_high: float
    to_low: float
    hold_a: float
    hold_b: float


def function_sheets(machine: LayoutMachine) -> dict[str, FunctionSheet]:
    """What can be looked up or measured of each function of a machine, by name.

    Parameters
    ----------
    machine : LayoutMachine
    """
    holding = holding_pressures(machine, np.array([[f.initial.angle for f in machine.functions]]))[0]
    return {
        f.name: _sheet(machine, f, float(holding[place, 0]), float(holding[place, 1]))
        for place, f in enumerate(machine.functions)
    }


def _sheet(machine: LayoutMachine, f: MachineFunction, hold_a: float, hold_b: float) -> FunctionSheet:
    positions = np.linspace(f.stops.low, f.stops.high, _POSITIONS)
    if f.actuator == "motor":
        positions = np.linspace(0.0, min(f.stops.high - f.stops.low, _TURN), 2)
        stroke = None
    else:
        link = machine.link(f.moves)
        stroke = float(np.trapezoid([abs(lever(f, link, position) or 0.0) for position in positions], positions))
    of = function_levers(machine, f, positions)
    flow = max(c.pump.flow for c in machine.circuits if f.name in c.functions)
    to_high, to_low = (float(np.trapezoid(side, positions)) / flow for side in of)
    return FunctionSheet(stroke, to_high, to_low, hold_a, hold_b)


def sheet_lines(machine: LayoutMachine) -> list[str]:
    """The same in lines that a person can set next to a data sheet."""
    return [f"  {name}: {_line(machine.function(name), sheet)}" for name, sheet in function_sheets(machine).items()]


def _line(f: MachineFunction, sheet: FunctionSheet) -> str:
    if sheet.stroke is not None:
        words = f"stroke {amount(sheet.stroke, 'm')}, {amount(sheet.to_high, 's')} to high and {amount(sheet.to_low, 's')} to low"
    else:
        way = "a turn" if f.stops.high - f.stops.low >= _TURN else "from stop to stop"
        words = f"{way} in {amount(sheet.to_high, 's')}"
    return f"{words}; held by {amount(sheet.hold_a, 'Pa')} at A, {amount(sheet.hold_b, 'Pa')} at B"


def doubtful_statics(machine: LayoutMachine) -> Iterator[str]:
    """Say which functions cannot stand at their initial positions, or begin with pressures that do not hold them."""
    positions = np.array([[f.initial.angle for f in machine.functions]])
    for place, (f, sheet) in enumerate(zip(machine.functions, function_sheets(machine).values(), strict=True)):
        where, needed = f"functions.{f.name}", max(sheet.hold_a, sheet.hold_b)
        if needed > f.line.relief:
            yield (
                f"{where}: {amount(needed, 'Pa')} would hold it at its initial position, but line.relief is "
                f"{amount(f.line.relief, 'Pa')}, so that it sinks; check masses, centres of gravity, pins and bores"
            )
            continue
        relief, path = max((c.pump.relief, c.pump_path) for c in machine.circuits if f.name in c.functions)
        if needed > relief:
            yield (
                f"{where}: {amount(needed, 'Pa')} hold it at its initial position, but {path}.relief is {amount(relief, 'Pa')}, so that "
                "it is not raised from there; check masses, centres of gravity, pins and bores"
            )
        of = function_levers(machine, f, positions[:, place])
        missing = _short_of(f, sheet, of)
        if abs(missing) > _JOLT * f.line.relief:
            yield (
                f"{where}.initial: p_a = {amount(f.initial.p_a, 'Pa')} and p_b = {amount(f.initial.p_b, 'Pa')} do not hold it, "
                f"{amount(sheet.hold_a, 'Pa')} and {amount(sheet.hold_b, 'Pa')} would: it begins with a jolt"
            )


def _short_of(f: MachineFunction, sheet: FunctionSheet, of: Levers) -> float:
    """Pressure at the larger side that dry friction would have to make up for; Pa."""
    a, b = float(of.a[0]), float(of.b[0])
    torque = (f.initial.p_a - sheet.hold_a) * a - (f.initial.p_b - sheet.hold_b) * b
    return max(abs(torque) - f.friction.static, 0.0) / max(a, b)
