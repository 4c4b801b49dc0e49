"""Which residuals the sensors of a machine allow.

Each follows from measured signals through few equations, so that a fault shows in few of them:

- ``NAME.spool``: the spool, less that which the pilot makes of the voltage;
- ``NAME.q_in``: flow into the actuator, less that of the exact circuit, or of two that a crossover joins, at the measured spools and pressures;
- ``NAME.p_out``: pressure at the outlet, less that which drives the measured flow through the valve (of a wide outlet the
  pressure is known better from the flow than the flow from the pressure);
- ``NAME.volume_a``, ``NAME.volume_b``: mean flow that the actuator's motion, the line's compliance and leakage took in a window, less that
  through the valve;
- ``NAME.torque``: torque of the oil less that which the motion and friction need;
- ``CIRCUIT.p_pump``: pressure before the valves, less that of the exact circuit at the measured spools and pressures.
"""

from typing import NamedTuple

from polydraulic.parameters.layout.parts import Crossover, MachineFunction, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine, position_column


class WatchChannel(NamedTuple):
    """A kind of residual.

    Attributes
    ----------
    name : str
        ``boom.q_in``.
    unit : str
    """

    name: str
    unit: str


_UNITS = {
    "spool": "m",
    "q_in": "m3/s",
    "p_out": "Pa",
    "volume_a": "m3/s",
    "volume_b": "m3/s",
    "torque": "N m",
    "p_pump": "Pa",
}


def crossover_of(machine: LayoutMachine, name: str) -> Crossover | None:
    """The crossover that joins a function's circuit with another one, if there is one."""
    own = next(c.name for c in machine.circuits if name in c.functions)
    return next((x for x in machine.crossovers if own in (x.giving, x.taking)), None)


def circuits_beside(machine: LayoutMachine, name: str) -> tuple[SupplyCircuit, ...]:
    """Circuits that the flow into a function depends on: its own, or the giving and the taking one that a crossover joins."""
    x = crossover_of(machine, name)
    if x is None:
        return (next(c for c in machine.circuits if name in c.functions),)
    return machine.circuit(x.giving), machine.circuit(x.taking)


def valves_beside(machine: LayoutMachine, name: str) -> tuple[str, ...]:
    """Functions whose valves the flow into one depends on, in the order of those circuits."""
    return tuple(f for c in circuits_beside(machine, name) for f in c.functions)


def channels_of(machine: LayoutMachine, columns: frozenset[str]) -> tuple[WatchChannel, ...]:
    """Residuals that these columns of a log allow, in the order of the functions, and then of the circuits."""
    known = [f.name for f in machine.functions if _has_spool(f.name, columns)]
    seen = {name for name in known if {f"{name}.p_a", f"{name}.p_b"} <= columns}
    solved = {f.name for f in machine.functions if seen.issuperset(valves_beside(machine, f.name))}
    moved = all({position_column(machine, f), f"{f.name}.p_a", f"{f.name}.p_b"} <= columns for f in machine.functions)
    found: list[WatchChannel] = []
    for f in machine.functions:
        name, pressures = f.name, {f"{f.name}.p_a", f"{f.name}.p_b"} <= columns
        has = {what: f"{name}.{what}" in columns for what in ("voltage", "spool", "q_in", "q_out")}
        flows = (has["q_in"] or name in solved) and (has["q_out"] or name in known)
        balanced = pressures and position_column(machine, f) in columns and name in known and flows
        allowed = {
            "spool": has["voltage"] and has["spool"],
            "q_in": has["q_in"] and name in solved,
            "p_out": has["q_out"] and pressures and name in known,
            "volume_a": balanced,
            "volume_b": balanced,
            "torque": moved,
        }
        found += [WatchChannel(f"{name}.{what}", _unit(machine, f, what)) for what, given in allowed.items() if given]
    pumps = [f"{c.name}.p_pump" for c in machine.circuits if solved.issuperset(c.functions)]
    return (*found, *(WatchChannel(name, _UNITS["p_pump"]) for name in pumps if name in columns))


def pump_columns(machine: LayoutMachine) -> list[str]:
    """Columns of the pressures of pumps."""
    return [f"{c.name}.p_pump" for c in machine.circuits]


def _unit(machine: LayoutMachine, f: MachineFunction, what: str) -> str:
    return "N" if what == "torque" and machine.link(f.moves).joint == "prismatic" else _UNITS[what]


def _has_spool(name: str, columns: frozenset[str]) -> bool:
    return bool({f"{name}.spool", f"{name}.voltage"} & columns)
