"""Exact flow: the closed form of Eqs (1)-(3), clamped, without branches or iteration."""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.interface import OK, Flows
from polydraulic.machine.pump import Pump, share_surplus, single_circuit
from polydraulic.machine.state import Links
from polydraulic.machine.valve import ValveTables, orifices, prepare_valve
from polydraulic.parameters import Machine

_NEVER = 1e12  # Pa


class ExactFlow(NamedTuple):
    """Orifice tables and pump of the boom circuit."""

    boom_valve: ValveTables
    boom_pump: Pump


def exact_flow(machine: Machine, *, relief: bool = True) -> ExactFlow:
    """Flow model from a machine's orifice tables.

    Parameters
    ----------
    machine : Machine
    relief : bool
        Without it the pump's relief valve never opens: the ideal circuit of Eqs (1)-(3), for maps.

    Raises
    ------
    InputError
        If the machine asks for a torque-limited pump, which the boom circuit does not have yet.
    """
    pump = boom_pump(machine)
    pump = pump if relief else pump._replace(relief=_NEVER)
    return ExactFlow(prepare_valve(machine.boom.valve, machine.spool), pump)


def boom_pump(machine: Machine) -> Pump:
    """Return the pump of the boom circuit."""
    if machine.pumps.torque_limit_enabled:
        raise InputError(
            "pumps.torque_limit_enabled = true: torque-limited pumps are not modelled yet; set it to false"
        )
    return Pump(machine.pumps.boom_flow, machine.pumps.relief, machine.tank.return_pressure)


@kernel
def exact_step(model: ExactFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """One closed-form solve."""
    k = orifices(spool.boom, model.boom_valve)
    q_in = single_circuit(k.inlet, k.bypass, p_in.boom, model.boom_pump)
    circuit = share_surplus(q_in, k.inlet, p_in.boom, k.bypass, model.boom_pump)
    return Flows(Links(0.0, q_in, 0.0), Links(0.0, k.outlet, 0.0), circuit, OK)
