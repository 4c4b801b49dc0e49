"""A block of machines side by side: the stages of `machine_step` as loops over lanes, and the time loop around them.

Each stage calls the kernels of the scalar step, so that there is one text of the physics and the bits are the same. Loops of
one stage each, with the values between them in rows, vectorise better than one long loop and stay in the cache.
"""

from typing import Any

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.flow.dispatch import flow_lanes
from polydraulic.flow.interface import OK, Flows
from polydraulic.flow.lanes import LANES, N_FLOW_ROW, OUTLET, P_IN, at, get, get_links, put, put_links
from polydraulic.flow.record import ANGLE, P_A, P_B, Q_IN, Q_OUT, RATE, SPOOL
from polydraulic.machine.joints import Levers, Position, accelerated, moved, net_torque, passing, position, turned
from polydraulic.machine.linkage import Motion, Symmetric, solve_motion
from polydraulic.machine.pump import Circuit
from polydraulic.machine.state import Links, State
from polydraulic.simulation.lane_blocks import Kept, LaneBlock, keep_final, keep_range, keep_row
from polydraulic.simulation.loop import reasonable, rest_outlets
from polydraulic.simulation.step import lines, seen_pressures, spools

P_OUT, STEPS = N_FLOW_ROW, N_FLOW_ROW + 3
_VOLTAGE = STEPS + 1
_LEVER_A, _LEVER_B, _MASS, _BIAS, _GRAVITY = _VOLTAGE + 3, _VOLTAGE + 6, _VOLTAGE + 9, _VOLTAGE + 15, _VOLTAGE + 18
_OLD_ANGLE, _OLD_RATE, _ACCELERATION, _MET = _VOLTAGE + 21, _VOLTAGE + 24, _VOLTAGE + 27, _VOLTAGE + 30
N_ROW = _MET + 1


@kernel
def _state(rows: np.ndarray, lane: int) -> State:
    return State(
        get_links(rows, SPOOL, lane),
        get_links(rows, P_A, lane),
        get_links(rows, P_B, lane),
        get_links(rows, ANGLE, lane),
        get_links(rows, RATE, lane),
    )


@kernel
def _levers(rows: np.ndarray, lane: int) -> Levers:
    return Levers(get_links(rows, _LEVER_A, lane), get_links(rows, _LEVER_B, lane))


@kernel
def _mass(rows: np.ndarray, lane: int) -> Symmetric:
    a, b = get_links(rows, _MASS, lane), get_links(rows, _MASS + 3, lane)
    return Symmetric(a.swing, a.boom, a.stick, b.swing, b.boom, b.stick)


@kernel
def _pilot_stage(plant: Any, own: Any, rows: np.ndarray) -> None:
    for lane in range(LANES):
        p = at(own, plant, lane)
        spool = spools(get_links(rows, SPOOL, lane), get_links(rows, _VOLTAGE, lane), p)
        put_links(rows, SPOOL, lane, spool)
        seen = seen_pressures(spool, get_links(rows, P_A, lane), get_links(rows, P_B, lane))
        put_links(rows, P_IN, lane, seen.p_in)


@kernel
def _position_stage(plant: Any, own: Any, rows: np.ndarray) -> None:
    for lane in range(LANES):
        here = position(get_links(rows, ANGLE, lane), get_links(rows, RATE, lane), at(own, plant, lane))
        m = here.motion.mass
        put_links(rows, _LEVER_A, lane, here.levers.a)
        put_links(rows, _LEVER_B, lane, here.levers.b)
        put_links(rows, _MASS, lane, Links(m.m11, m.m12, m.m13))
        put_links(rows, _MASS + 3, lane, Links(m.m22, m.m23, m.m33))
        put_links(rows, _BIAS, lane, here.motion.bias)
        put_links(rows, _GRAVITY, lane, here.motion.gravity)


@kernel
def _hose_stage(plant: Any, own: Any, rows: np.ndarray) -> None:
    for lane in range(LANES):
        x, none = _state(rows, lane), Circuit(0.0, 0.0, 0.0, 0.0, 0.0)
        flows = Flows(get_links(rows, Q_IN, lane), get_links(rows, OUTLET, lane), none, none, 0.0, OK)
        after = lines(x.spool, x, flows, _levers(rows, lane), at(own, plant, lane))
        put_links(rows, P_A, lane, after.p_a)
        put_links(rows, P_B, lane, after.p_b)
        put_links(rows, Q_OUT, lane, after.q_out)


