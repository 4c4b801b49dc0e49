"""Transmission-line flow: pump, valves and passage joined by lines that waves need time to cross.

A line between two components is its two ends: P = c + Z Q, with Q the flow into the line, Z its characteristic impedance
and c the wave that arrives. The wave that leaves one end, P + Z Q = 2 P - c, arrives at the other a delay later, so that
within a substep the components do not know of each other and each is solved on its own, in the closed form of an
orifice between impedances (`machine.feed`). A volume V of oil counts as a line whose delay is a substep: Z = dt beta /
(V (1 - alpha)). The low pass c = alpha c + (1 - alpha) c_arriving damps standing waves without losing oil
(the formulation of Krus, Jansson, Palmberg and Weddfelt, as in HOPSAN).

Pump -> line -> first valve -> line -> second valve, and so on. No line end falls below the make-up floor or
rises above the relief setting. As volumes and substep shrink together, the flows approach those of `exact`.
"""

from pathlib import Path
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.flow.stiff import compliances
from polydraulic.machine.feed import Bypass, Drawn, Feed, draw
from polydraulic.machine.pump import Pump, delivered
from polydraulic.machine.valve import Orifices
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine

_LIMIT_PASSES = 5


class TlmLines(NamedTuple):
    """Compliances in m3/Pa of lines, low pass, make-up floor in Pa, substeps per step."""

    compliance: float
    compliance_between: float
    alpha: float
    floor: float
    substeps: int


def tlm_flow(
    machine: LayoutMachine | str | Path,
    *,
    volume: float = 1e-3,
    volume_between: float = 2e-4,
    bulk_modulus: float = 1.0e9,
    alpha: float = 0.1,
    substeps: int = 4,
) -> LayoutFlow:
    """Flow model of transmission lines, one before each valve of circuits in series.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    volume, volume_between, bulk_modulus : float
        As for flow ``stiff``.
    alpha : float
        Low pass of the waves, in [0, 1); without it, lines of little volume ring.
    substeps : int
        Wave delays in a time step.

    Raises
    ------
    InputError
        If a setting is out of its range, or a circuit is of another kind.
    """
    machine = as_machine(machine)
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
