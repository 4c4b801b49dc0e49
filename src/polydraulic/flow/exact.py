"""Exact flow: Eqs (1)-(3) and (8)-(13) by clamped closed forms, without branches or convergence tests."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from polydraulic._kernel import kernel
from polydraulic.errors import InputError
from polydraulic.flow.interface import OK, Flows, FlowSlopes
from polydraulic.machine.circuit_slopes import series_slopes, single_slopes
from polydraulic.machine.pump import NEVER, Pump, prepare_pump, series_circuit, single_circuit
from polydraulic.machine.state import Links
from polydraulic.machine.valve import ValveTables, orifice_slopes, orifices, prepare_valve
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.schema import Machine


class Valves(NamedTuple):
    """Orifice tables of the three main valves."""

    swing: ValveTables
    boom: ValveTables
    stick: ValveTables


class ExactFlow(NamedTuple):
    """Orifice tables, the boom's pump, and the pump of swing and stick in series."""

    valves: Valves
    boom_pump: Pump
    series_pump: Pump


def prepare_valves(machine: Machine) -> Valves:
    """Orifice tables of a machine, ready for evaluation."""
    return Valves(*(prepare_valve(link.valve, machine.spool) for link in (machine.swing, machine.boom, machine.stick)))


def exact_flow(machine: Machine | str | Path, *, relief: bool = True) -> ExactFlow:
    """Flow model from a machine's orifice tables.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    relief : bool
        Without it the pumps' relief valves never open: the ideal circuits of the equations, for maps.
    """
    machine = as_excavator(machine)
    setting = None if relief else NEVER
    boom, series = (
        prepare_pump(machine, flow, relief=setting) for flow in (machine.pumps.boom_flow, machine.pumps.series_flow)
    )
    return ExactFlow(prepare_valves(machine), boom, series)


def constant_boom_pump(machine: Machine) -> Pump:
    """Return the boom's pump for a model that does not know how a torque limit lowers its flow.

    Raises
    ------
    InputError
        If the machine's pumps have a torque limit.
    """
    if machine.pumps.torque_limit_enabled:
        raise InputError(
            "pumps.torque_limit_enabled = true: this flow model has no pump pressure to limit the torque by; "
            "set it to false or use flow 'exact' or 'iterative'"
        )
    return prepare_pump(machine, machine.pumps.boom_flow)


@kernel
def exact_step(model: ExactFlow, memory: np.ndarray, spool: Links, p_in: Links, p_out: Links, dt: float) -> Flows:
    """Solve both circuits."""
    swing = orifices(spool.swing, model.valves.swing)
    boom = orifices(spool.boom, model.valves.boom)
    stick = orifices(spool.stick, model.valves.stick)
    single = single_circuit(boom, p_in.boom, model.boom_pump)
    series = series_circuit(swing, stick, p_in.swing, p_in.stick, model.series_pump)
    return Flows(
        Links(series.q_first, single.q_in, series.q_second),
        Links(swing.outlet, boom.outlet, stick.outlet),
        single.circuit,
        series.circuit,
        series.p_between,
        OK,
    )


@kernel
def exact_slopes(model: ExactFlow, spool: Links, inside: Links, flows: Flows) -> FlowSlopes:
    """Slopes of `exact_step` at its solution `flows`; `inside` says on which segments of the orifice tables the spools are."""
    swing, boom, stick = model.valves.swing, model.valves.boom, model.valves.stick
    k_swing, k_boom, k_stick = orifices(spool.swing, swing), orifices(spool.boom, boom), orifices(spool.stick, stick)
    s_swing, s_stick = orifice_slopes(inside.swing, swing), orifice_slopes(inside.stick, stick)
    s_boom = orifice_slopes(inside.boom, boom)
    one = single_slopes(k_boom, s_boom, flows.q_in.boom, flows.boom, model.boom_pump)
    two = series_slopes(
        k_swing, k_stick, s_swing, s_stick, flows.q_in.swing, flows.q_in.stick, flows.series, model.series_pump
    )
    return FlowSlopes(
        Links(two.first_by_p, one.by_p, two.second_by_p),
        two.other_by_p,
        two.other_by_p,
        Links(two.first_by_first, one.by_spool, two.second_by_second),
        two.first_by_second,
        two.second_by_first,
        Links(s_swing.outlet, s_boom.outlet, s_stick.outlet),
    )
