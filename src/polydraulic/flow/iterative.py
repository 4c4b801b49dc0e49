"""Iterative flow: the thesis' way, pump pressure -> flows -> pump pressure, until the pressure settles within `eps`.

A sweep inserts the pressure into Eq. (1), takes the bypass flow from Eq. (3) and the next pressure from Eq. (2). Its slope is
-(Q_e / Q_i)(K a_i / K a_e)^2, so that the plain sweep (relaxation 1) converges only while the bypass is wide; with
relaxation r it converges while that slope stays above 1 - 2/r. The number of sweeps is bounded; a step that reaches the
bound reports NOT_CONVERGED and uses what it has.
"""

from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import boom_pump
from polydraulic.flow.interface import NOT_CONVERGED, OK, Flows
from polydraulic.machine.pump import Circuit, Pump
from polydraulic.machine.state import Links
from polydraulic.machine.valve import ValveTables, orifice_flow, orifices, prepare_valve
from polydraulic.parameters import Machine


class IterativeFlow(NamedTuple):
    """Orifice tables and pump of the boom circuit, and how to iterate."""

    boom_valve: ValveTables
    boom_pump: Pump
    eps: float
    relaxation: float
    max_sweeps: int


def iterative_flow(
    machine: Machine, *, eps: float = 0.05, relaxation: float = 0.2, max_sweeps: int = 200
) -> IterativeFlow:
    """Flow model that iterates on the pump pressure.

    Parameters
    ----------
    machine : Machine
    eps : float
        Largest relative change of the pump pressure at which a sweep counts as the last (thesis 5.4: 0.05).
    relaxation : float
        Share of a sweep's pressure change that is made, in (0, 1].
    max_sweeps : int
        Sweeps a step at most.

    Raises
    ------
    InputError
        If a setting is out of its range.
    """
    if not 0.0 < eps < 1.0:
        raise InputError(f"eps = {eps}: must lie between 0 and 1, for example 0.05")
    if not 0.0 < relaxation <= 1.0:
        raise InputError(f"relaxation = {relaxation}: must lie in (0, 1]")
    if max_sweeps < 1:
        raise InputError(f"max_sweeps = {max_sweeps}: must be at least 1")
    valve = prepare_valve(machine.boom.valve, machine.spool)
    return IterativeFlow(valve, boom_pump(machine), eps, relaxation, max_sweeps)


@kernel
def iterative_step(
    model: IterativeFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float
) -> Flows:
    """Sweep from the pressure of the step before; `memory[0]` keeps it, in Pa."""
    k = orifices(spool.boom, model.boom_valve)
    pump = model.boom_pump
    p = memory[0] if memory[0] > 0.0 else pump.p_return
    status = NOT_CONVERGED
    for _ in range(model.max_sweeps):
        q_in = min(orifice_flow(k.inlet, p - p_in.boom), pump.flow)
        root = (pump.flow - q_in) / k.bypass if k.bypass > 0.0 else pump.flow / (k.inlet + 1e-300)
        p_next = pump.p_return + root * root if k.bypass > 0.0 else p_in.boom + root * root
        p_next = min(p_next, pump.relief)
        settled = abs(p_next - p) < model.eps * p
        p = p_next if (settled or k.bypass <= 0.0) else p + model.relaxation * (p_next - p)
        if settled:
            status = OK
            break
    memory[0] = p
    q_in = min(orifice_flow(k.inlet, p - p_in.boom), pump.flow)
    surplus = pump.flow - q_in
    at_relief = p >= pump.relief
    q_bypass = min(surplus, orifice_flow(k.bypass, p - pump.p_return)) if at_relief else surplus
    circuit = Circuit(pump.flow, q_bypass, surplus - q_bypass, p)
    return Flows(Links(0.0, q_in, 0.0), Links(0.0, k.outlet, 0.0), circuit, status)
