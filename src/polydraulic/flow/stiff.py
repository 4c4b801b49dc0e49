"""Stiff flow: the pump pressures as states, Eq. (3'): C dP/dt = Q - Q_i - Q_e.

The oil in a pump's pipe, and in the passage between the valves of swing and stick, is a small volume whose pressure is
stepped by backward Euler: over a step a volume is a feed with the pressure P + Z Q and the impedance Z = dt / C. The valve of
the boom then has the form of `machine.feed`. Swing and stick: Newton steps in the flow between the valves, with what
lies behind the swing's bypass as a resistance and an orifice that agree with it in pressure, slope and curvature. A
torque limit enters as the tangent of the pump's flow over pressure, which is convex, so that the steps come from one
side. All passes are fixed in number. As the volumes shrink, the flows approach those of `exact` in proportion to them.
"""

from math import isfinite
from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import Valves, prepare_valves
from polydraulic.flow.interface import OK, Flows
from polydraulic.machine.feed import (
    DRAW_PASSES,
    SHUT,
    TRICKLE,
    Bypass,
    Draw,
    Feed,
    at_most,
    draw_pass,
    inlet_part,
    relieved_flow,
)
from polydraulic.machine.pump import Circuit, Pump, delivered, prepare_pump, series_circuit, single_circuit
from polydraulic.machine.state import Links
from polydraulic.machine.valve import Orifices, orifice_flow, orifices
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import Machine

SERIES_PASSES = 6
LIMITED_PASSES = 8


class StiffFlow(NamedTuple):
    """Orifice tables, pumps, and the compliances in m3/Pa of a pump's pipe and of the passage between two valves."""

    valves: Valves
    boom_pump: Pump
    series_pump: Pump
    compliance: float
    compliance_between: float


def stiff_flow(
    machine: Machine | str | Path, *, volume: float = 1e-3, volume_between: float = 2e-4, bulk_modulus: float = 1.0e9
) -> StiffFlow:
    """Flow model with the pump pressures as states.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    volume : float, m3
        Oil between each pump and its first valve; one litre is two metres of pipe with a bore of 25 mm.
    volume_between : float, m3
        Oil in the passage from the swing's bypass to the stick's valve.
    bulk_modulus : float, Pa
        Of the oil with the pipe around it.

    Raises
    ------
    InputError
        If one of them is not positive and finite.
    """
    machine = as_excavator(machine)
    boom, series = (prepare_pump(machine, flow) for flow in (machine.pumps.boom_flow, machine.pumps.series_flow))
    first, between = compliances(volume, volume_between, bulk_modulus)
    return StiffFlow(prepare_valves(machine), boom, series, first, between)


def compliances(volume: float, volume_between: float, bulk_modulus: float) -> tuple[float, float]:
    """Compliances in m3/Pa of the two volumes, with every number checked."""
    for name, value, unit in (
        ("volume", volume, "m3"),
        ("volume_between", volume_between, "m3"),
        ("bulk_modulus", bulk_modulus, "Pa"),
    ):
        if not (isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value} {unit}: must be positive and finite; flow 'exact' has no volumes")
    return volume / bulk_modulus, volume_between / bulk_modulus


class _Source(NamedTuple):
    """A pump with the volume behind it, over one step: the pump's flow is q_pump - slope (P - p)."""

    p: float
    q_pump: float
    slope: float
    feed: Feed


class _Boom(NamedTuple):
    q_in: float
    circuit: Circuit


class _Series(NamedTuple):
    q_first: float
    q_second: float
    p_between: float
    circuit: Circuit


@kernel
def _constant(pump: Pump, p_before: float, z: float) -> _Source:
    return _Source(0.0, pump.flow, 0.0, Feed(p_before + z * pump.flow, z))


@kernel
def _limited(p: float, pump: Pump, p_before: float, z: float) -> _Source:
    """Tangent of the torque limit at the pressure `p`."""
    p = min(max(p, pump.limit_start), pump.relief)
    q = delivered(p, pump)
    slope = pump.limit_exponent * q / p
    share = 1.0 / (1.0 + z * slope)
    return _Source(p, q, slope, Feed((p_before + z * (q + slope * p)) * share, z * share))


@kernel
def _circuit(source: _Source, flow: float, q_bypass: float, p_before: float, z: float, pump: Pump) -> Circuit:
    """Pump, relief and what charges the pump's volume, of which a valve draws `flow`."""
    p = source.feed.pressure - source.feed.impedance * flow
    relieved = p > pump.relief
    p = min(p, pump.relief)
    q_pump = source.q_pump - source.slope * (p - source.p)
    q_stored = (p - p_before) / z if relieved else q_pump - flow
    return Circuit(q_pump, q_bypass, q_pump - flow - q_stored, p, q_stored)


@kernel
def _boom_step(k: Orifices, p_in: float, p_before: float, compliance: float, pump: Pump, dt: float) -> _Boom:
    z = dt / compliance
    bypass = Bypass(pump.p_return, 0.0, k.bypass * k.bypass)
    most = relieved_flow(k.inlet, p_in, bypass, pump.relief)
    source = _constant(pump, p_before, z)
    flow = at_most(source.feed, k.inlet, p_in, bypass)
    for _ in range(DRAW_PASSES):
        flow = draw_pass(flow, source.feed, k.inlet, p_in, bypass).flow
    flow = min(flow, most)
    p = source.feed.pressure - z * flow
    if pump.log_least < 0.0 and p > pump.limit_start:
        for _ in range(LIMITED_PASSES):
            source = _limited(p, pump, p_before, z)
            flow = min(draw_pass(flow, source.feed, k.inlet, p_in, bypass).flow, most)
            p = source.feed.pressure - source.feed.impedance * flow
    q = inlet_part(flow, k.inlet, p_in, bypass)
    return _Boom(q, _circuit(source, flow, flow - q, p_before, z, pump))


