"""Reference solution: the same equations in continuous time, integrated by a tight implicit SciPy solver.

Judge of the loop: as dt falls the loop must approach it. The right-hand side uses the same component kernels, the
voltage is not held over steps, and no stage lags behind another. The integration stops where a joint meets its end stop or
is pulled away from it, and goes on from there (`contact`).
"""

import itertools
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from polydraulic.errors import SimulationError
from polydraulic.flow import FLOW_KINDS, flow_name
from polydraulic.machine import initial_state, prepare
from polydraulic.machine.linkage import Held
from polydraulic.machine.state import Links, to_vector
from polydraulic.parameters import LINKS, Machine, Piecewise, Scenario
from polydraulic.simulation.contact import Contact, held_joints, impact, watch
from polydraulic.simulation.events import find_events, stop_event
from polydraulic.simulation.loop import N_RECORD
from polydraulic.simulation.right_hand_side import evaluate
from polydraulic.simulation.runs import step_voltages

_MAX_EVALUATIONS = 5_000_000
_MAX_EVENTS = 1000
# size of spools, pressures, angles, rates: sets absolute tolerances
_SCALE = np.repeat([1e-3, 1e6, 1e6, 1.0, 1.0], 3)


def integrate(
    machine: Machine, model: Any, scenario: Scenario, time: np.ndarray, rtol: float
) -> tuple[np.ndarray, dict[str, object]]:
    """Integrate a scenario to a tight tolerance.

    Parameters
    ----------
    machine : Machine
        With the scenario's changes.
    model : flow model
    scenario : Scenario
    time : (n_time,) array, s
        Where the solution is wanted, from 0 on.
    rtol : float

    Returns
    -------
    rows : (n_time, N_RECORD) array
    info : dict
        Number of contacts, and the events.

    Raises
    ------
    SimulationError
        If the solver fails, or joints meet and leave their end stops without end.
    """
    plant = prepare(machine, 1.0, scenario.locked)
    memory = np.zeros(FLOW_KINDS[flow_name(model)].n_memory(model))
    tau = Links(*(getattr(machine, link).pilot.time_constant for link in LINKS))
    rates, row, reaction = np.empty(15), np.empty(N_RECORD), np.empty(3)
    evaluations = 0

    def at(t: float, v: np.ndarray, held: Held) -> None:
        nonlocal evaluations
        evaluations += 1
        if evaluations > _MAX_EVALUATIONS:
            raise SimulationError(f"reference solution of {scenario.name}: more than {_MAX_EVALUATIONS} evaluations")
        voltage = step_voltages(machine, scenario, np.array([t]))[0]
        evaluate(model, memory, plant, tau, held, voltage, v, rates, row, reaction)

    def push(t: float, v: np.ndarray, held: Held) -> np.ndarray:
        at(t, v, held)
        return reaction.copy()

    contact = Contact(machine, plant, push)
    v = to_vector(initial_state(machine))
    held = held_joints(contact, 0.0, v)
    states = np.empty((len(time), 15))
    states[0] = v
    contacts: list[list[Any]] = []
    for t0, t1 in smooth_pieces(machine, scenario, time[-1]):
        while t0 < t1:
            inside = (time > t0) & (time <= t1)
            wanted = np.union1d(time[inside], t1)

            def derivative(t: float, v: np.ndarray, held: Held = held) -> np.ndarray:
                at(t, v, held)
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
            if len(contacts) > _MAX_EVENTS:
                raise SimulationError(
                    f"reference solution of {scenario.name}: more than {_MAX_EVENTS} contacts by {t0:g} s"
                )
            which = next(i for i, times_ in enumerate(solution.t_events) if len(times_))
            t0, v = float(solution.t_events[which][0]), solution.y_events[which][0].copy()
            had = held
            v, held = impact(contact, t0, v, had, which)
            for place, link in enumerate(LINKS):
                if held[place] != had[place] and not plant.locked[place]:
                    contacts.append(stop_event(t0, link, getattr(machine, link).stops, v[9 + place], held[place]))
    rows = np.empty((len(time), N_RECORD))
    for place, (t, v) in enumerate(zip(time, states, strict=True)):
        at(t, v, plant.locked)
        rows[place] = row
    return rows, {"contacts": len(contacts), **find_events(machine, scenario, time, rows, contacts)}


def smooth_pieces(machine: Machine, scenario: Scenario, t_end: float) -> list[tuple[float, float]]:
    """Intervals without a corner of a voltage inside, as the pilots see it."""
    corners = {0.0, t_end}
    for link, signal in scenario.voltage.items():
        dead_time = getattr(machine, link).pilot.dead_time
        times = [0.0, *signal.time] if isinstance(signal, Piecewise) else [0.0]
        corners |= {float(t + dead_time) for t in times if 0.0 < t + dead_time < t_end}
    return list(itertools.pairwise(sorted(corners)))
