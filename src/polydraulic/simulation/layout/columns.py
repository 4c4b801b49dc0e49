"""What stands where in a state vector and in a recorded row of a machine of any layout: said here, read everywhere else."""

from typing import NamedTuple

import numpy as np

from polydraulic.parameters.layout.parts import MachineFunction, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine

EFFECTOR = ("effector.x", "effector.y", "effector.z")  # m; follow from the positions
STATE = (("spool", "m"), ("p_a", "Pa"), ("p_b", "Pa"), ("angle", "rad"), ("rate", "rad/s"))
MORE_STATE = (("driven", "m"), ("flow_shift", "m"), ("gap", "rad"))  # of functions that declare what needs them
FLOWS = (("q_in", "m3/s"), ("q_out", "m3/s"))
CIRCUIT = (("q_pump", "m3/s"), ("q_bypass", "m3/s"), ("q_relief", "m3/s"), ("p_pump", "Pa"))
_SLIDES = {"angle": ("position", "m"), "rate": ("speed", "m/s"), "gap": ("gap", "m")}  # of a prismatic joint


class Column(NamedTuple):
    """A value of a run, and its unit."""

    name: str
    unit: str


class AddedColumn(NamedTuple):
    """Name, unit and values of a column that follows from recorded rows."""

    name: str
    unit: str
    values: np.ndarray


class Columns(NamedTuple):
    """Columns of a recorded row.

    Attributes
    ----------
    columns : tuple of Column
    place : dict
        By name; those of joints as ``boom.angle`` and ``boom.rate`` whatever the joint.
    n_state : int
        How many of them are the state.
    """

    columns: tuple[Column, ...]
    place: dict[str, int]
    n_state: int


def columns_of(machine: LayoutMachine, *, stores_oil: bool = False) -> Columns:
    """Columns that a machine's runs record: state and flows by function, then pumps, pressures between valves and crossovers by circuit.

    Parameters
    ----------
    machine : LayoutMachine
    stores_oil : bool
        Whether the flow model follows oil between pumps and valves; what charges it comes last, by circuit.
    """
    gaps = [(c.name, k, len(c.functions)) for c in machine.circuits for k in range(1, len(c.functions))]
    named = [
        (f"{f.name}.{quantity}", function_column(machine, f.name, quantity, unit))
        for quantity, unit in (*STATE, *MORE_STATE, *FLOWS)
        for f in machine.functions
        if has(f, quantity)
    ]
    named += [
        (f"{c.name}.{quantity}", Column(f"{c.name}.{quantity}", unit))
        for c in machine.circuits
        for quantity, unit in CIRCUIT
    ]
    named += [(gap_name(*gap), Column(gap_name(*gap), "Pa")) for gap in gaps]
    named += [(cross_name(x.giving), Column(cross_name(x.giving), "m3/s")) for x in machine.crossovers]
    named += [(stored_name(c.name), Column(stored_name(c.name), "m3/s")) for c in machine.circuits if stores_oil]
    return Columns(
        tuple(column for _, column in named),
        {name: place for place, (name, _) in enumerate(named)},
        sum(has(f, quantity) for quantity, _ in (*STATE, *MORE_STATE) for f in machine.functions),
    )


def has(f: MachineFunction, quantity: str) -> bool:
    """Whether a quantity of the state or of the flows is recorded of a function.

    Of all but ``driven`` (travel that the pilot drives the spool to, where the orifices lag behind), ``flow_shift`` (by which flow forces shift
    the spool's equilibrium towards its centre) and ``gap`` (how far the actuator is ahead of the middle of its play).
    """
    declared = {
        "driven": f.effects.hysteresis,
        "flow_shift": f.effects.flow_force,
        "gap": f.effects.backlash,
    }
    return quantity not in declared or declared[quantity] is not None


def kept_quantities(f: MachineFunction) -> list[str]:
    """Names of all that is recorded of a function."""
    return [quantity for quantity, _ in (*STATE, *MORE_STATE, *FLOWS) if has(f, quantity)]


def function_column(machine: LayoutMachine, function: str, quantity: str, unit: str) -> Column:
    """Name and unit of a quantity of a function; a prismatic joint has a position and a speed."""
    slides = machine.link(machine.function(function).moves).joint == "prismatic"
    shown, unit = _SLIDES.get(quantity, (quantity, unit)) if slides else (quantity, unit)
    return Column(f"{function}.{shown}", unit)


def circuit_keys(circuit: SupplyCircuit, *, p_pump: bool, stores_oil: bool) -> list[str]:
    """Columns of a circuit, of a flow model that gives pressures of pumps or does not, and follows oil before the valves or does not."""
    n = len(circuit.functions)
    found = [f"{circuit.name}.{quantity}" for quantity, _ in CIRCUIT if p_pump or quantity != "p_pump"]
    found += [stored_name(circuit.name)] if stores_oil else []
    return found + ([gap_name(circuit.name, k, n) for k in range(1, n)] if p_pump else [])


def fed_functions(machine: LayoutMachine, circuit: str) -> set[str]:
    """Functions that a circuit's pump feeds, its own and the one behind its crossover."""
    behind = [machine.circuit(x.taking).functions[-1] for x in machine.crossovers if x.giving == circuit]
    return {*machine.circuit(circuit).functions, *behind}


def stored_name(circuit: str) -> str:
    """Name of the flow that charges the oil between a circuit's pump and its valves."""
    return f"{circuit}.q_stored"


def cross_name(giving: str) -> str:
    """Name of the flow from a circuit through its crossover."""
    return f"{giving}.q_cross"


def gap_name(circuit: str, number: int, valves: int) -> str:
    """Name of the pressure behind a circuit's valve of that number, counted from 1."""
    return f"{circuit}.p_between" if valves == 2 else f"{circuit}.p_between_{number}"
