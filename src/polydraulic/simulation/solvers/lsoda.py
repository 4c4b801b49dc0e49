"""Reference solution: the continuous equations through an implicit SciPy solver with tight tolerances. The yardstick of the other methods.

LSODA replaces the Rosenbrock method, nothing else: spools are known in closed form (`spools`), and the integration stops at the corners of
voltages and orifice tables and where lines, joints and relief valves change their conditions (`smooth`).
"""

import itertools
from typing import Any

import numpy as np
from scipy.integrate import LSODA

from polydraulic._kernel import driver
from polydraulic.errors import SimulationError
from polydraulic.flow.dispatch import FLOW_KINDS, flow_name
from polydraulic.flow.record import N_RECORD, N_STATE, P_A, to_vector
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import Plant, prepare
from polydraulic.machine.state import initial_state
from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Machine
from polydraulic.simulation.events import Edges, EventLog, edges_of, listed, new_log, observe
from polydraulic.simulation.solvers.right_hand_side import fill_flows
from polydraulic.simulation.solvers.rosenbrock_step import SIZES, evaluate_slow, slow_state
from polydraulic.simulation.solvers.spools import SHORTEST, spool_motion, spools_at
from polydraulic.simulation.solvers.switching import Relief, changes, relief_open, settle

_MAX_EVALUATIONS = 5_000_000
_MAX_EVENTS = 10_000
_MAX_STEP = 0.02  # s


@driver
def _slope(
    model: Any, memory: np.ndarray, plant: Plant, held: Held, free: np.ndarray, c: np.ndarray, t0: float, t: float,
    y: np.ndarray, f: np.ndarray,
) -> None:  # fmt: skip
    evaluate_slow(model, memory, plant, held, free, spools_at(c, t0, t).x, y, f)


@driver
def _changes(
    model: Any, memory: np.ndarray, plant: Plant, held: Held, free: np.ndarray, c: np.ndarray, t0: float, t: float,
    y: np.ndarray, f: np.ndarray, relief: Relief,
) -> bool:  # fmt: skip
    r = evaluate_slow(model, memory, plant, held, free, spools_at(c, t0, t).x, y, f)
    return changes(r, y, free, held, relief, plant)


@driver
def _settle(
    model: Any, memory: np.ndarray, plant: Plant, free: np.ndarray, c: np.ndarray, t0: float, t: float, y: np.ndarray,
    f: np.ndarray,
) -> tuple[Held, Relief]:  # fmt: skip
    spool = spools_at(c, t0, t).x
    held = settle(model, memory, plant, spool, y, f, free)
    return held, relief_open(evaluate_slow(model, memory, plant, held, free, spool, y, f))


@driver
def _observe(
    model: Any, memory: np.ndarray, plant: Plant, held: Held, free: np.ndarray, c: np.ndarray, t0: float,
    before: float, after: float, y_before: np.ndarray, y: np.ndarray, f: np.ndarray, log: EventLog, bits: int, edges: Edges,
) -> int:  # fmt: skip
    old, new = spools_at(c, t0, before).x, spools_at(c, t0, after).x
    r = evaluate_slow(model, memory, plant, held, free, new, y, f)
    return observe(log, bits, before, after, slow_state(old, y_before), slow_state(new, y), r.flows, edges, plant)


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
        Evaluations, events located, and the events.

    Raises
    ------
    SimulationError
        If the solver fails, or events do not end.
    """
    plant, motion = (
        prepare(machine, 1.0, scenario.locked),
        spool_motion(machine, scenario, max(float(time[-1]), SHORTEST)),
    )
    memory = np.zeros(FLOW_KINDS[flow_name(model)].n_memory(model))
    x0, rows, f, free = to_vector(initial_state(machine)), np.empty((len(time), N_RECORD)), np.empty(12), np.ones(6)
    log, edges, evaluations, located = new_log(), edges_of(machine), 0, 0
    y, rows[0, :N_STATE], row = x0[P_A:].copy(), x0, 1
    c, t_piece = motion.coefficients[0], 0.0
    held, relief = _settle(model, memory, plant, free, c, t_piece, 0.0, y, f)
    bits = _observe(model, memory, plant, held, free, c, t_piece, 0.0, 0.0, y, y, f, new_log(), 0, edges)
    for t, end in itertools.pairwise([0.0, *motion.breaks]):
        piece = int(np.searchsorted(motion.starts, t + 1e-12, side="right")) - 1
        c, t_piece = motion.coefficients[piece], float(motion.starts[piece])

        while t < end:

            def slope(
                t: float, y: np.ndarray, c: np.ndarray = c, t_piece: float = t_piece, held: Held = held
            ) -> np.ndarray:
                nonlocal evaluations
                evaluations += 1
                if evaluations > _MAX_EVALUATIONS:
                    raise SimulationError(
                        f"reference solution of {scenario.name}: more than {_MAX_EVALUATIONS} evaluations"
                    )
                _slope(model, memory, plant, held, free, c, t_piece, t, y, f)
                return f.copy()

            solver = LSODA(slope, t, y, end, rtol=rtol, atol=rtol * SIZES, max_step=_MAX_STEP)
            happened = False
            while solver.status == "running" and not happened:
                before, y_before = solver.t, y
                message = solver.step()
                if solver.status == "failed":
                    raise SimulationError(f"reference solution of {scenario.name}: {message}")
                dense, t, y = solver.dense_output(), solver.t, solver.y.copy()
                happened = _changes(model, memory, plant, held, free, c, t_piece, t, y, f, relief)
                if happened:
                    low = before
                    while t - low > 1e-12 * max(1.0, t):
                        middle = 0.5 * (low + t)
                        late = _changes(model, memory, plant, held, free, c, t_piece, middle, dense(middle), f, relief)
                        t, low = (middle, low) if late else (t, middle)
                    y = dense(t)
                while row < len(time) and time[row] <= t:
                    rows[row, :P_A], rows[row, P_A:N_STATE] = spools_at(c, t_piece, time[row]).x, dense(time[row])
                    row += 1
                if happened:
                    located += 1
                    if located > _MAX_EVENTS:
                        raise SimulationError(
                            f"reference solution of {scenario.name}: more than {_MAX_EVENTS} events by {t:g} s"
                        )
                    held, relief = _settle(model, memory, plant, free, c, t_piece, t, y, f)
                bits = _observe(
                    model, memory, plant, held, free, c, t_piece, before, t, y_before, y, f, log, bits, edges
                )
    fill_flows(model, memory, plant, rows)
    return rows, {"evaluations": evaluations, "events_located": located, **listed(log, scenario.locked)}
