"""Training databases of a circuit of any layout: its exact equations at random points of its operating box."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from polydraulic.errors import InputError
from polydraulic.flow.layout.circuit_sample import sample_valves
from polydraulic.flow.layout.slots import passed, pressure_before
from polydraulic.machine.pump import NEVER, limited_pump
from polydraulic.parameters.layout.parts import SupplyCircuit, ValveCurves
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.tables import Table

Column = tuple[np.ndarray, str]  # values and their unit


def sample_circuit(
    machine: LayoutMachine | str | Path,
    circuit: str | None,
    n: int,
    *,
    rng: np.random.Generator,
    pressure: tuple[float, float] | None = None,
    relief: bool = True,
) -> Table:
    """Random database of a circuit, uniform in spool displacements (both signs) and line pressures.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    circuit : str or None
        Name of a circuit; the first one of valves in series if None.
    n : int
        Number of rows.
    rng : numpy Generator
    pressure : (low, high), Pa, optional
        From 0 to the setting of the pump's relief valve if not given.
    relief : bool
        False for a pump without relief valve.

    Returns
    -------
    Table
        Of each function, for example lift, inputs ``lift.spool``, ``lift.travel`` (its absolute value), ``lift.p_in``, ``lift.p_out``,
        ``lift.root_p_out`` = sqrt(P_o - P_e), and outputs ``lift.q_in``, ``lift.k_out``, ``lift.q_out``; of the circuit, for example
        work, what passes a valve to the next one (``work.q_passed``, or ``work.q_passed_1`` and so on), the pressure between them (``work.p_between``, or ``work.p_between_1`` and so
        on), and ``work.p_pump``.

    Raises
    ------
    InputError
        If `n` is not positive, there is no such circuit, or it is not one of valves in series.
    """
    machine = as_machine(machine)
    first = [*series_circuits(machine), *machine.circuits][0]  # where none can be sampled, the refusal says why
    c = series_circuit_of(machine, first.name if circuit is None else circuit)
    if n < 1:
        raise InputError(f"rows = {n}: must be at least 1")
    valves = [machine.function(f).valve for f in c.functions]
    low, high = (0.0, c.pump.relief) if pressure is None else pressure
    spool = np.column_stack([rng.uniform(-v.knots[-1], v.knots[-1], n) for v in valves])
    p_in, p_out = rng.uniform(low, high, (2, n, len(valves)))
    return circuit_table(machine, c.name, spool, p_in, p_out, relief=relief)


def circuit_table(
    machine: LayoutMachine | str | Path,
    circuit: str,
    spool: np.ndarray,
    p_in: np.ndarray,
    p_out: np.ndarray,
    *,
    relief: bool = True,
) -> Table:
    """Database of a circuit at given points.

    Parameters
    ----------
    machine, circuit, relief
        As for `sample_circuit`.
    spool : (n_point, n_valve) array, m
        Displacements, valves counted from the pump.
    p_in, p_out : (n_point, n_valve) array, Pa
        At the pressurised ports and at the outlets.

    Returns
    -------
    Table
        The columns of `sample_circuit`.
    """
    machine = as_machine(machine)
    c = series_circuit_of(machine, circuit)
    spool, p_in, p_out = (np.asarray(values, dtype=np.float64) for values in (spool, p_in, p_out))
    if spool.ndim != 2 or spool.shape[1] != len(c.functions) or not spool.shape == p_in.shape == p_out.shape:
        raise InputError(
            f"spool, p_in and p_out have shapes {spool.shape}, {p_in.shape}, {p_out.shape}: each must be (n_point, {len(c.functions)})"
        )
    valves, p_return = [machine.function(f).valve for f in c.functions], machine.tank.return_pressure
    pump = limited_pump(c.pump.flow, c.pump.relief if relief else NEVER, p_return, c.pump)
    flows = sample_valves(valves, pump, np.abs(spool), p_in)
    columns: dict[str, Column] = {}
    for k, (f, v) in enumerate(zip(c.functions, valves, strict=True)):
        k_out = outlet_at(v, spool[:, k])
        columns |= valve_columns(f, spool[:, k], p_in[:, k], p_out[:, k], flows.q_in[:, k], k_out, p_return)
    for k in range(1, len(valves)):
        columns[passed(c, k).name] = (flows.q_passed[:, k - 1], "m3/s")
    for k in range(1, len(valves)):
        columns[pressure_before(c, k)[0].name] = (flows.p_between[:, k - 1], "Pa")
    columns[f"{c.name}.p_pump"] = (flows.p_pump, "Pa")
    return database_table(columns, c.name, relief)


def series_circuits(machine: LayoutMachine) -> list[SupplyCircuit]:
    """Circuits that can be sampled: of valves in series."""
    return [c for c in machine.circuits if c.kind == "series"]


def chosen_circuits(machine: LayoutMachine, circuits: Sequence[str] | None) -> list[SupplyCircuit]:
    """Circuits to learn, all if none are named.

    Raises
    ------
    InputError
        If there is no such circuit, or it is not one of valves in series.
    """
    names = [c.name for c in machine.circuits] if circuits is None else list(dict.fromkeys(circuits))
    if not names:
        raise InputError(f"circuits = []: name some of {[c.name for c in machine.circuits]}")
    return [series_circuit_of(machine, name) for name in names]


def series_circuit_of(machine: LayoutMachine, name: str) -> SupplyCircuit:
    """The circuit of that name, of valves in series.

    Raises
    ------
    InputError
        If there is none.
    """
    able = series_circuits(machine)
    found = [c for c in machine.circuits if c.name == name]
    if not found:
        raise InputError(f"unknown circuit {name!r}; choose one of {[c.name for c in able]}")
    if found[0] not in able:
        use = f"; choose one of {[c.name for c in able]}" if able else ", of which this machine has none"
        raise InputError(
            f"circuit {name!r} is of the kind {found[0].kind!r}; databases and networks are of valves in series{use}"
        )
    return found[0]


def outlet_at(valve: ValveCurves, spool: np.ndarray) -> np.ndarray:
    """Conductance of the outlet at spool displacements (n_point,) in m."""
    travel = np.abs(spool)
    sides = (np.interp(travel, valve.knots, side) for side in (valve.outlet_positive, valve.outlet_negative))
    return np.where(spool >= 0.0, *sides)


def valve_columns(
    name: str,
    spool: np.ndarray,
    p_in: np.ndarray,
    p_out: np.ndarray,
    q_in: np.ndarray,
    k_out: np.ndarray,
    p_return: float,
) -> dict[str, Column]:
    """Columns of one valve, inputs and outputs; arrays (n_point,)."""
    root = np.sqrt(np.maximum(p_out - p_return, 0.0))
    return {
        f"{name}.spool": (spool, "m"),
        f"{name}.travel": (np.abs(spool), "m"),
        f"{name}.p_in": (p_in, "Pa"),
        f"{name}.p_out": (p_out, "Pa"),
        f"{name}.root_p_out": (root, "Pa^0.5"),
        f"{name}.q_in": (q_in, "m3/s"),
        f"{name}.k_out": (k_out, "m3/s/Pa^0.5"),
        f"{name}.q_out": (k_out * root, "m3/s"),
    }


def database_table(columns: dict[str, Column], circuit: str, relief: bool) -> Table:
    """Table of columns with their units."""
    return Table(
        {name: values for name, (values, _) in columns.items()},
        {name: unit for name, (_, unit) in columns.items()},
        {"circuit": circuit, "relief": relief},
    )
