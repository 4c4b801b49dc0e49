"""One Rosenbrock step of the continuous equations between two events.

Each of its stages solves a linear system with the true Jacobian (`linearised`), so that stiff lines cost nothing extra. Method: RODAS
of Hairer and Wanner (Solving Ordinary Differential Equations II, IV.7), six stages, order 4, error estimate of order 3,
L-stable. Spools are known (`spools`); their motion enters as a drift in time.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver, kernel
from polydraulic.machine.linkage import Held
from polydraulic.machine.plant import Plant
from polydraulic.machine.state import Links, State
from polydraulic.simulation.solvers.adaptive import Tableau
from polydraulic.simulation.solvers.jacobian import Free, Slow, factorise, linearise, solve
from polydraulic.simulation.solvers.right_hand_side import Rates, rates
from polydraulic.simulation.solvers.spools import spools_at

# size of line pressures A and B, angles, rates: sets absolute tolerances
SIZES = np.repeat([1e6, 1e6, 1.0, 1.0], 3)


class Work(NamedTuple):
    """Scratch of the driver: states of 12 numbers (line pressures A, B, angles, rates), and 1 for each line that is free."""

    y: np.ndarray
    f: np.ndarray
    y_new: np.ndarray
    f_new: np.ndarray
    y_stage: np.ndarray
    f_stage: np.ndarray
    stages: np.ndarray  # (n_stage, 12)
    free: np.ndarray  # (6,)
    scale: np.ndarray  # (12,) size of each quantity


def new_work(tableau: Tableau) -> Work:
    """Scratch for a run."""
    y, f, y_new, f_new, y_stage, f_stage = np.zeros((6, 12))
    return Work(y, f, y_new, f_new, y_stage, f_stage, np.zeros((len(tableau.time), 12)), np.ones(6), SIZES)


@kernel
def slow_state(spool: Links, y: np.ndarray) -> State:
    """State from spools and a vector of 12."""
    return State(
        spool, Links(y[0], y[1], y[2]), Links(y[3], y[4], y[5]), Links(y[6], y[7], y[8]), Links(y[9], y[10], y[11])
    )


@kernel
def slow_rates(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    held: Held,
    free: np.ndarray,
    spool: Links,
    y: np.ndarray,
    f: np.ndarray,
) -> Rates:
    """Rates at a state; fills `f` with the time derivative of `y`."""
    r = rates(model, memory, plant, held, slow_state(spool, y))
    f[0], f[1], f[2] = free[0] * r.p_a.swing, free[1] * r.p_a.boom, free[2] * r.p_a.stick
    f[3], f[4], f[5] = free[3] * r.p_b.swing, free[4] * r.p_b.boom, free[5] * r.p_b.stick
    f[6], f[7], f[8] = y[9], y[10], y[11]
    f[9], f[10], f[11] = r.acceleration.swing, r.acceleration.boom, r.acceleration.stick
    return r


@driver
def evaluate_slow(
    model: Any,
    memory: np.ndarray,
    plant: Plant,
    held: Held,
    free: np.ndarray,
    spool: Links,
    y: np.ndarray,
    f: np.ndarray,
) -> Rates:
    """`slow_rates` as a function of its own: where it is called in many places, it is compiled once."""
    return slow_rates(model, memory, plant, held, free, spool, y, f)


@kernel
def store_slow(x: State, y: np.ndarray) -> None:
    """Write all of a state but the spools into a vector of 12."""
    y[0], y[1], y[2] = x.p_a.swing, x.p_a.boom, x.p_a.stick
    y[3], y[4], y[5] = x.p_b.swing, x.p_b.boom, x.p_b.stick
    y[6], y[7], y[8] = x.angle.swing, x.angle.boom, x.angle.stick
    y[9], y[10], y[11] = x.rate.swing, x.rate.boom, x.rate.stick


@kernel
def _by_port(v: np.ndarray, inside: Links) -> Slow:
    """Vector of 12 in terms of fed port and outlet."""
    s, b, k = inside.swing >= 0.0, inside.boom >= 0.0, inside.stick >= 0.0
    return Slow(
        Links(v[0] if s else v[3], v[1] if b else v[4], v[2] if k else v[5]),
        Links(v[3] if s else v[0], v[4] if b else v[1], v[5] if k else v[2]),
        Links(v[6], v[7], v[8]),
        Links(v[9], v[10], v[11]),
    )


@kernel
def _by_line(x: Slow, inside: Links, v: np.ndarray) -> None:
    s, b, k = inside.swing >= 0.0, inside.boom >= 0.0, inside.stick >= 0.0
    i, o = x.p_in, x.p_out
    v[0], v[1], v[2] = i.swing if s else o.swing, i.boom if b else o.boom, i.stick if k else o.stick
    v[3], v[4], v[5] = o.swing if s else i.swing, o.boom if b else i.boom, o.stick if k else i.stick
    v[6], v[7], v[8] = x.angle.swing, x.angle.boom, x.angle.stick
    v[9], v[10], v[11] = x.rate.swing, x.rate.boom, x.rate.stick


@driver
def step(
    model: Any, memory: np.ndarray, plant: Plant, held: Held, tableau: Tableau, coefficients: np.ndarray,
    t_piece: float, t: float, h: float, r: Rates, w: Work, rtol: float,
) -> float:  # fmt: skip
    """One step of size `h` from `w.y`, where the rates are `r` and `w.f`, to `w.y_new`; returns the error over the tolerance."""
    here, inside = spools_at(coefficients, t_piece, t), spools_at(coefficients, t_piece, t + 0.5 * h).x
    free = Free(Links(w.free[0], w.free[1], w.free[2]), Links(w.free[3], w.free[4], w.free[5]))
    lin = linearise(model, plant, slow_state(here.x, w.y), r, inside, here.v, free)
    factors = factorise(1.0 / (tableau.gamma * h), lin, r, held)
    drift, n = lin.drift, tableau.time.shape[0]
    for i in range(n):
        for m in range(12):
            w.y_stage[m] = w.y[m]
            w.f_stage[m] = w.f[m]
        if i > 0:
            for j in range(i):
                for m in range(12):
                    w.y_stage[m] += tableau.a[i, j] * w.stages[j, m]
            spool = spools_at(coefficients, t_piece, t + tableau.time[i] * h).x
            slow_rates(model, memory, plant, held, w.free, spool, w.y_stage, w.f_stage)
            for j in range(i):
                for m in range(12):
                    w.f_stage[m] += tableau.c[i, j] / h * w.stages[j, m]
        right = _by_port(w.f_stage, inside)
        d = tableau.d[i] * h
        right = Slow(
            Links(
                right.p_in.swing + d * drift.p_in.swing,
                right.p_in.boom + d * drift.p_in.boom,
                right.p_in.stick + d * drift.p_in.stick,
            ),
            Links(
                right.p_out.swing + d * drift.p_out.swing,
                right.p_out.boom + d * drift.p_out.boom,
                right.p_out.stick + d * drift.p_out.stick,
            ),
            right.angle,
            right.rate,
        )
        _by_line(solve(right, factors, lin, r, held), inside, w.stages[i])
    total = 0.0
    for m in range(12):
        error = w.stages[n - 1, m]
        w.y_new[m] = w.y_stage[m] + error
        size = rtol * (w.scale[m] + max(abs(w.y[m]), abs(w.y_new[m])))
        total += error * error / (size * size)
    return sqrt(total / 12.0)


@kernel
def between(share: float, h: float, w: Work, y: np.ndarray) -> None:
    """Cubic through both ends of a step, with their slopes."""
    a, b = share, 1.0 - share
    for m in range(12):
        rise = w.y_new[m] - w.y[m]
        bend = a * b * ((b - a) * rise - b * h * w.f[m] + a * h * w.f_new[m])
        y[m] = w.y[m] + a * rise - bend
