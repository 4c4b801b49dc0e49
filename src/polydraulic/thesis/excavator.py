"""The thesis' machine: what its three links, two pumps and equal spools are called, and its circuits at any points."""

from typing import Any, NamedTuple

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow.dispatch import FlowModel
from polydraulic.flow.layout.database import database_table, valve_columns
from polydraulic.machine.pump import NEVER
from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.parts import PumpParameters
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.flow_points import FlowSample, sample_flow
from polydraulic.tables import Table

LINKS = ("swing", "boom", "stick")
SERIES = ("swing", "stick")  # that share a pump, from it on
PRESSURE_HIGH = units.to_si(4000.0, "psi")  # upper end of the thesis' maps


class SpoolMarks(NamedTuple):
    """Travels in m at which all valves open, at which all bypasses are shut, and at which spools end."""

    deadband: float
    bypass_closed: float
    end: float


def as_excavator(machine: LayoutMachine | str) -> LayoutMachine:
    """Return a machine, or load it by name or path, if it is one of the thesis' layout.

    Raises
    ------
    InputError
        Other functions or circuits than those of cat215b, or spools that differ.
    """
    found = as_machine(machine)
    circuits = {c.name: c.functions for c in found.circuits}
    if found.names != LINKS or circuits != {"boom": ("boom",), "series": SERIES}:
        raise InputError(
            f"{found.title!r} has the functions {', '.join(found.names)}; the thesis' chapters are about the layout of 'cat215b' alone "
            "(swing, boom and stick on two pumps)"
        )
    if len({(spool_edges(f.valve), f.valve.knots[-1]) for f in found.functions}) > 1:
        raise InputError(
            f"{found.title!r}: the thesis' chapters need spools that open, shut their bypass and end alike"
        )
    return found


def spool_of(machine: LayoutMachine) -> SpoolMarks:
    """Marks of the spools, which are alike."""
    valve = machine.functions[0].valve
    return SpoolMarks(*spool_edges(valve), valve.knots[-1])


def pump_of(machine: LayoutMachine, circuit: str) -> PumpParameters:
    """The pump of a circuit."""
    return machine.circuit(circuit).pump


def with_pumps(machine: LayoutMachine, **values: Any) -> LayoutMachine:
    """The machine with other values of both pumps."""
    return machine._replace(circuits=tuple(c._replace(pump=c.pump._replace(**values)) for c in machine.circuits))


def without_relief(machine: LayoutMachine) -> LayoutMachine:
    """The machine of Eqs (1)-(3) and (8)-(13), whose pumps have no relief valve."""
    return with_pumps(machine, relief=NEVER)


def boom_flow(
    machine: LayoutMachine, flow: str | FlowModel, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray
) -> FlowSample:
    """Flows of the boom's valve at points (n_point,), with the others centred; arrays of shape (n_point,)."""
    place = machine.names.index("boom")
    columns = []
    for values in (spool, p_in, p_out):
        columns.append(np.zeros((len(values), len(machine.names))))
        columns[-1][:, place] = values
    sample = sample_flow(machine, flow, *columns)
    return FlowSample(sample.q_in[:, place], sample.k_out[:, place], sample.p_pump[:, 0], sample.q_bypass[:, 0])


def boom_table(
    machine: LayoutMachine, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray, *, relief: bool = True
) -> Table:
    """Database of the boom circuit at given points.

    Parameters
    ----------
    machine : LayoutMachine
    spool : (n_point,) array, m
    p_in, p_out : (n_point,) array, Pa
    relief : bool
        False for the ideal circuit of Eqs (1)-(3).

    Returns
    -------
    Table
        Inputs ``boom.spool``, ``boom.travel`` (its absolute value), ``boom.p_in``, ``boom.p_out``,
        ``boom.root_p_out`` = sqrt(P_o - P_e); outputs ``boom.q_in``, ``boom.k_out``, ``boom.q_out``, ``boom.p_pump``.
    """
    flow = boom_flow(machine if relief else without_relief(machine), "exact", spool, p_in, p_out)
    columns = {
        **valve_columns("boom", spool, p_in, p_out, flow.q_in, flow.k_out, machine.tank.return_pressure),
        "boom.p_pump": (flow.p_pump, "Pa"),
    }
    return database_table(columns, "boom", relief)


def sample_boom(
    machine: LayoutMachine,
    n: int,
    *,
    rng: np.random.Generator,
    travel: tuple[float, float] | None = None,
    pressure: tuple[float, float] = (0.0, PRESSURE_HIGH),
    relief: bool = True,
) -> Table:
    """`boom_table` at random points, uniform in spool displacement (both signs) and line pressures.

    Parameters
    ----------
    machine : LayoutMachine
    n : int
        Number of rows.
    rng : numpy Generator
    travel : (low, high), m, optional
        Range of the spool's distance from its centre; the whole travel if not given.
    pressure : (low, high), Pa
    relief : bool
        As for `boom_table`.
    """
    low, high = (0.0, spool_of(machine).end) if travel is None else travel
    spool = rng.uniform(low, high, n) * rng.choice((-1.0, 1.0), n)
    return boom_table(machine, spool, rng.uniform(*pressure, n), rng.uniform(*pressure, n), relief=relief)
