"""Exact circuits, and networks of what these leave of measured flows: flow forces, and whatever else the equations do not have.

A network adds to the flow into an actuator where the equations let oil in, and takes it from the bypass. What comes of it lies between nothing and
what the pump has left, so that no network can break a circuit: in the deadband, and against a load that the pump does not overcome, nothing flows.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.layout.network_parts import NumberedNetworks, Which
from polydraulic.flow.layout.networks import NOTHING
from polydraulic.flow.layout.slots import residual
from polydraulic.flow.network_slots import choose_model
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.table import work_size
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine


class ResidualNetwork(NamedTuple):
    """A network of a residual flow, and how far it knows travel and pressure."""

    flow: Which
    travel_high: float
    p_high: float


@kernel
def corrected(q: float, r: float, left: float) -> float:
    """Flow into a line with its residual, where the equations let any in: not less than none, and not more than is left of the pump's."""
    return min(max(q + r, 0.0), left) if q > 0.0 else q


def residual_flow(machine: LayoutMachine | str | Path, *, models: Sequence[Model] | None = None) -> LayoutFlow:
    """Flow model from the orifice tables of the machine, and networks of what they leave.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    models : sequence of Model
        In SI, of functions ``NAME.q_in_residual`` from travels and pressures at the pressurised ports of their circuit; those without one are
        exact.

    Raises
    ------
    InputError
        If no models are given, none is of this machine, or one reads other inputs.
    """
    machine = as_machine(machine)
    check_circuits(machine, "residual")
    given = {model.output.name for model in models or ()}
    places = {f: residual(c, f) for c in machine.circuits for f in c.functions}
    served = [f for f, (output, _) in places.items() if output.name in given]
    if not served:
        raise InputError(
            f"flow 'residual' needs models=[...] (--model FILE), one at least of {[output.name for output, _ in places.values()]}; given are {sorted(given)}"
        )
    chosen = [NOTHING, *(choose_model(models or (), places[f]) for f in served)]
    numbered: dict[str, object] = {}
    for c in machine.circuits:
        for place, f in enumerate(c.functions):
            number = served.index(f) + 1 if f in served else 0
            high = chosen[number].domain()[:, 1] if number else np.full(2 * len(c.functions), np.inf)
            numbered[f"residual_{f}"] = ResidualNetwork(
                number, float(high[place]), float(high[len(c.functions) + place])
            )
    networks = NumberedNetworks(chosen, numbered)
    parts = networks.in_table()
    scratch = max(*(2 * len(c.functions) for c in machine.circuits), work_size(parts["table"]))
    return LayoutFlow("residual", "residual", circuits_of(machine), machine.names, parts, scratch, True, networks)
