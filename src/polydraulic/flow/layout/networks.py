"""Networks, polynomial or neural, in place of all valves of a machine of any layout."""

from collections.abc import Sequence

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.layout.network_parts import NumberedNetworks, PassedNetworks, ValveNetworks
from polydraulic.flow.layout.slots import (
    everything,
    inlet,
    inlet_limited,
    inlet_shut,
    outlet,
    passed_at_relief,
    passed_limited,
    second_at_relief,
)
from polydraulic.flow.network_slots import Place, choose_model, k_in
from polydraulic.machine.valve import spool_edges
from polydraulic.networks.model.model import Model, Variable
from polydraulic.networks.model.table import Network, work_size
from polydraulic.parameters.layout.parts import SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine


def layout_networks(machine: LayoutMachine, models: Sequence[Model], kind: str) -> LayoutFlow:
    """Put networks into their places.

    Parameters
    ----------
    machine : LayoutMachine
        Flows and relief settings of its pumps are used, and where bypasses close; a torque limit is known only to networks that
        were trained with one.
    models : sequence of Model
        In SI, for each function of a circuit an inlet (``boom.q_in``) and an outlet (``boom.k_out``), and those of single modes of the
        pump, which may be missing; see `flow.layout.slots`. Functions of circuits without networks get no flow.
    kind : {"polynomial", "neural"}

    Raises
    ------
    InputError
        If one is missing or reads other inputs, or if none is of this machine.
    """
    check_circuits(machine, kind)
    given = {model.output.name for model in models}
    served = tuple(
        c for c in machine.circuits if any(name.split(".")[0] in c.functions for name in given if "." in name)
    )
    if not served:
        raise InputError(
            f"given are models of {sorted(given)}; a flow model needs those of all functions of a circuit: "
            + "; ".join(f"{c.name}: {', '.join(c.functions)}" for c in machine.circuits)
        )
    chosen: list[Model] = [NOTHING, _NEVER_LEAST]
    places: dict[tuple[str, str], int] = {}

    def place(key: tuple[str, str], alternatives: Sequence[Place], *, needed: bool) -> None:
        if needed or alternatives[0][0].name in given:
            places[key] = len(chosen)
            chosen.append(choose_model(models, *alternatives))

    for c in served:
        for f in c.functions:
            place((f, "q_in"), inlet(c, f), needed=True)
            place((f, "k_out"), outlet(f), needed=True)
            place((f, "limited"), [inlet_limited(c, f)], needed=False)
        place((c.functions[0], "relief"), [k_in(c.functions[0])], needed=False)
        if len(c.functions) == 2:
            place((c.functions[1], "relief"), [second_at_relief(c)], needed=False)
            place((c.functions[0], "shut"), [inlet_shut(c, c.functions[0])], needed=False)
        if len(c.functions) > 1:
            place((c.name, "passed relief"), [passed_at_relief(c)], needed=False)
            place((c.name, "passed limited"), [passed_limited(c)], needed=False)
    functions = tuple(f for c in served for f in c.functions)

    def valve(f: str) -> ValveNetworks:
        nothing = 0 if f not in functions else 1  # where a network of a mode is missing, no other is less
        of = {role: places.get((f, role), nothing) for role in ("q_in", "relief", "limited", "shut", "k_out")}
        q_in, k_out = chosen[of["q_in"]], chosen[of["k_out"]]
        return ValveNetworks(
            q_in=of["q_in"],
            relief=of["relief"],
            limited=of["limited"],
            shut=of["shut"],
            k_out=of["k_out"],
            cascade="q_passed" in q_in.inputs[0].name,
            by_root=len(k_out.inputs) == 2,
            closes=spool_edges(machine.function(f).valve)[1],
            travel_high=_highest(q_in, f"{f}.travel"),
            p_high=_highest(q_in, f"{f}.p_in"),
            root_high=_highest(k_out, f"{f}.root_p_out"),
        )

    numbered: dict[str, object] = {f"networks_{f}": valve(f) for f in machine.names}
    numbered |= {
        f"passed_{c.name}": PassedNetworks(
            *(places.get((c.name, role), 1) for role in ("passed relief", "passed limited"))
        )
        for c in shared_circuits(machine)
    }
    networks = NumberedNetworks(chosen, numbered)
    parts = networks.in_table()
    longest = max(len(everything(c.functions)) for c in machine.circuits)
    scratch = max(1 + longest, work_size(parts["table"]))
    moved = tuple(f for f in machine.names if f in functions)
    return LayoutFlow(kind, "networks", circuits_of(machine), moved, parts, scratch, False, networks)


def shared_circuits(machine: LayoutMachine) -> list[SupplyCircuit]:
    """Circuits of more than one valve."""
    return [c for c in machine.circuits if len(c.functions) > 1]


def _constant(y: float) -> Model:
    return Model((Variable("none"),), Variable("none"), (Network((), (0.0,), (1.0,), (0.0,), (0.0,), y, 1.0),))


NOTHING = _constant(0.0)
_NEVER_LEAST = _constant(1e6)  # as a flow, and as a conductance, a hair below relief pressure


def _highest(model: Model, name: str) -> float:
    """Largest value of an input in the domain of a model; inf if it does not read it."""
    names = [variable.name for variable in model.inputs]
    return float(model.domain()[names.index(name), 1]) if name in names else np.inf
