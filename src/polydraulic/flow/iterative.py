"""Iterative flow: the thesis' way, pump pressure -> flows -> pump pressure, until the pressure settles within `eps`.

One valve: a sweep inserts the pressure into Eq. (1), takes the bypass flow from Eq. (3) and the next pressure from Eq. (2). Its slope is
-(Q_e / Q_i)(K a_i / K a_e)^2, so that the plain sweep (relaxation 1) converges only while the bypass is wide; with
relaxation r it converges while that slope stays above 1 - 2/r. Two valves in series: the same with two
pressures, before and between the valves, Eqs (8)-(13). The number of sweeps is bounded; a step that reaches the bound reports NOT_CONVERGED and
uses what it has.
"""

from pathlib import Path
from typing import NamedTuple

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.layout.model import LayoutFlow, check_circuits, circuits_of
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.circuits.series.short import Series1, Series2
from polydraulic.machine.pump import Circuit, Pump, delivered
from polydraulic.machine.valve import Orifices, orifice_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine


class Sweeps(NamedTuple):
    """How to iterate: largest relative change at which a sweep is the last, share of a change that is made, sweeps at most."""

    eps: float
    relaxation: float
    max_sweeps: int


def iterative_flow(
    machine: LayoutMachine | str | Path, *, eps: float = 0.05, relaxation: float = 0.2, max_sweeps: int = 200
) -> LayoutFlow:
    """Flow model that iterates on the pump pressure, for circuits of one or two valves in series.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    eps : float
        Largest relative change of the pump pressure at which a sweep counts as the last (thesis 5.4: 0.05).
    relaxation : float
        Share of a sweep's pressure change that is made, in (0, 1].
    max_sweeps : int
        Maximum number of sweeps per step.

    Raises
    ------
    InputError
        If a setting is out of its range, or a circuit has more valves.
    """
    machine = as_machine(machine)
    check_circuits(machine, "iterative")
    parts = {"sweeps": _checked(eps, relaxation, max_sweeps)}
    n_memory = sum(len(c.functions) for c in machine.circuits)  # a pressure before each valve
    return LayoutFlow("iterative", "iterative", circuits_of(machine), machine.names, parts, n_memory, True)


def _checked(eps: float, relaxation: float, max_sweeps: int) -> Sweeps:
    if not 0.0 < eps < 1.0:
        raise InputError(f"eps = {eps}: must lie between 0 and 1, for example 0.05")
    if not 0.0 < relaxation <= 1.0:
        raise InputError(f"relaxation = {relaxation}: must lie in (0, 1]")
    if max_sweeps < 1:
        raise InputError(f"max_sweeps = {max_sweeps}: must be at least 1")
    return Sweeps(eps, relaxation, max_sweeps)


class _Swept(NamedTuple):
    """Pressures where the sweeps end, before the valves and between them."""

    p: float
    p_between: float
    settled: bool


@kernel
def _sweep_single(k: Orifices, p_in: float, p: float, pump: Pump, how: Sweeps) -> _Swept:
    settled = False
    for _ in range(how.max_sweeps):
        Q = delivered(p, pump)
        q_in = min(orifice_flow(k.inlet, p - p_in), Q)
        root = (Q - q_in) / k.bypass if k.bypass > 0.0 else Q / (k.inlet + 1e-300)
        p_next = pump.p_return + root * root if k.bypass > 0.0 else p_in + root * root
        p_next = min(p_next, pump.relief)
        settled = abs(p_next - p) < how.eps * p
        p = p_next if (settled or k.bypass <= 0.0) else p + how.relaxation * (p_next - p)
        if settled:
            break
    return _Swept(p, 0.0, settled)


@kernel
def iterative_1(k_1: Orifices, p_1: float, p: float, pump: Pump, how: Sweeps) -> Series1:
    """Flows of one valve, by sweeps from the pump pressure `p` of the step before, 0 at first; the status is 0 if they settle."""
    found = _sweep_single(k_1, p_1, p if p > 0.0 else pump.p_return, pump, how)
    Q = delivered(found.p, pump)
    surplus = Q - min(orifice_flow(k_1.inlet, found.p - p_1), Q)
    at_relief = found.p >= pump.relief
    q_bypass = min(surplus, orifice_flow(k_1.bypass, found.p - pump.p_return)) if at_relief else surplus
    q_relief = surplus - q_bypass
    circuit = Circuit(Q, q_bypass, q_relief, found.p, 0.0)
    return Series1(Q - q_bypass - q_relief, circuit, 0 if found.settled else UNPROVED)


@kernel
def _sweep_series(
    first: Orifices,
    second: Orifices,
    p_first: float,
    p_second: float,
    p: float,
    p_between: float,
    pump: Pump,
    how: Sweeps,
) -> _Swept:
    r = how.relaxation
    settled = False
    for _ in range(how.max_sweeps):
        Q = delivered(p, pump)
        w = Q - min(orifice_flow(first.inlet, p - p_first), Q) if first.bypass > 0.0 else 0.0
        q_bypass = w - min(orifice_flow(second.inlet, p_between - p_second), w)
        root = (q_bypass / second.bypass) if second.bypass > 0.0 else w / (second.inlet + 1e-300)
        between = (pump.p_return if second.bypass > 0.0 else p_second) + root * root
        between = min(between, pump.relief)
        root = w / first.bypass if first.bypass > 0.0 else Q / (first.inlet + 1e-300)
        p_next = (between if first.bypass > 0.0 else p_first) + root * root
        p_next = min(p_next, pump.relief)
        settled = abs(p_next - p) < how.eps * p and abs(between - p_between) < how.eps * p_between
        p = p_next if (settled or first.bypass <= 0.0) else p + r * (p_next - p)
        p_between = between if (settled or second.bypass <= 0.0) else p_between + r * (between - p_between)
        if settled:
            break
    return _Swept(p, p_between, settled)


@kernel
def iterative_2(
    k_1: Orifices, k_2: Orifices, p_1: float, p_2: float, p: float, p_between: float, pump: Pump, how: Sweeps
) -> Series2:
    """Flows of two valves in series, by sweeps from the pressures of the step before, 0 at first; the status is 0 if they settle."""
    low = pump.p_return
    found = _sweep_series(k_1, k_2, p_1, p_2, p if p > 0.0 else low, p_between if p_between > 0.0 else low, pump, how)
    Q = delivered(found.p, pump)
    q_first = min(orifice_flow(k_1.inlet, found.p - p_1), Q)
    passing = orifice_flow(k_1.bypass, found.p - found.p_between)
    at_relief = found.p >= pump.relief or k_1.bypass <= 0.0
    w = min(Q - q_first, passing) if at_relief else Q - q_first
    q_second = min(orifice_flow(k_2.inlet, found.p_between - p_2), w)
    q_second = w if k_2.bypass <= 0.0 else q_second
    circuit = Circuit(Q, w - q_second, Q - q_first - w, found.p, 0.0)
    return Series2(q_first, q_second, found.p_between, circuit, 0 if found.settled else UNPROVED)
