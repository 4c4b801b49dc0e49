"""Training databases: a circuit evaluated at random points of its operating box."""

from pathlib import Path
from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow.exact import exact_flow
from polydraulic.flow.layout.database import Column, database_table, sample_circuit, valve_columns
from polydraulic.flow.sample import FlowSample, sample_flow
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_excavator, as_machine
from polydraulic.parameters.schema import CIRCUITS, LINKS, Machine
from polydraulic.tables import Table

PRESSURE_HIGH = units.to_si(4000.0, "psi")  # upper end of the thesis' maps


def sample_boom(
    machine: Machine | str | Path,
    n: int,
    *,
    rng: np.random.Generator,
    travel: tuple[float, float] | None = None,
    pressure: tuple[float, float] = (0.0, PRESSURE_HIGH),
    relief: bool = True,
) -> Table:
    """Random database of the boom circuit, uniform in spool displacement (both signs) and line pressures.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    n : int
        Number of rows.
    rng : numpy Generator
    travel : (low, high), m, optional
        Range of the spool's distance from its centre; the whole travel if not given.
    pressure : (low, high), Pa
    relief : bool
        False for the ideal circuit of Eqs (1)-(3), whose pump has no relief valve.

    Returns
    -------
    Table
        Inputs ``boom.spool``, ``boom.travel`` (its absolute value), ``boom.p_in``, ``boom.p_out``,
        ``boom.root_p_out`` = sqrt(P_o - P_e); outputs ``boom.q_in``, ``boom.k_out``, ``boom.q_out``, ``boom.p_pump``.

    Raises
    ------
    InputError
        If `n` is not positive.
    """
    machine = as_excavator(machine)
    return boom_table(machine, *_points(machine, n, rng, travel, pressure), relief=relief)


def boom_table(
    machine: Machine | str | Path, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray, *, relief: bool = True
) -> Table:
    """Build the database at given points.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    spool : (n_point,) array, m
    p_in, p_out : (n_point,) array, Pa
    relief : bool
        As for `sample_boom`.
    """
    machine = as_excavator(machine)
    flow = boom_flow(exact_flow(machine, relief=relief), spool, p_in, p_out)
    columns = {
        **valve_columns("boom", spool, p_in, p_out, flow.q_in, flow.k_out, machine.tank.return_pressure),
        "boom.p_pump": (flow.p_pump, "Pa"),
    }
    return database_table(columns, "boom", relief)


def sample_series(
    machine: Machine | str | Path,
    n: int,
    *,
    rng: np.random.Generator,
    pressure: tuple[float, float] = (0.0, PRESSURE_HIGH),
    relief: bool = True,
) -> Table:
    """Random database of swing and stick, which share a pump; uniform in spool displacements and line pressures.

    Parameters
    ----------
    machine, n, rng, pressure, relief
        As for `sample_boom`.

    Returns
    -------
    Table
        The columns of `sample_boom` for ``swing`` and ``stick``, and of the circuit ``series.q_passed``, the flow that the
        swing leaves to the stick, and ``series.p_pump``.

    Raises
    ------
    InputError
        If `n` is not positive.
    """
    machine, links = as_excavator(machine), CIRCUITS["series"]
    places = [LINKS.index(link) for link in links]
    spool, p_in, p_out = np.zeros((3, max(n, 0), len(LINKS)))
    for place in places:
        spool[:, place], p_in[:, place], p_out[:, place] = _points(machine, n, rng, None, pressure)
    flow = sample_flow(exact_flow(machine, relief=relief), spool, p_in, p_out)
    columns: dict[str, Column] = {}
    for link, k in zip(links, places, strict=True):
        given = (spool[:, k], p_in[:, k], p_out[:, k], flow.q_in[:, k], flow.k_out[:, k])
        columns |= valve_columns(link, *given, machine.tank.return_pressure)
    # what passes the swing's valve goes into the stick or, through the last bypass, to the tank
    columns["series.q_passed"] = (flow.q_in[:, LINKS.index("stick")] + flow.q_bypass[:, 1], "m3/s")
    columns["series.p_pump"] = (flow.p_pump[:, 1], "Pa")
    return database_table(columns, "series", relief)


def circuit_database(
    machine: Machine | LayoutMachine | str | Path,
    circuit: str | None,
    n: int,
    *,
    rng: np.random.Generator,
    relief: bool = True,
) -> Table:
    """Random database of a circuit of any machine.

    Parameters
    ----------
    machine : Machine or LayoutMachine, or name or path of a parameter set
    circuit : str or None
        ``"boom"`` (if None) or ``"series"`` for the layout of cat215b; of other machines one of theirs, the only one if None.
    n, rng, relief
        As for `sample_boom`.

    Raises
    ------
    InputError
        If there is no such circuit, or several and none is named.
    """
    machine = as_machine(machine)
    if isinstance(machine, LayoutMachine):
        names = [c.name for c in machine.circuits]
        if circuit is None and len(names) > 1:
            raise InputError(f"the machine has the circuits {', '.join(names)}: say which one")
        return sample_circuit(machine, names[0] if circuit is None else circuit, n, rng=rng, relief=relief)
    samplers = {"boom": sample_boom, "series": sample_series}
    if circuit is not None and circuit not in samplers:
        raise InputError(f"unknown circuit {circuit!r}; choose one of {list(samplers)}")
    return samplers[circuit or "boom"](machine, n, rng=rng, relief=relief)


def boom_flow(model: Any, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray) -> FlowSample:
    """Flows of the boom's valve at points (n_point,), with the others centred; arrays of shape (n_point,)."""
    place = LINKS.index("boom")
    columns = []
    for values in (spool, p_in, p_out):
        columns.append(np.zeros((len(values), len(LINKS))))
        columns[-1][:, place] = values
    sample = sample_flow(model, *columns)
    return FlowSample(sample.q_in[:, place], sample.k_out[:, place], sample.p_pump[:, 0], sample.q_bypass[:, 0])


def _points(
    machine: Machine,
    n: int,
    rng: np.random.Generator,
    travel: tuple[float, float] | None,
    pressure: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random spool displacements of both signs, pressures at the pressurised port and at the outlet."""
    if n < 1:
        raise InputError(f"rows = {n}: must be at least 1")
    low, high = (0.0, machine.spool.knots[-1]) if travel is None else travel
    spool = rng.uniform(low, high, n) * rng.choice((-1.0, 1.0), n)
    return spool, rng.uniform(*pressure, n), rng.uniform(*pressure, n)
