"""Transmission-line flow: pump, valves and passage joined by lines that waves need time to cross.

A line between two components is its two ends: P = c + Z Q, with Q the flow into the line, Z its characteristic impedance
and c the wave that arrives. The wave that leaves one end, P + Z Q = 2 P - c, arrives at the other a delay later, so that
within a substep the components do not know of each other and each is solved on its own, in the closed form of an
orifice between impedances (`machine.feed`). A volume V of oil counts as a line whose delay is a substep: Z = dt beta /
(V (1 - alpha)). The low pass c = alpha c + (1 - alpha) c_arriving damps standing waves without losing oil
(the formulation of Krus, Jansson, Palmberg and Weddfelt, as in HOPSAN).

Pump -> line -> swing valve -> line -> stick valve, and pump -> line -> boom valve. No line end falls below the make-up floor or
rises above the relief setting. As volumes and substep shrink together, the flows approach those of `exact`.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.exact import Valves, prepare_valves
from polydraulic.flow.interface import OK, Flows
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.stiff import compliances
from polydraulic.machine.feed import Bypass, Drawn, Feed, draw
from polydraulic.machine.pump import Circuit, Pump, delivered, prepare_pump, series_circuit, single_circuit
from polydraulic.machine.state import Links
from polydraulic.machine.valve import Orifices, orifices
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import Machine

_LIMIT_PASSES = 5


class TlmFlow(NamedTuple):
    """Orifice tables, pumps, compliances in m3/Pa of the lines, low pass, make-up floor in Pa, substeps per step."""

    valves: Valves
    boom_pump: Pump
    series_pump: Pump
    compliance: float
    compliance_between: float
    alpha: float
    floor: float
    substeps: int


def tlm_flow(
    machine: Machine | str | Path,
    *,
    volume: float = 1e-3,
    volume_between: float = 2e-4,
    bulk_modulus: float = 1.0e9,
    alpha: float = 0.1,
    substeps: int = 4,
) -> TlmFlow:
    """Flow model of transmission lines.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    volume, volume_between, bulk_modulus : float
        As for flow ``stiff``.
    alpha : float
        Low pass of the waves, in [0, 1); without it, lines of little volume ring.
    substeps : int
        Wave delays in a time step.

    Raises
    ------
    InputError
        If a setting is out of its range.
    """
    machine = as_excavator(machine)
    _check_waves(alpha, substeps)
    boom, series = (prepare_pump(machine, flow) for flow in (machine.pumps.boom_flow, machine.pumps.series_flow))
    first, between = compliances(volume, volume_between, bulk_modulus)
    return TlmFlow(prepare_valves(machine), boom, series, first, between, alpha, machine.tank.floor, substeps)


class TlmLines(NamedTuple):
    """Compliances in m3/Pa of lines, low pass, make-up floor in Pa, substeps per step."""

    compliance: float
    compliance_between: float
    alpha: float
    floor: float
    substeps: int


def tlm_layout(
    machine: LayoutMachine,
    *,
    volume: float = 1e-3,
    volume_between: float = 2e-4,
    bulk_modulus: float = 1.0e9,
    alpha: float = 0.1,
    substeps: int = 4,
) -> LayoutFlow:
    """`tlm_flow` for a machine of any layout whose circuits are valves in series: a line before each valve.

    Parameters
    ----------
    machine : LayoutMachine
    volume, volume_between, bulk_modulus, alpha, substeps
        As for `tlm_flow`.

    Raises
    ------
    InputError
        If a setting is out of its range, or a circuit is of another kind.
    """
    check_circuits(machine, "tlm")
    _check_waves(alpha, substeps)
    volumes = compliances(volume, volume_between, bulk_modulus)
    parts = {"tlm_lines": TlmLines(*volumes, alpha, machine.tank.floor, substeps)}
    n_memory = 2 * sum(len(c.functions) for c in machine.circuits) + 1  # waves, and whether there are any
    return LayoutFlow("tlm", "tlm", circuits_of(machine), machine.names, parts, n_memory, True)


def _check_waves(alpha: float, substeps: int) -> None:
    if not 0.0 <= alpha < 1.0:
        raise InputError(f"alpha = {alpha}: must lie in [0, 1), for example 0.1")
    if not isinstance(substeps, int) or substeps < 1:
        raise InputError(f"substeps = {substeps!r}: must be a whole number, at least 1")


class PumpEnd(NamedTuple):
    """A pump at its end of a line."""

    p: float
    wave: float  # that arrives there, no lower than the make-up valves allow
    q_pump: float
    q_relief: float


class _Sums(NamedTuple):
    """Oil in m3 that has passed since the step began, and the last pressures."""

    pump: float
    first: float
    second: float
    bypass: float
    relief: float
    stored: float
    p: float
    p_between: float


@kernel
def pump_end(wave: float, z: float, pump: Pump, floor: float) -> PumpEnd:
    """P = c + Z (Q - q_relief), with a torque limit by its tangents: it is convex, so that they come from one side."""
    q = pump.flow
    if pump.log_least < 0.0 and wave + z * q > pump.limit_start:
        p = pump.limit_start
        for _ in range(_LIMIT_PASSES):
            q = delivered(p, pump)
            slope = pump.limit_exponent * q / p
            p = min(max((wave + z * (q + slope * p)) / (1.0 + z * slope), pump.limit_start), pump.relief)
        q = delivered(p, pump)
    wave = max(wave, floor - z * q)
    p = wave + z * q
    return PumpEnd(min(p, pump.relief), wave, q, max(p - pump.relief, 0.0) / z)


class Onward(NamedTuple):
    """A valve between two lines, and the wave that arrives at the near end of the second, no lower than the make-up valves allow."""

    drawn: Drawn
    wave: float


@kernel
def draw_onward(feed: Feed, k: Orifices, p_in: float, wave: float, z: float, floor: float, relief: float) -> Onward:
    """What a valve draws from the end of one line and passes into the next, of impedance `z`, where `wave` arrives."""
    b = k.bypass * k.bypass
    d = draw(feed, k.inlet, p_in, Bypass(wave, z, b), relief)
    if wave + z * d.q_bypass < floor:
        d = draw(feed, k.inlet, p_in, Bypass(floor, 0.0, b), relief)
        wave = floor - z * d.q_bypass
    return Onward(d, wave)


@kernel
def _boom(near: float, far: float, memory: np.ndarray, k: Orifices, p_in: float, model: TlmFlow, dt: float) -> _Sums:
    """One line; `memory` receives the waves that arrive at the pump and at the valve."""
    pump, keep = model.boom_pump, 1.0 - model.alpha
    z = dt / (model.compliance * keep)
    bypass = Bypass(pump.p_return, 0.0, k.bypass * k.bypass)
    x = _Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(model.substeps):
        end = pump_end(near, z, pump, model.floor)
        far = max(far, model.floor)
        d = draw(Feed(far, z), k.inlet, p_in, bypass, pump.relief)
        held = end.wave + far
        near = model.alpha * end.wave + keep * (2.0 * d.p - far)
        far = model.alpha * far + keep * (2.0 * end.p - end.wave)
        x = _Sums(
            x.pump + dt * end.q_pump,
            x.first + dt * d.q_in,
            0.0,
            x.bypass + dt * d.q_bypass,
            x.relief + dt * (end.q_relief + d.q_relief),
            x.stored + 0.5 * model.compliance * (near + far - held),
            d.p,
            0.0,
        )
    memory[0], memory[1] = near, far
    return x


class _Waves(NamedTuple):
    """Waves that arrive: at the pump, at the first valve, and at both ends of the passage to the second."""

    near: float
    far: float
    passage_near: float
    passage_far: float


@kernel
def _series(
    c: _Waves, memory: np.ndarray, first: Orifices, second: Orifices, p_in: Links, model: TlmFlow, dt: float
) -> _Sums:
    """Two lines; `memory` receives the waves."""
    pump, alpha, keep, floor = model.series_pump, model.alpha, 1.0 - model.alpha, model.floor
    z, z_passage = dt / (model.compliance * keep), dt / (model.compliance_between * keep)
    onward = Bypass(pump.p_return, 0.0, second.bypass * second.bypass)
    x = _Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for _ in range(model.substeps):
        end = pump_end(c.near, z, pump, floor)
        far = max(c.far, floor)
        onto = draw_onward(Feed(far, z), first, p_in.swing, c.passage_near, z_passage, floor, pump.relief)
        d, passage_near = onto.drawn, onto.wave
        p_near = passage_near + z_passage * d.q_bypass
        passage_far = max(c.passage_far, floor)
        e = draw(Feed(passage_far, z_passage), second.inlet, p_in.stick, onward, pump.relief)

        c = _Waves(
            alpha * end.wave + keep * (2.0 * d.p - far),
            alpha * far + keep * (2.0 * end.p - end.wave),
            alpha * passage_near + keep * (2.0 * e.p - passage_far),
            alpha * passage_far + keep * (2.0 * p_near - passage_near),
        )
        gained = model.compliance * (c.near + c.far - end.wave - far)
        gained += model.compliance_between * (c.passage_near + c.passage_far - passage_near - passage_far)
        x = _Sums(
            x.pump + dt * end.q_pump,
            x.first + dt * d.q_in,
            x.second + dt * e.q_in,
            x.bypass + dt * e.q_bypass,
            x.relief + dt * (end.q_relief + d.q_relief + e.q_relief),
            x.stored + 0.5 * gained,
            d.p,
            e.p,
        )
    memory[2], memory[3], memory[4], memory[5] = c.near, c.far, c.passage_near, c.passage_far
    return x


@kernel
def _still(
    memory: np.ndarray, swing: Orifices, boom: Orifices, stick: Orifices, p_in: Links, m: TlmFlow, dt: float
) -> None:
    """Waves of steady flow."""
    z = dt / (m.compliance * (1.0 - m.alpha))
    z_passage = dt / (m.compliance_between * (1.0 - m.alpha))
    single = single_circuit(boom, p_in.boom, m.boom_pump).circuit
    series = series_circuit(swing, stick, p_in.swing, p_in.stick, m.series_pump)
    pair, w = series.circuit, series.circuit.q_bypass + series.q_second
    memory[0], memory[1] = single.p_pump - z * single.q_pump, single.p_pump + z * single.q_pump
    memory[2], memory[3] = pair.p_pump - z * pair.q_pump, pair.p_pump + z * pair.q_pump
    memory[4], memory[5] = series.p_between - z_passage * w, series.p_between + z_passage * w


@kernel
def _mean(x: _Sums, dt: float) -> Circuit:
    return Circuit(x.pump / dt, x.bypass / dt, x.relief / dt, x.p, x.stored / dt)


@kernel
def tlm_step(model: TlmFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Let the waves run for `dt`: mean flows, and the pressures at the valves in the last substep.

    `memory` keeps six waves in Pa, and whether there are any yet; the first step begins with those of steady flow.
    """
    swing = orifices(spool.swing, model.valves.swing)
    boom = orifices(spool.boom, model.valves.boom)
    stick = orifices(spool.stick, model.valves.stick)
    delay = dt / model.substeps
    if memory[6] == 0.0:
        _still(memory, swing, boom, stick, p_in, model, delay)
        memory[6] = 1.0
    single = _boom(memory[0], memory[1], memory, boom, p_in.boom, model, delay)
    waves = _Waves(memory[2], memory[3], memory[4], memory[5])
    series = _series(waves, memory, swing, stick, p_in, model, delay)
    return Flows(
        Links(series.first / dt, single.first / dt, series.second / dt),
        Links(swing.outlet, boom.outlet, stick.outlet),
        _mean(single, dt),
        _mean(series, dt),
        series.p_between,
        OK,
    )
