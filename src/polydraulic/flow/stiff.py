"""Stiff flow: the pump pressures as states, Eq. (3'): C dP/dt = Q - Q_i - Q_e.

The oil in a pump's pipe, and in the passage between two valves, is a small volume whose pressure is
stepped by backward Euler: over a step a volume is a feed with the pressure P + Z Q and the impedance Z = dt / C. The valve of
one actuator then has the form of `machine.feed`. Two in series: Newton steps in the flow between the valves, with what
lies behind the first bypass as a resistance and an orifice that agree with it in pressure, slope and curvature. A
torque limit enters as the tangent of the pump's flow over pressure, which is convex, so that the steps come from one
side. All passes are fixed in number. As the volumes shrink, the flows approach those of `exact` in proportion to them.
"""

from math import isfinite
from pathlib import Path
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.machine.circuits.series.short import Series1, Series2, series_1, series_2
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
from polydraulic.machine.pump import Circuit, Pump, delivered
from polydraulic.machine.valve import Orifices, orifice_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

SERIES_PASSES = 6
LIMITED_PASSES = 8


class Volumes(NamedTuple):
    """Compliances in m3/Pa of a pump's pipe and of the passage between two valves."""

    compliance: float
    compliance_between: float


def stiff_flow(
    machine: LayoutMachine | str | Path,
    *,
    volume: float = 1e-3,
    volume_between: float = 2e-4,
    bulk_modulus: float = 1.0e9,
) -> LayoutFlow:
    """Flow model with the pump pressures as states, for circuits of one or two valves in series.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    volume : float, m3
        Oil between each pump and its first valve; one litre is two metres of pipe with a bore of 25 mm.
    volume_between : float, m3
        Oil in the passage from the bypass of a first valve to the second one.
    bulk_modulus : float, Pa
        Of the oil with the pipe around it.

    Raises
    ------
    InputError
        If one of them is not positive and finite, or a circuit has more valves.
    """
    machine = as_machine(machine)
    check_circuits(machine, "stiff")
    parts = {"volumes": compliances(volume, volume_between, bulk_modulus)}
    # a pressure before each valve, and whether there are any
    n_memory = sum(len(c.functions) for c in machine.circuits) + 1
    return LayoutFlow("stiff", "stiff", circuits_of(machine), machine.names, parts, n_memory, True)


def compliances(volume: float, volume_between: float, bulk_modulus: float) -> Volumes:
    """Compliances in m3/Pa of the two volumes, with every number checked."""
    for name, value, unit in (
        ("volume", volume, "m3"),
        ("volume_between", volume_between, "m3"),
        ("bulk_modulus", bulk_modulus, "Pa"),
    ):
        if not (isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value} {unit}: must be positive and finite; flow 'exact' has no volumes")
    return Volumes(volume / bulk_modulus, volume_between / bulk_modulus)


class _Source(NamedTuple):
    """A pump with the volume behind it, over one step: the pump's flow is q_pump - slope (P - p)."""

    p: float
    q_pump: float
    slope: float
    feed: Feed


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
def stiff_1(
    k_1: Orifices, p_1: float, p_before: float, begun: bool, pump: Pump, volumes: Volumes, dt: float
) -> Series1:
    """Flows of one valve over a step from the pump pressure `p_before`, or from that of steady flow if none has begun."""
    if not begun:
        p_before = series_1(k_1, p_1, pump).circuit.p_pump
    z = dt / volumes.compliance
    bypass = Bypass(pump.p_return, 0.0, k_1.bypass * k_1.bypass)
    most = relieved_flow(k_1.inlet, p_1, bypass, pump.relief)
    source = _constant(pump, p_before, z)
    flow = at_most(source.feed, k_1.inlet, p_1, bypass)
    for _ in range(DRAW_PASSES):
        flow = draw_pass(flow, source.feed, k_1.inlet, p_1, bypass).flow
    flow = min(flow, most)
    p = source.feed.pressure - z * flow
    if pump.log_least < 0.0 and p > pump.limit_start:
        for _ in range(LIMITED_PASSES):
            source = _limited(p, pump, p_before, z)
            flow = min(draw_pass(flow, source.feed, k_1.inlet, p_1, bypass).flow, most)
            p = source.feed.pressure - source.feed.impedance * flow
    q = inlet_part(flow, k_1.inlet, p_1, bypass)
    return Series1(q, _circuit(source, flow, flow - q, p_before, z, pump), 0)