@kernel
def _motion_stage(plant: Any, own: Any, rows: np.ndarray) -> int:
    """Move the joints as if there were no stops; how many machines meet one."""
    count = 0
    for lane in range(LANES):
        p = at(own, plant, lane)
        angle, rate, mass = get_links(rows, ANGLE, lane), get_links(rows, RATE, lane), _mass(rows, lane)
        motion = Motion(mass, get_links(rows, _BIAS, lane), get_links(rows, _GRAVITY, lane))
        here = Position(_levers(rows, lane), motion)
        torque = net_torque(here, get_links(rows, P_A, lane), get_links(rows, P_B, lane), rate, p)
        acceleration = solve_motion(mass, p.locked, torque)
        free = accelerated(rate, acceleration, p.dt)
        met = passing(angle, free, p)
        put_links(rows, _OLD_ANGLE, lane, angle)
        put_links(rows, _OLD_RATE, lane, rate)
        put_links(rows, _ACCELERATION, lane, acceleration)
        put_links(rows, ANGLE, lane, turned(angle, free, met, p))
        put_links(rows, RATE, lane, free)
        stopped = 1 if (met.swing or met.boom or met.stick) else 0
        put(rows, _MET, lane, float(stopped))
        count += stopped
    return count


@kernel
def _stop_stage(plant: Any, own: Any, rows: np.ndarray) -> None:
    """Move the joints of machines that meet a stop once more, with its impulses."""
    for lane in range(LANES):
        if get(rows, _MET, lane) > 0.0:
            after = moved(
                get_links(rows, _OLD_ANGLE, lane),
                get_links(rows, _OLD_RATE, lane),
                get_links(rows, _ACCELERATION, lane),
                _mass(rows, lane),
                at(own, plant, lane),
            )
            put_links(rows, ANGLE, lane, after.angle)
            put_links(rows, RATE, lane, after.rate)


@kernel
def _rest_stage(plant: Any, own: Any, rows: np.ndarray) -> None:
    """Outlet flows at the start."""
    for lane in range(LANES):
        p_out = get_links(rows, P_OUT, lane)
        put_links(rows, Q_OUT, lane, rest_outlets(get_links(rows, OUTLET, lane), p_out, at(own, plant, lane)))


@kernel
def _see_stage(rows: np.ndarray) -> None:
    for lane in range(LANES):
        x = _state(rows, lane)
        seen = seen_pressures(x.spool, x.p_a, x.p_b)
        put_links(rows, P_IN, lane, seen.p_in)
        put_links(rows, P_OUT, lane, seen.p_out)


@kernel
def _count_stage(rows: np.ndarray, k: int, n_step: int) -> int:
    """Note the step in which a rate diverged; in how many machines one has."""
    count = 0
    for lane in range(LANES):
        steps = get(rows, STEPS, lane)
        steps = min(steps, float(n_step if reasonable(get_links(rows, RATE, lane)) else k))
        put(rows, STEPS, lane, steps)
        count += 1 if steps < float(n_step) else 0
    return count


@kernel
def _halt_stage(rows: np.ndarray, n_step: int) -> None:
    """Keep machines that have diverged from calculating with NaN."""
    for lane in range(LANES):
        if get(rows, STEPS, lane) < float(n_step):
            put_links(rows, ANGLE, lane, Links(0.0, 0.0, 0.0))
            put_links(rows, RATE, lane, Links(0.0, 0.0, 0.0))


@kernel
def _read_voltages(voltage: np.ndarray, k: int, block: LaneBlock) -> None:
    for lane in range(LANES):
        i = block.signal[lane]
        put_links(block.rows, _VOLTAGE, lane, Links(voltage[i, k, 0], voltage[i, k, 1], voltage[i, k, 2]))


@driver
def run_block(
    model: Any, own_model: Any, plant: Any, own_plant: Any, voltage: np.ndarray, block: LaneBlock, kept: Kept
) -> None:
    """Run a block of machines through all voltages.

    Parameters
    ----------
    model, plant : flow model and Plant
        Those of all machines, or of one of them where they differ.
    own_model, own_plant : None or flat arrays of rows
        Parameters of each machine where they differ; see `at`.
    voltage : (n_signal, n_step, 3) array, V
    block : LaneBlock
    kept : Kept
        Filled in the places of the block's machines.
    """
    n_step, rows, ranges = voltage.shape[1], block.rows, block.lowest.shape[0] > 0
    for lane in range(LANES):
        put(rows, STEPS, lane, float(n_step))
    for k in range(-1, n_step):  # -1: the start, where nothing moves yet
        kept_now = kept.every > 0 and (k + 1) % kept.every == 0
        seen_now = kept_now or ranges or k < 0 or k + 1 == n_step
        if k < 0:
            _see_stage(rows)
        else:
            _read_voltages(voltage, k, block)
            _pilot_stage(plant, own_plant, rows)
        flow_lanes(model, own_model, rows, kept.circuits and seen_now)
        if k < 0:
            _rest_stage(plant, own_plant, rows)
        else:
            _position_stage(plant, own_plant, rows)
            _hose_stage(plant, own_plant, rows)
            if _motion_stage(plant, own_plant, rows) > 0:
                _stop_stage(plant, own_plant, rows)
            if _count_stage(rows, k, n_step) > 0:
                _halt_stage(rows, n_step)
            if seen_now:
                _see_stage(rows)
        if kept_now:
            keep_row(block, kept, (k + 1) // kept.every)
        if ranges:
            keep_range(block, kept)
    keep_final(block, kept)
