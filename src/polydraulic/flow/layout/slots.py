"""What networks of a circuit of any length are called, and read (SI units).

Valves are counted from the pump. All flows of a circuit rise with the pump's pressure, which is the least of those that its modes would
give alone, so that a flow is the least of its modes, too (`network_slots`). What passes the first valve is such a flow; the
valves behind it know the pump by nothing else, so that their networks need no modes.
"""

from collections.abc import Sequence

from polydraulic.flow.network_slots import LIMITED, RELIEF, SHUT, Place, p_in, q_in, travel
from polydraulic.networks.model.model import Variable
from polydraulic.parameters.layout.parts import SupplyCircuit


def passed(circuit: SupplyCircuit, place: int, mode: str = "") -> Variable:
    """Flow that passes the valve at a place, counted from 1, to the next one."""
    return Variable(passed_name(circuit.name, len(circuit.functions), place) + mode, "m3/s")


def passed_name(circuit: str, valves: int, place: int) -> str:
    """Name of the flow that passes the valve at a place of a circuit."""
    return f"{circuit}.q_passed" if valves == 2 else f"{circuit}.q_passed_{place}"


def pressure_before(circuit: SupplyCircuit, place: int) -> Place:
    """Pressure before the valve at a place, counted from 0: that of the pump, then those between valves."""
    number = "" if len(circuit.functions) == 2 else f"_{place}"
    name = f"p_between{number}" if place else "p_pump"
    return Variable(f"{circuit.name}.{name}", "Pa"), everything(circuit.functions)


def everything(functions: Sequence[str]) -> tuple[Variable, ...]:
    """Travels of all valves, then pressures at their pressurised ports."""
    return (*map(travel, functions), *map(p_in, functions))


def inlet(circuit: SupplyCircuit, function: str) -> list[Place]:
    """What the network of an inlet may read: the flow that reaches the valve and what stands from it on, or everything."""
    place = circuit.functions.index(function)
    rest = circuit.functions[place:]
    read: Place = (q_in(function), everything(circuit.functions))
    return [(q_in(function), (passed(circuit, place), *everything(rest))), read] if place else [read]


def inlet_limited(circuit: SupplyCircuit, function: str) -> Place:
    """An inlet at the torque limit."""
    return q_in(function, LIMITED), everything(circuit.functions)


def inlet_shut(circuit: SupplyCircuit, function: str) -> Place:
    """The first of two inlets at constant flow, if the check valve of the second is shut."""
    return q_in(function, SHUT), everything(circuit.functions)


def second_at_relief(circuit: SupplyCircuit) -> Place:
    """The second of two inlets with the relief valve open, when what passes the first valve has no network for that."""
    function = circuit.functions[1]
    root = Variable(f"{function}.root_below_relief", "Pa^0.5")
    return q_in(function, RELIEF), (*map(travel, circuit.functions), root)


def passed_at_relief(circuit: SupplyCircuit) -> Place:
    """What passes the first valve with the relief valve open: the pressure behind that valve does not matter."""
    return passed(circuit, 1, RELIEF), (*map(travel, circuit.functions), *map(p_in, circuit.functions[1:]))


def passed_limited(circuit: SupplyCircuit) -> Place:
    """What passes the first valve at the torque limit."""
    return passed(circuit, 1, LIMITED), everything(circuit.functions)


def outlet(function: str) -> list[Place]:
    """What the network of an outlet may be: a conductance, or a flow that also depends on the root of the pressure drop."""
    spool = Variable(f"{function}.spool", "m")
    return [
        (Variable(f"{function}.k_out", "m3/s/Pa^0.5"), (spool,)),
        (Variable(f"{function}.q_out", "m3/s"), (spool, Variable(f"{function}.root_p_out", "Pa^0.5"))),
    ]


def residual(circuit: SupplyCircuit, function: str) -> Place:
    """What an exact circuit leaves of the flow into a function."""
    return Variable(f"{function}.q_in_residual", "m3/s"), everything(circuit.functions)