class _Between(NamedTuple):
    """Where the passes of the series circuit stand: flows into the first valve, between the valves, into the second.

    `step` is the last change of the flow between them.
    """

    first: float
    between: float
    second: float
    step: float


class _Volumes(NamedTuple):
    """Pressures before the step, and dt / C, of the pump's volume and the one between the valves."""

    p: float
    p_between: float
    z: float
    z_between: float


@kernel
def _behind(d: Draw, w: float, passage: Feed, square: float) -> Bypass:
    """Return the first bypass with the volume and the valve behind it, as one resistance and orifice."""
    z = passage.impedance
    steep = d.resistance + 2.0 * d.curve * d.flow
    share = z / (steep + z)  # how the flow into the second valve follows that between the two
    shut = d.flow <= 0.0
    slope = z if shut else steep * share
    curve = 0.0 if shut else min(d.curve * share * share * share, 0.5 * slope / (w + TRICKLE))
    resistance = slope - 2.0 * w * curve
    p = passage.pressure - z * d.flow
    return Bypass(p - w * (resistance + w * curve), resistance, 1.0 / (1.0 / (square + SHUT) + curve))


@kernel
def _series_pass(
    x: _Between, feed: Feed, at: _Volumes, first: Orifices, second: Orifices, p_in: Links, pump: Pump
) -> _Between:
    """One Newton step in the flow between the valves, with both valves osculated twice."""
    passage = Feed(at.p_between + at.z_between * x.between, at.z_between)
    onward = Bypass(pump.p_return, 0.0, second.bypass * second.bypass)
    d = draw_pass(x.second, passage, second.inlet, p_in.stick, onward)
    d = draw_pass(d.flow, passage, second.inlet, p_in.stick, onward)
    behind = _behind(d, x.between, passage, first.bypass * first.bypass)
    flow = draw_pass(x.first, feed, first.inlet, p_in.swing, behind).flow
    flow = draw_pass(flow, feed, first.inlet, p_in.swing, behind).flow
    flow = min(flow, relieved_flow(first.inlet, p_in.swing, behind, pump.relief))
    step = flow - inlet_part(flow, first.inlet, p_in.swing, behind) - x.between
    swings = step * x.step < 0.0 and abs(step) > 0.5 * abs(x.step)  # around a kink, which Newton steps may do for ever
    step = 0.5 * step if swings else step
    return _Between(flow, x.between + step, d.flow, step)


@kernel
def _series_step(first: Orifices, second: Orifices, p_in: Links, at: _Volumes, pump: Pump) -> _Series:
    onward = Bypass(pump.p_return, 0.0, second.bypass * second.bypass)
    source = _constant(pump, at.p, at.z)
    w = orifice_flow(first.bypass, at.p - at.p_between)
    passage = Feed(at.p_between + at.z_between * w, at.z_between)
    begin = Bypass(at.p_between, 0.0, first.bypass * first.bypass)
    x = _Between(
        at_most(source.feed, first.inlet, p_in.swing, begin), w, at_most(passage, second.inlet, p_in.stick, onward), 0.0
    )
    for _ in range(SERIES_PASSES):
        x = _series_pass(x, source.feed, at, first, second, p_in, pump)
    p = source.feed.pressure - at.z * x.first
    if pump.log_least < 0.0 and p > pump.limit_start:
        for _ in range(LIMITED_PASSES):
            source = _limited(p, pump, at.p, at.z)
            x = _series_pass(x, source.feed, at, first, second, p_in, pump)
            p = source.feed.pressure - source.feed.impedance * x.first

    passage = Feed(at.p_between + at.z_between * x.between, at.z_between)
    drawn = draw_pass(x.second, passage, second.inlet, p_in.stick, onward).flow
    q_second = inlet_part(drawn, second.inlet, p_in.stick, onward)
    c = _circuit(source, x.first, drawn - q_second, at.p, at.z, pump)
    circuit = Circuit(c.q_pump, c.q_bypass, c.q_relief, c.p_pump, c.q_stored + x.between - drawn)
    return _Series(max(x.first - x.between, 0.0), q_second, passage.pressure - at.z_between * drawn, circuit)


@kernel
def stiff_step(model: StiffFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Advance the pump pressures by `dt`; `memory` keeps the three of them in Pa, and whether there are any yet.

    The first step begins with the pressures at which nothing charges the volumes.
    """
    swing = orifices(spool.swing, model.valves.swing)
    boom = orifices(spool.boom, model.valves.boom)
    stick = orifices(spool.stick, model.valves.stick)
    if memory[3] == 0.0:
        still = series_circuit(swing, stick, p_in.swing, p_in.stick, model.series_pump)
        memory[0] = single_circuit(boom, p_in.boom, model.boom_pump).circuit.p_pump
        memory[1], memory[2], memory[3] = still.circuit.p_pump, still.p_between, 1.0
    single = _boom_step(boom, p_in.boom, memory[0], model.compliance, model.boom_pump, dt)
    at = _Volumes(memory[1], memory[2], dt / model.compliance, dt / model.compliance_between)
    series = _series_step(swing, stick, p_in, at, model.series_pump)
    memory[0], memory[1], memory[2] = single.circuit.p_pump, series.circuit.p_pump, series.p_between
    return Flows(
        Links(series.q_first, single.q_in, series.q_second),
        Links(swing.outlet, boom.outlet, stick.outlet),
        single.circuit,
        series.circuit,
        series.p_between,
        OK,
    )
