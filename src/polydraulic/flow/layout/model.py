"""A flow model of a machine of any layout: which kernels its circuits get, and the numbers that these read."""

from pathlib import Path
from typing import Any, NamedTuple

import numba

from polydraulic.errors import InputError
from polydraulic.flow.layout.network_parts import NumberedNetworks
from polydraulic.parameters.layout.parts import MOST_IN_SERIES, SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

STORING = ("stiff", "tlm")  # kernels that follow oil between pumps and valves
# kernels whose flows follow from spools and pressures alone, so that they have a meaning between two steps
FORGETTING = ("exact", "networks", "residual", "lookup", "pressure")


class KnownCircuits(NamedTuple):
    """Circuits that a flow model knows: valves in series, at most so many, and whether one may give to another through a crossover."""

    most: int
    crossover: bool = False


KNOWN_CIRCUITS = {
    "exact": KnownCircuits(MOST_IN_SERIES, crossover=True),
    "iterative": KnownCircuits(2),
    "stiff": KnownCircuits(2),
    "tlm": KnownCircuits(MOST_IN_SERIES),
    "lookup": KnownCircuits(2),
    "polynomial": KnownCircuits(MOST_IN_SERIES),
    "polynomial-fine": KnownCircuits(2),
    "neural": KnownCircuits(MOST_IN_SERIES),
    "pressure": KnownCircuits(MOST_IN_SERIES),
    "residual": KnownCircuits(MOST_IN_SERIES),
}


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
        Arrays and numbers by the name of their field in the text's ``Valves``; networks in a table.
    n_memory : int
        Floats that a step keeps or uses as scratch.
    gives_pump_pressure : bool
        Whether pressures of pumps, and between valves, are found.
    networks : NumberedNetworks or None
        Networks, where there are any.
    """

    name: str
    kernels: str
    circuits: dict[str, tuple[str, ...]]
    served: tuple[str, ...]
    parts: dict[str, Any]
    n_memory: int
    gives_pump_pressure: bool
    networks: NumberedNetworks | None = None

    @property
    def running_parts(self) -> dict[str, Any]:
        """Parts as kernels of this process read them: networks as machine code where there is a compiler."""
        return self.parts if self.networks is None or numba.config.DISABLE_JIT else self.networks.as_code()

    @property
    def stores_oil(self) -> bool:
        """Whether it follows oil between pumps and valves, so that pressures of its own go on from step to step."""
        return self.kernels in STORING

    @property
    def compliances(self) -> tuple[float, float] | None:
        """Of that oil before a circuit's first valve, and before each other one, m3/Pa."""
        if not self.stores_oil:
            return None
        of = self.parts["volumes" if self.kernels == "stiff" else "tlm_lines"]
        return of.compliance, of.compliance_between


def circuits_of(machine: LayoutMachine) -> dict[str, tuple[str, ...]]:
    """Functions of each circuit."""
    return {c.name: c.functions for c in machine.circuits}


def exact_flow(machine: LayoutMachine | str | Path) -> LayoutFlow:
    """Flow model from the orifice tables of the machine itself.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    """
    machine = as_machine(machine)
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


def flows_for(machine: LayoutMachine) -> list[str]:
    """Names of the flow models that know all circuits of a machine."""
    return [name for name, known in KNOWN_CIRCUITS.items() if all(_known(c, known) for c in machine.circuits)]


def check_circuits(machine: LayoutMachine, name: str) -> None:
    """Refuse a machine with circuits that the flow model `name` does not know, and say which models do.

    Raises
    ------
    InputError
    """
    known = KNOWN_CIRCUITS[name]
    for c in machine.circuits:
        if _known(c, known):
            continue
        least = "valves in series" if known.most == MOST_IN_SERIES else f"at most {known.most} valves in series"
        found = (
            f"circuit {c.name!r} has {len(c.functions)} ({', '.join(c.functions)})"
            if c.kind == "series"
            else f"circuit {c.name!r} is of the kind {c.kind!r}"
        )
        able = flows_for(machine)
        use = f"use {able[0]!r}" if len(able) == 1 else f"use one of {able}"
        raise InputError(f"flow {name!r} is for circuits of {least}; {found}: {use}")


def _known(circuit: SupplyCircuit, known: KnownCircuits) -> bool:
    return (circuit.kind == "series" or known.crossover) and len(circuit.functions) <= known.most


def _said(circuits: dict[str, tuple[str, ...]]) -> str:
    return "; ".join(f"{name} ({', '.join(functions)})" for name, functions in circuits.items())
