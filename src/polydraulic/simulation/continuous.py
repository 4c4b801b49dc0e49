"""Reference solution: the same equations in continuous time, integrated by a tight implicit SciPy solver.

Judge of the loop: as dt falls the loop must approach it. The right-hand side uses the same component kernels, the
voltage is not held over steps, and no stage lags behind another. The integration stops where a joint meets its end stop or
is pulled away from it, and goes on from there (`contact`).
"""

import itertools
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from polydraulic._kernel import driver, kernel
from polydraulic.errors import InputError, SimulationError
from polydraulic.flow import FLOW_KINDS, build_flow, flow_name
from polydraulic.flow.dispatch import flow_step
from polydraulic.machine import initial_state, prepare
from polydraulic.machine.hose import LineStep, ports
from polydraulic.machine.joints import net_torque, position
from polydraulic.machine.linkage import Held, solve_motion, times
from polydraulic.machine.pilot import spool_target
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State, from_vector, to_vector
from polydraulic.parameters import LINKS, Machine, Piecewise, Scenario
from polydraulic.simulation.contact import Contact, held_joints, impact, watch
from polydraulic.simulation.loop import N_RECORD, record_flows
from polydraulic.simulation.runs import check_links, n_steps, step_voltages, trajectory
from polydraulic.simulation.step import Seen
from polydraulic.tables import Table

_MAX_EVALUATIONS = 2_000_000
_MAX_EVENTS = 1000
_WAY = 10.0  # Pa, over which floor and relief stop a line pressure
# size of spools, pressures, angles, rates: sets absolute tolerances
_SCALE = np.repeat([1e-3, 1e6, 1e6, 1.0, 1.0], 3)


class _LineRates(NamedTuple):
    p_a: float  # Pa/s
    p_b: float
    q_out: float


@kernel
def _held_back(p: float, rate: float, line: LineStep) -> float:
    # ends at a bound within a short way, not at once: a jump would leave the solver without a Jacobian
    room = p - line.floor if rate < 0.0 else line.relief - p
    return rate * min(max(room / _WAY, 0.0), 1.0)


@kernel
def _bounded(p: float, line: LineStep) -> float:
    return min(max(p, line.floor), line.relief)


@kernel
def _line_rates(
    spool: float, p_a: float, p_b: float, q_in: float, k_out: float, swept_a: float, swept_b: float, line: LineStep
) -> _LineRates:
    """Rates of the line pressures; `line` is prepared for dt = 1 s. The arguments are those of `line_step`."""
    bounded_a, bounded_b = _bounded(p_a, line), _bounded(p_b, line)
    forward = spool >= 0.0
    q_out = k_out * sqrt(max((bounded_b if forward else bounded_a) - line.p_return, 0.0))
    leak = line.leakage * (bounded_a - bounded_b)
    rate_a = line.gain_a * ((q_in if forward else -q_out) - swept_a - leak)
    rate_b = line.gain_b * ((-q_out if forward else q_in) - swept_b + leak)
    return _LineRates(_held_back(p_a, rate_a, line), _held_back(p_b, rate_b, line), q_out)


