"""Rosenbrock method with steps of its own choice, for inputs that are known in advance.

Steps end where a spool passes a knot of its tables or a voltage has a corner (`spools`), and where a line pressure meets or
leaves its bounds, a joint its stops, a pump its relief pressure (`smooth`), found by bisection on the dense output, the
cubic through both ends of a step with their slopes. Between such points everything is smooth, and `rosenbrock_step` has its order.
"""

from math import sqrt
from typing import Any

import numpy as np

from polydraulic._kernel import driver
from polydraulic.errors import InputError, SimulationError
from polydraulic.flow.dispatch import FLOW_KINDS, flow_name
from polydraulic.flow.record import N_RECORD, N_STATE, P_A, from_vector, to_vector
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import Links, initial_state
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Machine
from polydraulic.simulation.events import Edges, EventLog, conditions, edges_of, listed, new_log, observe
from polydraulic.simulation.loop import reasonable
from polydraulic.simulation.solvers.adaptive import (
    DONE,
    FAILURES,
    MANY_AT_ONCE,
    MAX_STEPS,
    RODAS,
    SMALLEST_STEP,
    TOO_FAST,
    TOO_MANY,
    TOO_SMALL,
    Tableau,
)
from polydraulic.simulation.solvers.right_hand_side import fill_flows
from polydraulic.simulation.solvers.rosenbrock_step import (
    Work,
    between,
    evaluate_slow,
    new_work,
    slow_state,
    step,
)
from polydraulic.simulation.solvers.spools import SHORTEST, SpoolMotion, spool_motion, spools_at
from polydraulic.simulation.solvers.switching import changes, relief_open, settle


@driver
def run_rosenbrock(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    tableau: Tableau,
    motion: SpoolMotion,
    x0: np.ndarray,
    rtol: float,
    time: np.ndarray,
    rows: np.ndarray,
    counts: np.ndarray,
    log: EventLog,
    edges: Edges,
    w: Work,
) -> int:
    """Integrate over all breaks of `motion`.

    Parameters
    ----------
    model, memory
        Flow model with slopes.
    plant : Plant
        Prepared for dt = 1 s.
    tableau : Tableau
    motion : SpoolMotion
    x0 : (15,) array
    rtol : float
    time : (n_time,) array, s
        Where states are wanted, from 0 on.
    rows : (n_time, N_RECORD) array
        Filled with states; flows are not.
    counts : (4,) array of int
        Filled: steps, rejected steps, events found on the way, and the row reached.
    log : EventLog
        Filled.
    edges : Edges
    w : Work

    Returns
    -------
    int
        DONE, or why not.
    """
    t, piece, part, row, flat = 0.0, 0, 0, 1, 0
    x = from_vector(x0)
    spool = x.spool
    for m in range(12):
        w.y[m] = x0[P_A + m]
    held = settle(model, memory, plant, spool, w.y, w.f, w.free)
    r = evaluate_slow(model, memory, plant, held, w.free, spool, w.y, w.f)
    relief = relief_open(r)
    bits = conditions(x, r.flows.boom.q_relief, r.flows.series.q_relief, edges, plant)
    for m in range(N_STATE):
        rows[0, m] = x0[m]
    h = 1e-3
    while part < motion.breaks.shape[0]:
        if counts[0] + counts[1] >= MAX_STEPS:
            return TOO_MANY
        rest = motion.breaks[part] - t
        number = int(rest / h * (1.0 - 1e-9)) + 1  # equal steps to the next break rather than a last short one
        h_now = rest / number
        c, t_piece = motion.coefficients[piece], motion.starts[piece]
        error = step(model, memory, plant, held, tableau, c, t_piece, t, h_now, r, w, rtol)
        if not error <= 1.0:
            counts[1] += 1
            h = h_now * (max(0.2, 0.9 / sqrt(sqrt(error))) if error < 1e8 else 0.1)
            if h < SMALLEST_STEP:
                return TOO_SMALL
            continue
        counts[0] += 1
        h_next = h_now * min(5.0, 0.9 / sqrt(sqrt(error + 1e-12)))
        h = max(h, h_next) if h_now < 0.9 * h else h_next
        t_new = motion.breaks[part] if number == 1 else t + h_now
        spool_new = spools_at(c, t_piece, t_new).x
        r = evaluate_slow(model, memory, plant, held, w.free, spool_new, w.y_new, w.f_new)
        happened = changes(r, w.y_new, w.free, held, relief, plant)
        share = 1.0
        if happened:
            # the first change within the step; y_stage and f_stage are scratch
            low = 0.0
            for _ in range(50):
                if (share - low) * h_now <= max(1e-3 * rtol * h_now, 1e-12):
                    break
                middle = 0.5 * (low + share)
                between(middle, h_now, w, w.y_stage)
                spool_middle = spools_at(c, t_piece, t + middle * h_now).x
                r = evaluate_slow(model, memory, plant, held, w.free, spool_middle, w.y_stage, w.f_stage)
                late = changes(r, w.y_stage, w.free, held, relief, plant)
                share, low = (middle, low) if late else (share, middle)
            if share < 1.0:
                t_new = t + share * h_now
                spool_new = spools_at(c, t_piece, t_new).x
        while row < time.shape[0] and time[row] <= t_new:
            between(min((time[row] - t) / h_now, share), h_now, w, rows[row, P_A:])
            now = spools_at(c, t_piece, time[row]).x
            rows[row, 0], rows[row, 1], rows[row, 2] = now.swing, now.boom, now.stick
            row += 1
            counts[3] = row
        before = slow_state(spool, w.y)
        between(share, h_now, w, w.y_stage)
        for m in range(12):
            w.y[m] = w.y_stage[m] if share < 1.0 else w.y_new[m]
            w.f[m] = w.f_new[m]
        if happened:
            counts[2] += 1
            flat = flat + 1 if share * h_now < 1e-9 else 0
            if flat > MANY_AT_ONCE:
                return TOO_SMALL
            held = settle(model, memory, plant, spool_new, w.y, w.f, w.free)
            r = evaluate_slow(model, memory, plant, held, w.free, spool_new, w.y, w.f)
            relief = relief_open(r)
        bits = observe(log, bits, t, t_new, before, slow_state(spool_new, w.y), r.flows, edges, plant)
        if not reasonable(Links(w.y[9], w.y[10], w.y[11])):
            return TOO_FAST
        t, spool = t_new, spool_new
        if number == 1 and share == 1.0:
            part += 1
            if part < motion.breaks.shape[0] and t >= motion.starts[piece + 1]:
                piece += 1
    return DONE


