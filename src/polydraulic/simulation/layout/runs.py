"""`simulate` for a machine of any layout."""

from pathlib import Path
from typing import Any

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.record import EFFECTOR
from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario, as_scenario
from polydraulic.simulation.layout.columns import CIRCUIT, FLOWS, STATE, Columns, columns_of, gap_name
from polydraulic.simulation.layout.events import layout_events
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.loop import FASTEST
from polydraulic.simulation.steps import n_steps
from polydraulic.tables import Table



def simulate_layout(
    machine: LayoutMachine,
    flow: Any,
    scenario: Scenario | str | Path,
    *,
    dt: float,
    t_end: float | None,
    every: int,
    method: str,
) -> Table:
    """Simulate a scenario; arguments and result are those of `simulate`, with the machine's own functions and circuits.

    Raises
    ------
    InputError
        As `simulate`; a flow model or a method that knows one layout only.
    SimulationError
        If the run diverges.
    """
    check_flow(flow)
    if method != "semi-implicit":
        raise InputError(f"method {method!r} knows the layout of 'cat215b' alone; machines of other layouts run with 'semi-implicit'")
    scenario = as_scenario(scenario, machine.names)
    machine = adapted(machine, scenario)
    ready = prepare_layout(machine, dt, scenario.locked)
    if set(scenario.locked) >= set(machine.names):
        raise InputError(f"scenario {scenario.name!r} locks {', '.join(machine.names)}; nothing is left to move")
    n_step = n_steps(scenario, dt, t_end, every)
    columns, counts = columns_of(machine), np.zeros(2, dtype=np.int64)
    rows = np.empty((n_step // every + 1, len(columns.columns)))
    voltage = pilot_voltages(machine, scenario, np.arange(n_step) * dt)
    done = ready.module.run(ready.valves, ready.plant, ready.start, voltage, every, rows, counts)
    if done < n_step:
        rates = {name: rows[0, columns.place[f"{name}.rate"]] for name in machine.names}
        fastest = next(name for name, rate in rates.items() if not abs(rate) < FASTEST)
        raise SimulationError(
            f"{scenario.name} with flow 'exact': diverged, the rate of {fastest} grew without bound at t = {done * dt:g} s; "
            "try a smaller dt or check the parameter set"
        )
    time = np.arange(len(rows)) * every * dt
    info: dict[str, object] = {"scenario": scenario.name, "flow": "exact", "method": method, "dt": dt, "steps": n_step}
    info["circuits"] = {c.name: list(c.functions) for c in machine.circuits}
    info |= {"steps_not_converged": int(counts[0]), "steps_out_of_domain": int(counts[1])}
    info |= layout_events(machine, scenario.locked, time, lambda name: rows[:, columns.place[name]])
    return _table(machine, scenario, time, rows, columns, info)


def check_flow(flow: Any) -> None:
    """Refuse flow models that know one layout only."""
    if flow != "exact":
        name = flow if isinstance(flow, str) else type(flow).__name__
        raise InputError(f"flow {name!r} knows the layout of 'cat215b' alone; machines of other layouts run with 'exact'")


def pilot_voltages(machine: LayoutMachine, scenario: Scenario, t: np.ndarray) -> np.ndarray:
    """Voltages at the pilots, (n_time, n_function): the joystick's after each pilot's dead time; 0 V before that and where locked."""
    voltages = []
    for place, f in enumerate(machine.functions):
        delayed = t - f.pilot.dead_time
        alive = delayed >= 0.0 if f.name not in scenario.locked else np.zeros(len(t), dtype=bool)
        voltages.append(np.where(alive, scenario.voltages(delayed, machine.names)[:, place], 0.0))
    return np.ascontiguousarray(np.column_stack(voltages))


def _table(
    machine: LayoutMachine, scenario: Scenario, time: np.ndarray, rows: np.ndarray, columns: Columns, info: dict[str, object]
) -> Table:
    """Name the columns of recorded rows, and add what follows from them."""
    found: dict[str, np.ndarray] = {"time": time}
    units = {"time": "s"}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        found[name], units[name] = np.ascontiguousarray(values), unit

    def recorded(key: str) -> np.ndarray:
        column = columns.columns[columns.place[key]]
        add(column.name, column.unit, rows[:, columns.place[key]])
        return found[column.name]

    voltages = scenario.voltages(time, machine.names)
    for place, f in enumerate(machine.names):
        if f in scenario.locked:
            continue
        add(f"{f}.voltage", "V", voltages[:, place])
        of = {quantity: recorded(f"{f}.{quantity}") for quantity, _ in (*STATE, *FLOWS)}
        forward = of["spool"] >= 0.0
        add(f"{f}.p_in", "Pa", np.where(forward, of["p_a"], of["p_b"]))
        add(f"{f}.p_out", "Pa", np.where(forward, of["p_b"], of["p_a"]))
    for c in machine.circuits:
        if not set(c.functions) <= set(scenario.locked):
            for quantity, _ in CIRCUIT:
                recorded(f"{c.name}.{quantity}")
            for k in range(1, len(c.functions)):
                recorded(gap_name(c.name, k, len(c.functions)))
    for f in scenario.locked:
        recorded(f"{f}.angle")
    positions = np.column_stack([rows[:, columns.place[f"{f}.angle"]] for f in machine.names])
    for name, values in zip(EFFECTOR, placed(link_frames(machine, positions), *machine.tip).T, strict=True):
        add(name, "m", values)
    return Table(found, units, info)
