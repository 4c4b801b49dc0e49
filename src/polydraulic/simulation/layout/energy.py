"""The energy account of a run, as columns: from the pumps through valves, lines and joints to motion, height and heat.

Pump power = relief + throttling + what enters the actuators' lines + what charges the oil before the valves, per circuit; of each function what
oil does at the joint and what friction takes. The change of kinetic and potential energy is what oil does less friction, and what end stops take at
once; that of the oil before the valves is what charges it. Both close to the order of the step. With waves (flow `tlm`) the second does so more
slowly where they ring: flows are means over a step, pressures those at its end.
"""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from polydraulic.parameters.layout.parts import SupplyCircuit
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.layout.columns import AddedColumn, Columns, cross_name, gap_name, stored_name

# a recorded column by its key
Of = Callable[[str], np.ndarray]


def energy_columns(
    machine: LayoutMachine,
    module: Any,
    plant: Any,
    rows: np.ndarray,
    columns: Columns,
    forces: np.ndarray,
    compliances: tuple[float, float] | None = None,
) -> Iterator[AddedColumn]:
    """Columns of the account.

    Parameters
    ----------
    machine : LayoutMachine
    module, plant
        As prepared for the run.
    rows : (n_row, n_column) array
        Recorded.
    columns : Columns
        What stands where in them.
    forces : (n_row, 3) array, N
        At the tip.
    compliances : tuple of two floats, m3/Pa, optional
        Of the oil before a circuit's first valve and before each other one, where the flow model stores any.

    Yields
    ------
    AddedColumn
        ``CIRCUIT.pump_power``, ``.relief_power``, ``.throttling_power`` (over inlets, bypasses and crossover), ``.cross_power`` (of what
        enters the other circuit behind a crossover), ``.stored_power`` (of what charges the oil before the valves, where there is such oil),
        ``FUNCTION.outlet_power`` (over the outlet), ``.joint_power`` (of oil at the joint), ``.friction_power``, ``tip.push_power`` (of the force), all in W;
        ``CIRCUIT.stored_energy`` (of that oil), ``energy.kinetic``, ``energy.potential`` in J.
    """

    def of(key: str) -> np.ndarray:
        return rows[:, columns.place[key]]

    p_return = machine.tank.return_pressure
    # what enters the taking circuit behind the crossover
    crossed = {x.giving: of(cross_name(x.giving)) * of(gap_name(x.taking, 1, 2)) for x in machine.crossovers}
    gained = {x.taking: crossed[x.giving] for x in machine.crossovers}
    for c in machine.circuits:
        pump, relief = (of(f"{c.name}.p_pump") * of(f"{c.name}.{q}") for q in ("q_pump", "q_relief"))
        passed_on = sum(of(f"{f}.q_in") * _fed(of, f) for f in c.functions) + of(f"{c.name}.q_bypass") * p_return
        yield AddedColumn(f"{c.name}.pump_power", "W", pump)
        yield AddedColumn(f"{c.name}.relief_power", "W", relief)
        given, taken = crossed.get(c.name), gained.get(c.name)
        passed_on = passed_on + (0.0 if given is None else given) - (0.0 if taken is None else taken)
        if compliances is not None:
            stored = _stored(machine, c, of, compliances)
            passed_on = passed_on + stored.power
            yield AddedColumn(f"{c.name}.stored_power", "W", stored.power)
            yield AddedColumn(f"{c.name}.stored_energy", "J", stored.energy)
        yield AddedColumn(f"{c.name}.throttling_power", "W", pump - relief - passed_on)
        if given is not None:
            yield AddedColumn(f"{c.name}.cross_power", "W", given)
    found = np.empty((len(rows), 2 * len(machine.names) + 3))
    module.account(plant, np.ascontiguousarray(rows), forces, found)
    for place, f in enumerate(machine.names):
        drained = np.where(of(f"{f}.spool") >= 0.0, of(f"{f}.p_b"), of(f"{f}.p_a"))
        yield AddedColumn(f"{f}.outlet_power", "W", of(f"{f}.q_out") * (drained - p_return))
        yield AddedColumn(f"{f}.joint_power", "W", found[:, 2 * place])
        yield AddedColumn(f"{f}.friction_power", "W", found[:, 2 * place + 1])
    yield AddedColumn("tip.push_power", "W", found[:, -1])
    yield AddedColumn("energy.kinetic", "J", found[:, -3])
    yield AddedColumn("energy.potential", "J", found[:, -2])


def _fed(of: Of, function: str) -> np.ndarray:
    return np.where(of(f"{function}.spool") >= 0.0, of(f"{function}.p_a"), of(f"{function}.p_b"))


class _Stored(NamedTuple):
    """What charges the oil before a circuit's valves, W, and what that oil holds, J."""

    power: np.ndarray
    energy: np.ndarray


def _stored(machine: LayoutMachine, c: SupplyCircuit, of: Of, compliances: tuple[float, float]) -> _Stored:
    """Of one circuit; what charges each volume but the first is what arrives through the bypass before it, less what leaves."""
    n = len(c.functions)
    p = [of(f"{c.name}.p_pump"), *(of(gap_name(c.name, k, n)) for k in range(1, n))]
    passed = [*map(np.multiply, _bypasses(machine, c, of), np.sqrt(np.maximum(-np.diff(p, axis=0), 0.0)))]
    passed.append(of(f"{c.name}.q_bypass"))
    later = [
        before - of(f"{f}.q_in") - beyond
        for f, before, beyond in zip(c.functions[1:], passed, passed[1:], strict=False)
    ]
    flows = [of(stored_name(c.name)) - sum(later), *later]
    power = sum(np.multiply(pressure, flow) for pressure, flow in zip(p, flows, strict=True))
    of_each = [compliances[0], *[compliances[1]] * (n - 1)]
    energy = sum(0.5 * compliance * pressure * pressure for compliance, pressure in zip(of_each, p, strict=True))
    return _Stored(np.asarray(power), np.asarray(energy))


def _bypasses(machine: LayoutMachine, c: SupplyCircuit, of: Of) -> Iterator[np.ndarray]:
    """Conductances of the bypasses between a circuit's valves, m3/s/Pa^0.5."""
    for name in c.functions[:-1]:
        valve = machine.function(name).valve
        yield np.interp(np.abs(of(f"{name}.spool")), valve.knots, valve.bypass)
