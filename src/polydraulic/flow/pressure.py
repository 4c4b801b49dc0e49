"""Pump-pressure flow: networks for the pump pressure, flows from Eqs (1) and (2) with known orifice areas.

The thesis' first attempt (4.2.1), kept to show why it fails: an error of the pressure becomes, through the root of a
small difference, a large error of the flow, and nothing holds the flows to what the pump delivers.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.layout.network_parts import NumberedNetworks, Which
from polydraulic.flow.layout.networks import NOTHING
from polydraulic.flow.layout.slots import pressure_before
from polydraulic.flow.network_slots import choose_model
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.table import work_size
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

_NO_MODELS = "flow 'pressure' needs models=[...]: fit one of '{}' on a sampled table first"


class PressureNetwork(NamedTuple):
    """Networks of the pressure before a valve, and the largest pressure at its pressurised port that they know."""

    p: Which
    p_in_high: float


def pressure_flow(machine: LayoutMachine | str | Path, *, models: Sequence[Model] | None = None) -> LayoutFlow:
    """Flow model from networks of the pump pressure.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    models : sequence of Model
        In SI, for a circuit the pressures before all of its valves, of their travels and pressures at their pressurised ports:
        ``work.p_pump``, and between valves ``work.p_between`` (of more than two ``work.p_between_1`` and so on). Functions of circuits
        without networks get no flow.

    Raises
    ------
    InputError
        If no models are given, one is missing or reads other inputs, or none is of this machine; if a pump has a torque limit.
    """
    machine = as_machine(machine)
    check_circuits(machine, "pressure")
    if models is None:
        raise InputError(_NO_MODELS.format(f"{machine.circuits[0].name}.p_pump"))
    given = {model.output.name for model in models}
    served = [c for c in machine.circuits if f"{c.name}.p_pump" in given]
    if not served:
        raise InputError(
            f"given are models of {sorted(given)}; flow 'pressure' needs one of {[f'{c.name}.p_pump' for c in machine.circuits]}"
        )
    chosen: list[Model] = [NOTHING]
    highest = dict.fromkeys(machine.names, np.inf)
    number = dict.fromkeys(machine.names, 0)
    for c in served:
        if c.pump.torque_limit_enabled:
            raise InputError(
                f"circuits.{c.name}.pump.torque_limit_enabled = true: flow 'pressure' does not know how that lowers the flow; set it to false, "
                "or use flow 'exact'"
            )
        for place, f in enumerate(c.functions):
            number[f] = len(chosen)
            chosen.append(choose_model(models, pressure_before(c, place)))
        for place, f in enumerate(c.functions):
            domains = [chosen[number[g]].domain() for g in c.functions]
            highest[f] = min(float(domain[len(c.functions) + place, 1]) for domain in domains)
    networks = NumberedNetworks(
        chosen, {f"pressure_{f}": PressureNetwork(number[f], highest[f]) for f in machine.names}
    )
    parts = networks.in_table()
    scratch = max(*(2 * len(c.functions) for c in machine.circuits), work_size(parts["table"]))
    moved = tuple(f for f in machine.names if number[f])
    return LayoutFlow("pressure", "pressure", circuits_of(machine), moved, parts, scratch, True, networks)