@driver
def _rates(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    tau: Links,
    held: Held,
    voltage: np.ndarray,
    v: np.ndarray,
    rate: np.ndarray,
    row: np.ndarray,
    reaction: np.ndarray,
) -> None:
    """Time derivatives of the state `v`; `plant` is prepared for dt = 1 s.

    `row` receives state and flows as the loop records them, `reaction` the torques in N m that hold the joints which are held.
    """
    raw = from_vector(v)
    swing, boom, stick = plant.swing, plant.boom, plant.stick
    p_a = Links(
        _bounded(raw.p_a.swing, swing.line), _bounded(raw.p_a.boom, boom.line), _bounded(raw.p_a.stick, stick.line)
    )
    p_b = Links(
        _bounded(raw.p_b.swing, swing.line), _bounded(raw.p_b.boom, boom.line), _bounded(raw.p_b.stick, stick.line)
    )
    x = State(raw.spool, p_a, p_b, raw.angle, raw.rate)
    fed_swing = ports(x.spool.swing, p_a.swing, p_b.swing)
    fed_boom = ports(x.spool.boom, p_a.boom, p_b.boom)
    fed_stick = ports(x.spool.stick, p_a.stick, p_b.stick)
    seen = Seen(
        Links(fed_swing.p_in, fed_boom.p_in, fed_stick.p_in), Links(fed_swing.p_out, fed_boom.p_out, fed_stick.p_out)
    )
    flows = flow_step(model, memory, x.spool, seen.p_in, seen.p_out, plant.dt)
    here = position(x.angle, x.rate, plant)
    a, b, w, q, k = here.levers.a, here.levers.b, x.rate, flows.q_in, flows.k_out
    line_swing = _line_rates(
        x.spool.swing,
        raw.p_a.swing,
        raw.p_b.swing,
        q.swing,
        k.swing,
        a.swing * w.swing,
        -b.swing * w.swing,
        swing.line,
    )
    line_boom = _line_rates(
        x.spool.boom, raw.p_a.boom, raw.p_b.boom, q.boom, k.boom, a.boom * w.boom, -b.boom * w.boom, boom.line
    )
    line_stick = _line_rates(
        x.spool.stick,
        raw.p_a.stick,
        raw.p_b.stick,
        q.stick,
        k.stick,
        a.stick * w.stick,
        -b.stick * w.stick,
        stick.line,
    )
    torque = net_torque(here, p_a, p_b, x.rate, plant)
    acceleration = solve_motion(here.motion.mass, held, torque)
    needed = times(here.motion.mass, acceleration)
    reaction[0], reaction[1] = needed.swing - torque.swing, needed.boom - torque.boom
    reaction[2] = needed.stick - torque.stick

    rate[0] = (spool_target(voltage[0], swing.pilot) - x.spool.swing) / tau.swing
    rate[1] = (spool_target(voltage[1], boom.pilot) - x.spool.boom) / tau.boom
    rate[2] = (spool_target(voltage[2], stick.pilot) - x.spool.stick) / tau.stick
    rate[3], rate[4], rate[5] = line_swing.p_a, line_boom.p_a, line_stick.p_a
    rate[6], rate[7], rate[8] = line_swing.p_b, line_boom.p_b, line_stick.p_b
    rate[9], rate[10], rate[11] = x.rate.swing, x.rate.boom, x.rate.stick
    rate[12], rate[13], rate[14] = acceleration.swing, acceleration.boom, acceleration.stick
    for i in range(15):
        row[i] = v[i]
    record_flows(flows, Links(line_swing.q_out, line_boom.q_out, line_stick.q_out), row)


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
        As for `simulate`.
    dt : float, s
        Raster of the result, not a step size.
    rtol : float
        Relative tolerance of the solver.
    t_end : float, s, optional
        Instead of the scenario's duration.

    Raises
    ------
    InputError
        As for `simulate`; a flow model with pressures of its own.
    SimulationError
        If the solver fails, or joints meet and leave their end stops without end.
    """
    machine = scenario.adapt(machine)
    prepare(machine, dt)  # refuses a bad raster
    model = build_flow(flow, machine) if isinstance(flow, str) else flow
    kind = FLOW_KINDS[flow_name(model)]
    check_links(scenario, model)
    if kind.has_state:
        raise InputError(
            f"flow {flow_name(model)!r} has pressures of its own, which the reference solution does not integrate; "
            "use 'exact', or simulate with a small dt"
        )
    time = np.arange(n_steps(scenario, dt, t_end) + 1) * dt
    plant = prepare(machine, 1.0, scenario.locked)
    memory = np.zeros(kind.n_memory(model))
    tau = Links(*(getattr(machine, link).pilot.time_constant for link in LINKS))
    rates, row, reaction = np.empty(15), np.empty(N_RECORD), np.empty(3)
    evaluations = 0

    def evaluate(t: float, v: np.ndarray, held: Held) -> None:
        nonlocal evaluations
        evaluations += 1
        if evaluations > _MAX_EVALUATIONS:
            raise SimulationError(f"reference solution of {scenario.name}: more than {_MAX_EVALUATIONS} evaluations")
        voltage = step_voltages(machine, scenario, np.array([t]))[0]
        _rates(model, memory, plant, tau, held, voltage, v, rates, row, reaction)

    def push(t: float, v: np.ndarray, held: Held) -> np.ndarray:
        evaluate(t, v, held)
        return reaction.copy()

    contact = Contact(machine, plant.locked, push)
    v = to_vector(initial_state(machine))
    held = held_joints(contact, 0.0, v)
    states = np.empty((len(time), 15))
    states[0] = v
    events = 0
    for t0, t1 in _smooth_pieces(machine, scenario, time[-1]):
        while t0 < t1:
            inside = (time > t0) & (time <= t1)
            wanted = np.union1d(time[inside], t1)

            def derivative(t: float, v: np.ndarray, held: Held = held) -> np.ndarray:
                evaluate(t, v, held)
                return rates.copy()

            solution = solve_ivp(
                derivative,
                (t0, t1),
                v,
                "LSODA",
                t_eval=wanted,
                rtol=rtol,
                atol=rtol * _SCALE,
                max_step=0.02,
                events=watch(contact, held),
            )
            if not solution.success:
                raise SimulationError(f"reference solution of {scenario.name}: {solution.message}")
            reached = np.isin(time, solution.t) & inside
            states[reached] = solution.y.T[np.isin(solution.t, time[inside])]
            if solution.status == 0:
                v, t0 = solution.y[:, -1], t1
                continue
            events += 1
            if events > _MAX_EVENTS:
                raise SimulationError(
                    f"reference solution of {scenario.name}: more than {_MAX_EVENTS} contacts by {t0:g} s"
                )
            which = next(i for i, times_ in enumerate(solution.t_events) if len(times_))
            t0, v = float(solution.t_events[which][0]), solution.y_events[which][0].copy()
            v, held = impact(contact, t0, v, held, which)
    rows = np.empty((len(time), N_RECORD))
    for place, (t, v) in enumerate(zip(time, states, strict=True)):
        evaluate(t, v, plant.locked)
        rows[place] = row
    info: dict[str, object] = {
        "scenario": scenario.name,
        "flow": flow_name(model),
        "method": "reference",
        "rtol": rtol,
        "contacts": events,
    }
    return trajectory(machine, scenario, time, rows, info, kind)


def _smooth_pieces(machine: Machine, scenario: Scenario, t_end: float) -> list[tuple[float, float]]:
    """Intervals without a corner of a voltage inside, as the pilots see it."""
    corners = {0.0, t_end}
    for link, signal in scenario.voltage.items():
        dead_time = getattr(machine, link).pilot.dead_time
        times = [0.0, *signal.time] if isinstance(signal, Piecewise) else [0.0]
        corners |= {float(t + dead_time) for t in times if 0.0 < t + dead_time < t_end}
    return list(itertools.pairwise(sorted(corners)))
