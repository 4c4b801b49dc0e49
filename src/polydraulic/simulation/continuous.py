"""Reference solution: the same equations in continuous time, integrated by a tight implicit SciPy solver.

Judge of the loop: as dt falls the loop must approach it. The right-hand side uses the same component kernels, the
voltage is not held over steps, and no stage lags behind another.
"""

import itertools
from math import sqrt
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from polydraulic._kernel import driver
from polydraulic.errors import SimulationError
from polydraulic.flow import FLOW_KINDS, build_flow, flow_name
from polydraulic.flow.dispatch import flow_step
from polydraulic.machine import initial_state, prepare
from polydraulic.machine.actuator import lever_arm
from polydraulic.machine.hose import Pressures, ports
from polydraulic.machine.pilot import spool_target
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.parameters import Machine, Piecewise, Scenario
from polydraulic.simulation.loop import N_RECORD
from polydraulic.simulation.runs import check_links, n_steps, step_voltages, trajectory
from polydraulic.simulation.step import boom_acceleration
from polydraulic.tables import Table

_MAX_EVALUATIONS = 5_000_000
_SCALE = np.array([1e-3, 1e6, 1e6, 1.0, 1.0])  # size of spool, pressures, angle, rate: sets absolute tolerances


@driver
def _rates(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    tau: float,
    held: np.ndarray,
    voltage: float,
    v: np.ndarray,
    rate: np.ndarray,
    flow: np.ndarray,
) -> None:
    """Time derivatives of (spool, p_a, p_b, angle, rate) of the boom; `plant` is prepared for dt = 1 s."""
    boom, line = plant.boom, plant.boom.line
    spool, angle, speed = v[0], v[3], v[4]
    p_a = min(max(v[1], line.floor), line.relief)
    p_b = min(max(v[2], line.floor), line.relief)
    seen = ports(spool, p_a, p_b)
    p_in, p_out = Links(0.0, seen.p_in, 0.0), Links(0.0, seen.p_out, 0.0)
    flows = flow_step(model, memory, Links(0.0, spool, 0.0), p_in, p_out, plant.dt)
    q_in = flows.q_in.boom
    q_out = flows.k_out.boom * sqrt(max(seen.p_out - line.p_return, 0.0))

    arm = lever_arm(angle, boom.cylinder)
    leak = line.leakage * (p_a - p_b)
    into_a = (q_in if spool >= 0.0 else -q_out) - boom.cylinder.area_a * arm * speed - leak
    into_b = (-q_out if spool >= 0.0 else q_in) + boom.cylinder.area_b * arm * speed + leak
    x = State(
        Links(0.0, spool, 0.0),
        Links(0.0, p_a, 0.0),
        Links(0.0, p_b, 0.0),
        Links(held[0], angle, held[1]),
        Links(0.0, speed, 0.0),
    )
    rate[0] = (spool_target(voltage, boom.pilot) - spool) / tau
    rate[1] = line.gain_a * into_a
    rate[2] = line.gain_b * into_b
    for i in (1, 2):
        stopped = (v[i] <= line.floor and rate[i] < 0.0) or (v[i] >= line.relief and rate[i] > 0.0)
        rate[i] = 0.0 if stopped else rate[i]
    rate[3] = speed
    rate[4] = boom_acceleration(arm, Pressures(p_a, p_b, q_out), x, boom, plant.linkage)
    flow[0], flow[1] = q_in, q_out
    flow[2], flow[3] = flows.boom.q_pump, flows.boom.q_bypass
    flow[4], flow[5] = flows.boom.q_relief, flows.boom.p_pump