def integrate(
    machine: Machine, model: Any, scenario: Scenario, time: np.ndarray, rtol: float
) -> tuple[np.ndarray, dict[str, object]]:
    """Integrate a scenario to a tolerance; arguments and result are those of `lsoda.integrate`.

    Raises
    ------
    InputError
        If the flow model has no slopes.
    SimulationError
        If the run diverges, or steps become too small or too many.
    """
    name = flow_name(model)
    if FLOW_KINDS[name].slopes is None:
        able = [other for other, kind in FLOW_KINDS.items() if kind.slopes is not None]
        raise InputError(
            f"method 'rosenbrock' needs the slopes of the flows, which flow {name!r} does not give; "
            f"use one of {able} or method 'semi-implicit'"
        )
    plant, motion = (
        prepare(machine, 1.0, scenario.locked),
        spool_motion(machine, scenario, max(float(time[-1]), SHORTEST)),
    )
    memory, x0 = np.zeros(FLOW_KINDS[name].n_memory(model)), to_vector(initial_state(machine))
    rows, counts, log = np.empty((len(time), N_RECORD)), np.zeros(4, dtype=np.int64), new_log()
    status = run_rosenbrock(
        model, memory, plant, RODAS, motion, x0, rtol, time, rows, counts, log, edges_of(machine), new_work(RODAS)
    )
    if status != DONE:
        reached = float(time[min(int(counts[3]), len(time) - 1)])
        raise SimulationError(f"{scenario.name} with method 'rosenbrock': {FAILURES[status]} before t = {reached:g} s")
    fill_flows(model, memory, plant, rows)
    steps, rejected, found, _ = (int(count) for count in counts)
    return rows, {"steps": steps, "steps_rejected": rejected, "events_located": found, **listed(log, scenario.locked)}
