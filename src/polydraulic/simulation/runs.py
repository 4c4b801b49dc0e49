"""`simulate`: a machine, a flow model and a scenario in, a table of named columns out."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FLOW_KINDS, FlowKind, FlowModel, as_flow, flow_name, served_links
from polydraulic.flow.record import (
    ANGLE,
    EFFECTOR,
    N_RECORD,
    PLACE,
    RATE,
    circuit_columns,
    link_columns,
    to_vector,
    working_circuits,
)
from polydraulic.machine.linkage import end_effector
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, initial_state
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.scenario import Scenario, as_scenario
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.simulation.events import find_events
from polydraulic.simulation.input_check import input_warnings
from polydraulic.simulation.layout.runs import simulate_layout
from polydraulic.simulation.loop import FASTEST, run
from polydraulic.simulation.solvers.runge_kutta import run_runge_kutta
from polydraulic.simulation.steps import n_steps, recorded_steps
from polydraulic.tables import Table

# methods of `simulate`, with the tolerance of those that choose their own steps
METHODS: dict[str, float | None] = {"semi-implicit": None, "rk4": None, "rosenbrock": 1e-4, "reference": 1e-9}


def simulate(
    machine: Machine | LayoutMachine | str | Path,
    flow: str | FlowModel,
    scenario: Scenario | str | Path,
    *,
    dt: float = 5e-3,
    t_end: float | None = None,
    every: int = 1,
    raster: float | None = None,
    method: str = "semi-implicit",
    rtol: float | None = None,
    energy: bool = False,
    forces: bool = False,
) -> Table:
    """Simulate a scenario.

    Parameters
    ----------
    machine : Machine or LayoutMachine, or name or path of a parameter set
        The scenario's own pilots and initial state replace the machine's.
    flow : str or flow model
        Name of a flow model, or a model from one of the builders in `polydraulic.flow`.
    scenario : Scenario, or name or path of one
        What `load_scenario` takes.
    dt : float, s
        Time step; for the methods that choose their own steps, the raster of the result.
    t_end : float, s, optional
        Instead of the scenario's duration.
    every : int
        Record every so many steps.
    raster : float, s, optional
        Instead of `every`: record at these intervals, a whole number of steps.
    method : str
        ``"semi-implicit"``: one valve evaluation per step, bounded cost, for inputs not known in advance; voltages are held
        over a step. ``"rk4"``: classic Runge-Kutta. ``"rosenbrock"``: steps of its own choice to the tolerance
        `rtol`, the fastest for inputs known in advance; needs a flow model with slopes. ``"reference"``: an implicit solver with tight tolerances,
        slow.
    rtol : float, optional
        Relative tolerance of the last two; 1e-4 and 1e-9 if not given.
    energy : bool
        Whether to add the energy account, see `simulation.layout.energy`; for machines that are described by links.
    forces : bool
        Whether to add forces of actuators, friction and joint pins, see `simulation.layout.forces`; for the same machines.

    Returns
    -------
    Table
        In SI. ``time``; of each function that moves, by its name, ``boom.voltage``, ``boom.spool``, ``boom.p_a``, ``boom.p_b``,
        ``boom.angle`` (``position`` where it slides), ``boom.rate``, ``boom.q_in``, ``boom.q_out``, ``boom.p_in``, ``boom.p_out``
        (of a locked one its angle alone); of each circuit ``series.q_pump``, ``series.q_bypass``, ``series.q_relief``, ``series.p_pump``, and
        between two valves ``series.p_between``; ``effector.x``, ``effector.y``, ``effector.z``. `info` counts the steps
        that did not converge and those outside the flow model's domain, and lists the ``events`` (see `events`).

    Raises
    ------
    InputError
        dt not positive, duration shorter than a step, a raster that is not a whole number of steps, an unknown flow model, a
        scenario that moves links which the flow model does not serve.
    SimulationError
        If the run diverges, or a solver fails; says when and where.
    """
    machine = as_machine(machine)
    if method not in METHODS:
        raise InputError(f"unknown method {method!r}; choose one of {list(METHODS)}")
    least = METHODS[method]
    if rtol is not None and (least is None or not 1e-13 <= rtol <= 0.1):
        raise InputError(f"rtol = {rtol} with method {method!r}: goes with 'rosenbrock' and 'reference', 1e-13 to 0.1")
    every = recorded_steps(dt, every, raster)
    if isinstance(machine, LayoutMachine):
        return simulate_layout(
            machine, flow, scenario, dt=dt, t_end=t_end, every=every, method=method, rtol=rtol or least,
            energy=energy, forces=forces,
        )  # fmt: skip
    if energy or forces:
        raise InputError(
            f"{'the energy account is' if energy else 'forces of pins are'} of machines that are described by links, functions and circuits; "
            "try 'cat215b_bucket'"
        )
    scenario = as_scenario(scenario)
    arranged = arrange(machine, flow, scenario, dt=dt, t_end=t_end, every=every)
    if method != "semi-implicit" and FLOW_KINDS[flow_name(arranged.model)].has_state:
        raise InputError(
            f"flow {flow_name(arranged.model)!r} has pressures of its own, which method {method!r} does not integrate; "
            "use 'exact', or 'semi-implicit' with a small dt"
        )
    adapted, name, n_step = scenario.adapt(machine), flow_name(arranged.model), len(arranged.voltage)
    time = np.arange(len(arranged.rows)) * every * dt
    info: dict[str, object] = {"scenario": scenario.name, "flow": name, "method": method, "dt": dt}
    full_lever = {link: adapted.spool.knots[-1] / getattr(adapted, link).pilot.gain for link in LINKS}
    if doubts := input_warnings(scenario, full_lever, t_end):
        info["doubtful_inputs"] = doubts
    if least is not None:
        integrate = _solver(method)
        rows, found = integrate(adapted, arranged.model, scenario, time, rtol or least)
        info |= {"rtol": rtol or least, **found}
    else:
        rows = arranged.rows
        done = run(*arranged) if method == "semi-implicit" else _run_runge_kutta(adapted, scenario, arranged)
        if done < n_step:
            raise SimulationError(
                f"{scenario.name} with flow {name!r}: diverged, the rate of {_fastest(rows[0])} grew without bound "
                f"at t = {done * dt:g} s; "
                "try a smaller dt or check the flow model"
            )
        not_converged, out_of_domain = (int(count) for count in arranged.counts)
        info |= {"steps": n_step, "steps_not_converged": not_converged, "steps_out_of_domain": out_of_domain}
        info |= find_events(adapted, scenario, time, rows)
    return trajectory(adapted, scenario, time, rows, info, FLOW_KINDS[name])


def _solver(method: str) -> Any:
    # SciPy's solvers take long to import, and the loops do without
    if method == "rosenbrock":
        from polydraulic.simulation.solvers.rosenbrock import integrate
    else:
        from polydraulic.simulation.solvers.lsoda import integrate
    return integrate


def _run_runge_kutta(machine: Machine, scenario: Scenario, a: "Arranged") -> int:
    halves = np.arange(2 * len(a.voltage) + 1) * (0.5 * a.plant.dt)
    voltage = step_voltages(machine, scenario, halves)
    tau = Links(*(getattr(machine, link).pilot.time_constant for link in LINKS))
    plant = prepare(machine, 1.0, scenario.locked)
    return run_runge_kutta(a.model, a.memory, plant, tau, a.plant.dt, a.x0, voltage, a.every, a.rows, a.counts)


class Arranged(NamedTuple):
    """Arguments of the compiled loop; see `loop.run`."""

    model: Any
    memory: np.ndarray
    plant: Plant
    x0: np.ndarray
    voltage: np.ndarray
    every: int
    rows: np.ndarray
    counts: np.ndarray


def arrange(
    machine: Machine,
    flow: str | FlowModel,
    scenario: Scenario,
    *,
    dt: float = 5e-3,
    t_end: float | None = None,
    every: int = 1,
) -> Arranged:
    """Check the arguments of `simulate` and allocate what the compiled loop needs."""
    machine = scenario.adapt(machine)
    plant = prepare(machine, dt, scenario.locked)
    model = as_flow(flow, machine)
    check_links(scenario, model)
    n_step = n_steps(scenario, dt, t_end, every)
    return Arranged(
        model=model,
        memory=np.zeros(FLOW_KINDS[flow_name(model)].n_memory(model)),
        plant=plant,
        x0=to_vector(initial_state(machine)),
        voltage=step_voltages(machine, scenario, np.arange(n_step) * dt),
        every=every,
        rows=np.empty((n_step // every + 1, N_RECORD)),
        counts=np.zeros(2, dtype=np.int64),
    )


def step_voltages(machine: Machine, scenario: Scenario, t: np.ndarray) -> np.ndarray:
    """Voltages at the pilots, (n_time, 3): the joystick's after each pilot's dead time; 0 V before that and on locked links."""
    columns = []
    for place, link in enumerate(LINKS):
        delayed = t - getattr(machine, link).pilot.dead_time
        alive = delayed >= 0.0 if link not in scenario.locked else np.zeros(len(t), dtype=bool)
        columns.append(np.where(alive, scenario.voltages(delayed)[:, place], 0.0))
    return np.ascontiguousarray(np.column_stack(columns))


def trajectory(
    machine: Machine,
    scenario: Scenario,
    time: np.ndarray,
    rows: np.ndarray,
    info: dict[str, object],
    kind: FlowKind,
) -> Table:
    """Name the columns of recorded rows, those that this kind of flow model gives, and add what follows from them."""
    columns: dict[str, np.ndarray] = {"time": time}
    units = {"time": "s"}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        columns[name], units[name] = np.ascontiguousarray(values), unit

    voltages = scenario.voltages(time)
    for link in (link for link in LINKS if link not in scenario.locked):
        add(f"{link}.voltage", "V", voltages[:, LINKS.index(link)])
        for name, unit in link_columns(link):
            add(name, unit, rows[:, PLACE[name]])
        forward = columns[f"{link}.spool"] >= 0.0
        p_a, p_b = columns[f"{link}.p_a"], columns[f"{link}.p_b"]
        add(f"{link}.p_in", "Pa", np.where(forward, p_a, p_b))
        add(f"{link}.p_out", "Pa", np.where(forward, p_b, p_a))
    for circuit in working_circuits(scenario.locked):
        for name, unit in circuit_columns(circuit, p_pump=kind.gives_pump_pressure, q_stored=kind.has_state):
            add(name, unit, rows[:, PLACE[name]])
    for link in (link for link in LINKS if link in scenario.locked):
        add(f"{link}.angle", "rad", rows[:, PLACE[f"{link}.angle"]])
    position = end_effector(rows[:, ANGLE : ANGLE + 3], machine.geometry)
    for name, values in zip(EFFECTOR, position.T, strict=True):
        add(name, "m", values)
    return Table(columns, units, info)


def check_links(scenario: Scenario, model: Any) -> None:
    """Refuse a scenario that moves links which the flow model does not serve, or none at all, or that loads the tip."""
    if scenario.loads.force or scenario.loads.payload is not None:
        raise InputError(
            f"scenario {scenario.name!r} has a force or a payload at the tip: give a machine that is described by links, for "
            "example 'cat215b_bucket'"
        )
    free = [link for link in LINKS if link not in scenario.locked]
    if not free:
        raise InputError(f"scenario {scenario.name!r} locks {', '.join(LINKS)}; nothing is left to move")
    missing = [link for link in free if link not in served_links(model)]
    if missing:
        able = [other for other, kind in FLOW_KINDS.items() if set(free) <= set(kind.links)]
        raise InputError(
            f"scenario {scenario.name!r} moves {', '.join(missing)}, which flow {flow_name(model)!r} does not serve; "
            f"lock them in the scenario or use one of {able}"
        )


def _fastest(row: np.ndarray) -> str:
    """Name of the link whose rate in a recorded row has diverged."""
    return next(link for link, rate in zip(LINKS, row[RATE : RATE + 3], strict=True) if not abs(rate) < FASTEST)


def reference(
    machine: Machine | LayoutMachine | str | Path,
    flow: str | FlowModel,
    scenario: Scenario | str | Path,
    *,
    dt: float = 5e-3,
    rtol: float = 1e-9,
    t_end: float | None = None,
) -> Table:
    """`simulate` with ``method="reference"``: the solution to a tight tolerance.

    Parameters
    ----------
    machine, flow, scenario
        As for `simulate`.
    dt : float, s
        Raster of the result.
    rtol : float
        Relative tolerance of the solver.
    t_end : float, s, optional
        Instead of the scenario's duration.
    """
    return simulate(machine, flow, scenario, dt=dt, t_end=t_end, method="reference", rtol=rtol)
