"""How close friction from pressures and positions comes to the least that noise of the sensors allows.

``python benchmarks/identify_bound.py [MACHINE] [--noises N] [--seed N]``: ten minutes of one operator, read with other noise each time. The least standard deviation
is the Cramer-Rao bound of the equations of motion with the trajectory unknown, too: positions and pressures are read with noise, so that rows of the equations
err by that of pressures and, through their slopes over five positions, by that of positions. Once of all rows away from stops, and once of those
in which a joint moves faster than two Stribeck rates and static friction is known, which are those that the regression takes.
"""

import argparse

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from identify_sensors import JOINTS, NOISE
from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.fit import fit_mechanics, mechanical_spreads
from polydraulic.identification.equations.mechanics.inertia import inertial_values, torque_regressor
from polydraulic.identification.equations.mechanics.motion_rows import FRICTION, measured_pieces, oil_torques
from polydraulic.tables import Table

PLACES = np.arange(-2, 3)
QUARTIC = np.linalg.inv(np.vander(PLACES, increasing=True).astype(float))
WEIGHTS = [QUARTIC[0], QUARTIC[1], 2.0 * QUARTIC[2]]  # for value, rate and acceleration, a row apart
STEPS = (1e-5, 1e-4, 1e-2)
NEAR_STOP, SLIDING = 0.02, 2.0
OFF, SPREAD = 0.15, 0.3


def friction_regressor(machine, rate):
    n = len(machine.functions)
    found = np.zeros((len(rate), n, 3 * n))
    for k, f in enumerate(machine.functions):
        side, near = np.tanh(rate[:, k] / f.friction.smoothing), np.exp(-((rate[:, k] / f.friction.stribeck) ** 2))
        found[:, k, 3 * k : 3 * k + 3] = np.column_stack([side * (1.0 - near), side * near, rate[:, k]])
    return found


def bounds(machine, run, sliding):
    """Least standard deviations of coulomb, static and viscous friction of each function; nan for what is taken as known."""
    (piece,) = measured_pieces(machine, run)
    raster, count, n = piece.time[1] - piece.time[0], len(piece.time) - 4, len(machine.names)
    motion = [
        sum(w * piece.position[j : j + count] for j, w in enumerate(of)) / raster**k for k, of in enumerate(WEIGHTS)
    ]
    p_a, p_b = piece.p_a[2:-2], piece.p_b[2:-2]
    base = base_parameters(machine)
    to_base, own = np.linalg.pinv(base.combine), inertial_values(machine, base.numbers)
    friction = np.array([getattr(f.friction, name) for f in machine.functions for name in FRICTION])

    def left(q, w, a):
        needed = torque_regressor(machine, base.numbers, q, w, a, machine.gravity) @ own
        return needed + friction_regressor(machine, w) @ friction - oil_torques(machine, q, p_a, p_b)

    noise = np.array(
        [NOISE["position" if machine.link(f.moves).joint == "prismatic" else "angle"] for f in machine.functions]
    )
    known = np.ones((count, n), dtype=bool)
    for k, f in enumerate(machine.functions):
        known[:, k] = (motion[0][:, k] > f.stops.low + NEAR_STOP) & (motion[0][:, k] < f.stops.high - NEAR_STOP)
        known[:, k] &= np.abs(motion[1][:, k]) >= (SLIDING * f.friction.stribeck if sliding else 0.0)
    slope = np.zeros((count, n, 5, n))
    for order, step in enumerate(STEPS):
        for k in range(n):
            once = step * np.eye(n)[k]
            ahead, behind = (
                left(*(v + way * once if i == order else v for i, v in enumerate(motion))) for way in (1.0, -1.0)
            )
            slope[:, :, :, k] += ((ahead - behind) / (2.0 * step))[:, :, None] * (WEIGHTS[order] / raster**order)
    slope = slope * noise * known[:, :, None, None]
    one, none = np.full(p_a.shape, NOISE["p_a"]), np.zeros(p_a.shape)
    oil = oil_torques(machine, motion[0], one, none) ** 2 + oil_torques(machine, motion[0], none, one) ** 2
    band = np.zeros((5 * n, count * n))
    for later in range(5):
        pairs = np.einsum("tijk,tljk->til", slope[later:, :, : 5 - later], slope[: count - later, :, later:])
        for i in range(n):
            for k in range(n):
                if (below := later * n + i - k) >= 0:
                    band[below, k : (count - later) * n : n] = pairs[:, i, k]
    band[0] += np.where(known, oil, 1.0).ravel()
    inertia = torque_regressor(machine, base.numbers, *motion, machine.gravity) @ to_base
    told = [k for k in range(3 * n) if not (sliding and FRICTION[k % 3] == "static")]
    rows = np.concatenate([inertia, friction_regressor(machine, motion[1])[:, :, told]], axis=-1)
    rows = (rows * known[:, :, None]).reshape(count * n, -1)
    information = rows.T @ cho_solve_banded((cholesky_banded(band, lower=True), True), rows)
    scale = np.sqrt(np.diagonal(information))
    covariance = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    found = np.full(3 * n, np.nan)
    found[told] = np.sqrt(np.diagonal(covariance))[-len(told) :]
    return found


def read(run, seed):
    rng, columns = np.random.default_rng(seed), {}
    for name in run.names:
        if name == "time" or name.split(".")[-1] in (*JOINTS, "p_a", "p_b"):
            columns[name] = run[name] + rng.normal(0.0, NOISE.get(name.split(".")[-1], 0.0), len(run))
    return Table(columns, {name: run.unit(name) for name in columns})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("machine", nargs="?", default="cat215b_bucket")
    parser.add_argument("--noises", type=int, default=10)
    parser.add_argument("--seed", type=int, default=21)
    given = parser.parse_args()
    machine = load_machine(given.machine)
    run = simulate(machine, "exact", random_operator(given.seed, 600.0, functions=machine.names), dt=5e-3, every=4)
    rng, truth = np.random.default_rng(given.seed), {number.path: number.value for number in machine.numbers}
    paths = [f"functions.{f}.friction.{name}" for f in machine.names for name in FRICTION]
    begun = {path: truth[path] * np.exp(OFF * rng.normal()) for path in paths}
    for f in machine.names:
        static, coulomb = (f"functions.{f}.friction.{name}" for name in ("static", "coulomb"))
        begun[static] = max(begun[static], 1.05 * begun[coulomb])
    prior = machine.with_values(begun)
    found = []
    for seed in range(given.noises):
        fit = fit_mechanics(read(run, seed), prior, mechanical_spreads(prior, SPREAD))
        found.append([fit.estimates.of(path).value for path in paths])
    off = 100.0 * (np.array(found) / [truth[path] for path in paths] - 1.0)
    least = [100.0 * bounds(machine, run, sliding) / [truth[path] for path in paths] for sliding in (False, True)]
    print(f"{given.machine}: friction from 10 min of pressures and positions, {given.noises} noises, in % of the truth")
    print("| friction | bound, all rows | bound, sliding rows | standard deviation reached | mean error | largest |")
    for k, path in enumerate(paths):
        if not path.endswith("static"):
            _, name, _, kind = path.split(".")
            numbers = (least[0][k], least[1][k], off[:, k].std(ddof=1), off[:, k].mean(), np.abs(off[:, k]).max())
            print(f"| {name}, {kind} | " + " | ".join(f"{v:.2f}" for v in numbers) + " |", flush=True)


if __name__ == "__main__":
    main()
