"""Iterative flow: the thesis' way, pump pressure -> flows -> pump pressure, until the pressure settles within `eps`.

Boom: a sweep inserts the pressure into Eq. (1), takes the bypass flow from Eq. (3) and the next pressure from Eq. (2). Its slope is
-(Q_e / Q_i)(K a_i / K a_e)^2, so that the plain sweep (relaxation 1) converges only while the bypass is wide; with
relaxation r it converges while that slope stays above 1 - 2/r. Swing and stick: the same with two pressures, before and
between the valves, Eqs (8)-(13). The number of sweeps is bounded; a step that reaches the bound reports NOT_CONVERGED and
uses what it has.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import Valves, prepare_valves
from polydraulic.flow.interface import NOT_CONVERGED, OK, Flows
from polydraulic.machine.pump import Circuit, Pump, delivered, prepare_pump
from polydraulic.machine.state import Links
from polydraulic.machine.valve import Orifices, orifice_flow, orifices
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import Machine


class IterativeFlow(NamedTuple):
    """Orifice tables and pumps of both circuits, and how to iterate."""

    valves: Valves
    boom_pump: Pump
    series_pump: Pump
    eps: float
    relaxation: float
    max_sweeps: int


def iterative_flow(
    machine: Machine | str | Path, *, eps: float = 0.05, relaxation: float = 0.2, max_sweeps: int = 200
) -> IterativeFlow:
    """Flow model that iterates on the pump pressure.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    eps : float
        Largest relative change of the pump pressure at which a sweep counts as the last (thesis 5.4: 0.05).
    relaxation : float
        Share of a sweep's pressure change that is made, in (0, 1].
    max_sweeps : int
        Maximum number of sweeps per step.

    Raises
    ------
    InputError
        If a setting is out of its range.
    """
    machine = as_excavator(machine)
    if not 0.0 < eps < 1.0:
        raise InputError(f"eps = {eps}: must lie between 0 and 1, for example 0.05")
    if not 0.0 < relaxation <= 1.0:
        raise InputError(f"relaxation = {relaxation}: must lie in (0, 1]")
    if max_sweeps < 1:
        raise InputError(f"max_sweeps = {max_sweeps}: must be at least 1")
    boom, series = (prepare_pump(machine, flow) for flow in (machine.pumps.boom_flow, machine.pumps.series_flow))
    return IterativeFlow(prepare_valves(machine), boom, series, eps, relaxation, max_sweeps)


class _Swept(NamedTuple):
    """Pressures where the sweeps end, before the valves and between them."""

    p: float
    p_between: float
    settled: bool


@kernel
def _sweep_boom(k: Orifices, p_in: float, p: float, model: IterativeFlow) -> _Swept:
    pump = model.boom_pump
    settled = False
    for _ in range(model.max_sweeps):
        Q = delivered(p, pump)
        q_in = min(orifice_flow(k.inlet, p - p_in), Q)
        root = (Q - q_in) / k.bypass if k.bypass > 0.0 else Q / (k.inlet + 1e-300)
        p_next = pump.p_return + root * root if k.bypass > 0.0 else p_in + root * root
        p_next = min(p_next, pump.relief)
        settled = abs(p_next - p) < model.eps * p
        p = p_next if (settled or k.bypass <= 0.0) else p + model.relaxation * (p_next - p)
        if settled:
            break
    return _Swept(p, 0.0, settled)


@kernel
def _boom(k: Orifices, p_in: float, p: float, pump: Pump) -> Circuit:
    """Flows at a pressure that has settled."""
    Q = delivered(p, pump)
    surplus = Q - min(orifice_flow(k.inlet, p - p_in), Q)
    at_relief = p >= pump.relief
    q_bypass = min(surplus, orifice_flow(k.bypass, p - pump.p_return)) if at_relief else surplus
    return Circuit(Q, q_bypass, surplus - q_bypass, p, 0.0)


@kernel
def _sweep_series(
    swing: Orifices, stick: Orifices, p_in: Links, p: float, p_between: float, model: IterativeFlow
) -> _Swept:
    pump, r = model.series_pump, model.relaxation
    settled = False
    for _ in range(model.max_sweeps):
        Q = delivered(p, pump)
        w = Q - min(orifice_flow(swing.inlet, p - p_in.swing), Q) if swing.bypass > 0.0 else 0.0
        q_bypass = w - min(orifice_flow(stick.inlet, p_between - p_in.stick), w)
        root = (q_bypass / stick.bypass) if stick.bypass > 0.0 else w / (stick.inlet + 1e-300)
        between = (pump.p_return if stick.bypass > 0.0 else p_in.stick) + root * root
        between = min(between, pump.relief)
        root = w / swing.bypass if swing.bypass > 0.0 else Q / (swing.inlet + 1e-300)
        p_next = (between if swing.bypass > 0.0 else p_in.swing) + root * root
        p_next = min(p_next, pump.relief)
        settled = abs(p_next - p) < model.eps * p and abs(between - p_between) < model.eps * p_between
        p = p_next if (settled or swing.bypass <= 0.0) else p + r * (p_next - p)
        p_between = between if (settled or stick.bypass <= 0.0) else p_between + r * (between - p_between)
        if settled:
            break
    return _Swept(p, p_between, settled)


class _SeriesFlows(NamedTuple):
    q_swing: float
    q_stick: float
    circuit: Circuit


@kernel
def _series(swing: Orifices, stick: Orifices, p_in: Links, found: _Swept, pump: Pump) -> _SeriesFlows:
    """Flows at pressures that have settled."""
    Q = delivered(found.p, pump)
    q_swing = min(orifice_flow(swing.inlet, found.p - p_in.swing), Q)
    passing = orifice_flow(swing.bypass, found.p - found.p_between)
    at_relief = found.p >= pump.relief or swing.bypass <= 0.0
    w = min(Q - q_swing, passing) if at_relief else Q - q_swing
    q_stick = min(orifice_flow(stick.inlet, found.p_between - p_in.stick), w)
    q_stick = w if stick.bypass <= 0.0 else q_stick
    return _SeriesFlows(q_swing, q_stick, Circuit(Q, w - q_stick, Q - q_swing - w, found.p, 0.0))


@kernel
def iterative_step(
    model: IterativeFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float
) -> Flows:
    """Sweep from the pressures of the step before; `memory` keeps the three of them, in Pa."""
    k_swing = orifices(spool.swing, model.valves.swing)
    k_boom = orifices(spool.boom, model.valves.boom)
    k_stick = orifices(spool.stick, model.valves.stick)
    low = model.boom_pump.p_return

    boom = _sweep_boom(k_boom, p_in.boom, memory[0] if memory[0] > 0.0 else low, model)
    circuit = _boom(k_boom, p_in.boom, boom.p, model.boom_pump)
    q_boom = circuit.q_pump - circuit.q_bypass - circuit.q_relief

    p, p_between = memory[1] if memory[1] > 0.0 else low, memory[2] if memory[2] > 0.0 else low
    found = _sweep_series(k_swing, k_stick, p_in, p, p_between, model)
    series = _series(k_swing, k_stick, p_in, found, model.series_pump)

    memory[0], memory[1], memory[2] = boom.p, found.p, found.p_between
    return Flows(
        Links(series.q_swing, q_boom, series.q_stick),
        Links(k_swing.outlet, k_boom.outlet, k_stick.outlet),
        circuit,
        series.circuit,
        found.p_between,
        OK if (boom.settled and found.settled) else NOT_CONVERGED,
    )
