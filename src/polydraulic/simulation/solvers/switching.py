"""Conditions under which the equations are smooth: lines within their bounds, joints held or free, relief valves open or shut.

A solver that keeps them for a whole step asks `changes` at its end, finds when, and lets `settle` set new ones.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.solvers.line_rates import line_changes, line_moves
from polydraulic.simulation.solvers.right_hand_side import Rates, bounded_pressures, held_at_stops, landed, resting
from polydraulic.simulation.solvers.rosenbrock_step import evaluate_slow, slow_state, store_slow
from polydraulic.simulation.solvers.stop_conditions import CREEP, joint_changes


class Relief(NamedTuple):
    """Which pumps' relief valves are open."""

    boom: bool
    series: bool


@kernel
def relief_open(r: Rates) -> Relief:
    """Which pumps' relief valves are open."""
    return Relief(r.flows.boom.q_relief > 1e-12, r.flows.series.q_relief > 1e-12)


@kernel
def changes(r: Rates, y: np.ndarray, free: np.ndarray, held: Held, relief: Relief, plant: Plant) -> bool:
    """Whether a condition has changed under which the equations were smooth."""
    swing, boom, stick, now = plant.swing, plant.boom, plant.stick, relief_open(r)
    return (
        line_changes(y[0], r.p_a.swing, free[0], swing.line)
        or line_changes(y[1], r.p_a.boom, free[1], boom.line)
        or line_changes(y[2], r.p_a.stick, free[2], stick.line)
        or line_changes(y[3], r.p_b.swing, free[3], swing.line)
        or line_changes(y[4], r.p_b.boom, free[4], boom.line)
        or line_changes(y[5], r.p_b.stick, free[5], stick.line)
        or joint_changes(y[6], r.reaction.swing, held.swing, plant.locked.swing, swing.stops)
        or joint_changes(y[7], r.reaction.boom, held.boom, plant.locked.boom, boom.stops)
        or joint_changes(y[8], r.reaction.stick, held.stick, plant.locked.stick, stick.stops)
        or now.boom != relief.boom
        or now.series != relief.series
    )


@driver
def settle(
    model: Any, memory: np.ndarray, plant: Plant, spool: Links, y: np.ndarray, f: np.ndarray, free: np.ndarray
) -> Held:
    """Put pressures and joints back to their bounds, with the impulses of stops; find which lines are free and joints held."""
    x = slow_state(spool, y)
    joints = landed(x.angle, x.rate, plant)
    x = State(spool, bounded_pressures(x.p_a, plant), bounded_pressures(x.p_b, plant), joints.angle, joints.rate)
    store_slow(x, y)
    held = resting(x, CREEP, plant)
    held = held_at_stops(held, x, evaluate_slow(model, memory, plant, held, free, spool, y, f), plant)
    y[9] = 0.0 if held.swing else y[9]
    y[10] = 0.0 if held.boom else y[10]
    y[11] = 0.0 if held.stick else y[11]
    r = evaluate_slow(model, memory, plant, held, free, spool, y, f)
    free[0], free[3] = line_moves(y[0], r.p_a.swing, plant.swing.line), line_moves(y[3], r.p_b.swing, plant.swing.line)
    free[1], free[4] = line_moves(y[1], r.p_a.boom, plant.boom.line), line_moves(y[4], r.p_b.boom, plant.boom.line)
    free[2], free[5] = line_moves(y[2], r.p_a.stick, plant.stick.line), line_moves(y[5], r.p_b.stick, plant.stick.line)
    return held