class _Between(NamedTuple):
    """Where the passes of the series circuit stand: flows into the first valve, between the valves, into the second.

    `step` is the last change of the flow between them.
    """

    first: float
    between: float
    second: float
    step: float


class _Before(NamedTuple):
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
    x: _Between, feed: Feed, at: _Before, k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, pump: Pump
) -> _Between:
    """One Newton step in the flow between the valves, with both valves osculated twice."""
    passage = Feed(at.p_between + at.z_between * x.between, at.z_between)
    onward = Bypass(pump.p_return, 0.0, k_2.bypass * k_2.bypass)
    d = draw_pass(x.second, passage, k_2.inlet, p_2, onward)
    d = draw_pass(d.flow, passage, k_2.inlet, p_2, onward)
    behind = _behind(d, x.between, passage, k_1.bypass * k_1.bypass)
    flow = draw_pass(x.first, feed, k_1.inlet, p_1, behind).flow
    flow = draw_pass(flow, feed, k_1.inlet, p_1, behind).flow
    flow = min(flow, relieved_flow(k_1.inlet, p_1, behind, pump.relief))
    step = flow - inlet_part(flow, k_1.inlet, p_1, behind) - x.between
    swings = step * x.step < 0.0 and abs(step) > 0.5 * abs(x.step)  # around a kink, which Newton steps may do for ever
    step = 0.5 * step if swings else step
    return _Between(flow, x.between + step, d.flow, step)


@kernel
def stiff_2(
    k_1: Orifices,
    k_2: Orifices,
    p_1: float,
    p_2: float,
    p_before: float,
    p_between: float,
    begun: bool,
    pump: Pump,
    volumes: Volumes,
    dt: float,
) -> Series2:
    """Flows of two valves in series over a step from the pressures before and between them, or from those of steady flow if none have begun."""
    if not begun:
        still = series_2(k_1, k_2, p_1, p_2, pump)
        p_before, p_between = still.circuit.p_pump, still.p_between_1
    at = _Before(p_before, p_between, dt / volumes.compliance, dt / volumes.compliance_between)
    onward = Bypass(pump.p_return, 0.0, k_2.bypass * k_2.bypass)
    source = _constant(pump, at.p, at.z)
    w = orifice_flow(k_1.bypass, at.p - at.p_between)
    passage = Feed(at.p_between + at.z_between * w, at.z_between)
    begin = Bypass(at.p_between, 0.0, k_1.bypass * k_1.bypass)
    x = _Between(at_most(source.feed, k_1.inlet, p_1, begin), w, at_most(passage, k_2.inlet, p_2, onward), 0.0)
    for _ in range(SERIES_PASSES):
        x = _series_pass(x, source.feed, at, k_1, k_2, p_1, p_2, pump)
    p = source.feed.pressure - at.z * x.first
    if pump.log_least < 0.0 and p > pump.limit_start:
        for _ in range(LIMITED_PASSES):
            source = _limited(p, pump, at.p, at.z)
            x = _series_pass(x, source.feed, at, k_1, k_2, p_1, p_2, pump)
            p = source.feed.pressure - source.feed.impedance * x.first

    passage = Feed(at.p_between + at.z_between * x.between, at.z_between)
    drawn = draw_pass(x.second, passage, k_2.inlet, p_2, onward).flow
    q_second = inlet_part(drawn, k_2.inlet, p_2, onward)
    c = _circuit(source, x.first, drawn - q_second, at.p, at.z, pump)
    circuit = Circuit(c.q_pump, c.q_bypass, c.q_relief, c.p_pump, c.q_stored + x.between - drawn)
    return Series2(max(x.first - x.between, 0.0), q_second, passage.pressure - at.z_between * drawn, circuit, 0)
