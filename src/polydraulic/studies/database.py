"""Training databases: a circuit evaluated at random points of its operating box."""

from typing import Any

import numpy as np

from polydraulic import units
from polydraulic.errors import InputError
from polydraulic.flow import exact_flow
from polydraulic.flow.sample import FlowSample, sample_flow
from polydraulic.parameters import LINKS, Machine
from polydraulic.tables import Table

PRESSURE_HIGH = units.to_si(4000.0, "psi")  # upper end of the thesis' maps

CIRCUITS = ("boom",)


def sample_boom(
    machine: Machine,
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
    machine : Machine
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
        ``boom.root_p_out`` = sqrt(P_o - P_e); outputs ``boom.q_in``, ``boom.q_out``, ``boom.p_pump``.

    Raises
    ------
    InputError
        If `n` is not positive.
    """
    if n < 1:
        raise InputError(f"rows = {n}: must be at least 1")
    low, high = (0.0, machine.spool.knots[-1]) if travel is None else travel
    distance = rng.uniform(low, high, n)
    spool = distance * rng.choice((-1.0, 1.0), n)
    p_in, p_out = rng.uniform(*pressure, n), rng.uniform(*pressure, n)
    return boom_table(machine, spool, p_in, p_out, relief=relief)


def boom_table(
    machine: Machine, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray, *, relief: bool = True
) -> Table:
    """Build the database at given points.

    Parameters
    ----------
    machine : Machine
    spool : (n_point,) array, m
    p_in, p_out : (n_point,) array, Pa
    relief : bool
        As for `sample_boom`.
    """
    flow = boom_flow(exact_flow(machine, relief=relief), spool, p_in, p_out)
    root = np.sqrt(np.maximum(p_out - machine.tank.return_pressure, 0.0))
    columns = {
        "boom.spool": (spool, "m"),
        "boom.travel": (np.abs(spool), "m"),
        "boom.p_in": (p_in, "Pa"),
        "boom.p_out": (p_out, "Pa"),
        "boom.root_p_out": (root, "Pa^0.5"),
        "boom.q_in": (flow.q_in, "m3/s"),
        "boom.q_out": (flow.k_out * root, "m3/s"),
        "boom.p_pump": (flow.p_pump, "Pa"),
    }
    info: dict[str, object] = {"circuit": "boom", "relief": relief}
    return Table({k: v for k, (v, _) in columns.items()}, {k: u for k, (_, u) in columns.items()}, info)


def boom_flow(model: Any, spool: np.ndarray, p_in: np.ndarray, p_out: np.ndarray) -> FlowSample:
    """Flows of the boom's valve at points (n_point,), with the others centred; arrays of shape (n_point,)."""
    place = LINKS.index("boom")
    columns = []
    for values in (spool, p_in, p_out):
        columns.append(np.zeros((len(values), len(LINKS))))
        columns[-1][:, place] = values
    sample = sample_flow(model, *columns)
    return FlowSample(sample.q_in[:, place], sample.k_out[:, place], sample.p_pump[:, 0])