def reference(
    machine: Machine,
    flow: Any,
    scenario: Scenario,
    *,
    dt: float = 5e-3,
    rtol: float = 1e-9,
    t_end: float | None = None,
) -> Table:
    """Integrate a scenario to a tight tolerance and sample it every `dt`.

    Parameters
    ----------
    machine, flow, scenario
        As for `simulate`; swing and stick must be locked.
    dt : float, s
        Raster of the result, not a step size.
    rtol : float
        Relative tolerance of the solver.
    t_end : float, s, optional
        Instead of the scenario's duration.

    Raises
    ------
    InputError
        As for `simulate`.
    SimulationError
        If the solver fails, or the boom reaches an end stop, which this method does not model.
    """
    machine = scenario.adapt(machine)
    check_links(scenario)
    prepare(machine, dt)  # refuses a bad raster
    time = np.arange(n_steps(scenario, dt, t_end) + 1) * dt
    plant = prepare(machine, 1.0)
    model = build_flow(flow, machine) if isinstance(flow, str) else flow
    kind = FLOW_KINDS[flow_name(model)]
    memory = np.zeros(kind.n_memory(model))
    x0 = initial_state(machine)
    held = np.array([x0.angle.swing, x0.angle.stick])
    tau = machine.boom.pilot.time_constant
    rates, flows = np.empty(5), np.empty(6)

    evaluations = 0

    def derivative(t: float, v: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        evaluations += 1
        if evaluations > _MAX_EVALUATIONS:
            raise SimulationError(f"reference solution of {scenario.name}: more than {_MAX_EVALUATIONS} evaluations")
        voltage = step_voltages(machine, scenario, np.array([t]))[0, 1]
        _rates(model, memory, plant, tau, held, voltage, v, rates, flows)
        return rates.copy()

    stops = machine.boom.stops

    def inside_stops(t: float, v: np.ndarray) -> float:
        return float(min(v[3] - stops.low, stops.high - v[3]))

    inside_stops.terminal = True  # type: ignore[attr-defined]

    start = np.array([x0.spool.boom, x0.p_a.boom, x0.p_b.boom, x0.angle.boom, x0.rate.boom])
    states = np.empty((len(time), 5))
    states[0], v = start, start
    for t0, t1 in _smooth_pieces(machine, scenario, time[-1]):
        inside = (time > t0) & (time <= t1)
        wanted = np.union1d(time[inside], t1)
        solution = solve_ivp(
            derivative,
            (t0, t1),
            v,
            "LSODA",
            t_eval=wanted,
            rtol=rtol,
            atol=rtol * _SCALE,
            max_step=0.02,
            events=inside_stops,
        )
        if solution.status == 1:
            raise SimulationError(
                f"reference solution of {scenario.name}: the boom reaches an end stop at t = {solution.t_events[0][0]:g} s, "
                "which this method does not model; shorten the run or use simulate"
            )
        if not solution.success:
            raise SimulationError(f"reference solution of {scenario.name}: {solution.message}")
        states[inside], v = solution.y.T[np.isin(wanted, time[inside])], solution.y[:, -1]
    rows = np.zeros((len(time), N_RECORD))
    rows[:, [1, 4, 7, 10, 13]] = states
    rows[:, 9], rows[:, 11] = held
    rows[:, [3, 5, 6, 8]] = x0.p_a.swing, x0.p_a.stick, x0.p_b.swing, x0.p_b.stick
    for row, t, v in zip(rows, time, states, strict=True):
        derivative(t, v)
        row[16], row[19], row[21:25] = flows[0], flows[1], flows[2:6]
    info: dict[str, object] = {
        "scenario": scenario.name,
        "flow": flow_name(model),
        "method": "reference",
        "rtol": rtol,
    }
    return trajectory(machine, scenario, time, rows, info, pump_pressure=kind.gives_pump_pressure)


def _smooth_pieces(machine: Machine, scenario: Scenario, t_end: float) -> list[tuple[float, float]]:
    """Intervals without a corner of a voltage inside, as the pilots see it."""
    corners = {0.0, t_end}
    for link, signal in scenario.voltage.items():
        dead_time = getattr(machine, link).pilot.dead_time
        times = [0.0, *signal.time] if isinstance(signal, Piecewise) else [0.0]
        corners |= {float(t + dead_time) for t in times if 0.0 < t + dead_time < t_end}
    return list(itertools.pairwise(sorted(corners)))
