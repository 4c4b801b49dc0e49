"""A flow model of a machine of any layout: which kernels its circuits get, and the numbers that these read."""

from typing import Any, NamedTuple

from polydraulic.errors import InputError
from polydraulic.parameters.layout.parts import MOST_IN_SERIES
from polydraulic.parameters.layout.schema import LayoutMachine


class LayoutFlow(NamedTuple):
    """A flow model made of one part for each circuit.

    Attributes
    ----------
    name : str
        As in `FLOW_KINDS`.
    kernels : str
        Which page of flows stands in the text of the machine.
    circuits : dict
        Functions by circuit, of the machine that it is for.
    served : tuple of str
        Functions that get flow.
    parts : dict
        Arrays and numbers by the name of their field in the text's ``Valves``.
    n_memory : int
        Floats that a step keeps or uses as scratch.
    gives_pump_pressure : bool
        Whether pressures of pumps, and between valves, are found.
    """

    name: str
    kernels: str
    circuits: dict[str, tuple[str, ...]]
    served: tuple[str, ...]
    parts: dict[str, Any]
    n_memory: int
    gives_pump_pressure: bool


def circuits_of(machine: LayoutMachine) -> dict[str, tuple[str, ...]]:
    """Functions of each circuit."""
    return {c.name: c.functions for c in machine.circuits}


def exact_layout(machine: LayoutMachine) -> LayoutFlow:
    """Flows from the orifice tables of the machine itself."""
    return LayoutFlow("exact", "exact", circuits_of(machine), machine.names, {}, 1, True)


def check_machine(flow: LayoutFlow, machine: LayoutMachine) -> None:
    """Refuse a flow model to a machine with other circuits.

    Raises
    ------
    InputError
    """
    here = circuits_of(machine)
    if flow.circuits != here:
        raise InputError(
            f"the flow model {flow.name!r} is for the circuits {_said(flow.circuits)}; this machine has {_said(here)}"
        )


def check_circuits(machine: LayoutMachine, name: str, *, most: int = MOST_IN_SERIES) -> None:
    """Refuse a machine with circuits that the flow model `name` does not know: other than valves in series, or more than `most`.

    Raises
    ------
    InputError
    """
    for c in machine.circuits:
        if c.kind != "series":
            raise InputError(
                f"flow {name!r} is for circuits of valves in series; circuit {c.name!r} is of the kind {c.kind!r}: use 'exact'"
            )
        if len(c.functions) > most:
            raise InputError(
                f"flow {name!r} is for circuits of at most {most} valves; circuit {c.name!r} has {len(c.functions)} "
                f"({', '.join(c.functions)}): use 'exact' or 'polynomial'"
            )


def _said(circuits: dict[str, tuple[str, ...]]) -> str:
    return "; ".join(f"{name} ({', '.join(functions)})" for name, functions in circuits.items())
