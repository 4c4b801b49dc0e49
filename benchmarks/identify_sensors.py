"""Numbers of a machine from logs that lack sensors: how far they are from the truth.

``python benchmarks/identify_sensors.py [MACHINE ...] [--seed N]``: for each machine masses and friction from pressures and positions of ten
minutes by regression, then numbers through simulation from a minute with fewer and fewer sensors. Nothing was chosen by these seeds.
"""

import argparse
import time

import numpy as np

from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.fit import fit_mechanics, mechanical_spreads
from polydraulic.identification.equations.mechanics.inertia import inertial_values
from polydraulic.identification.equations.shooting.fit import fit_by_shooting
from polydraulic.identification.equations.shooting.windows import sensors_of
from polydraulic.tables import Table

NOISE = {
    "angle": np.radians(0.03),
    "position": 1e-3,
    "p_a": 1e5,
    "p_b": 1e5,
    "spool": 4e-5,
    "q_in": 8e-6,
    "q_out": 8e-6,
}
JOINTS = ("angle", "position")
SETS = {
    "commands and angles alone": JOINTS,
    "no flows, no spools": (*JOINTS, "p_a", "p_b"),
    "no flows, no pressures": (*JOINTS, "spool"),
    "no flows": (*JOINTS, "p_a", "p_b", "spool"),
    "all sensors": tuple(NOISE),
}
FREE = ("pilot.gain", "pilot.time_constant", "pump.flow", "friction.coulomb", "friction.static", "friction.viscous")
GROUPS = ("gain", "time_constant", "flow", "coulomb", "viscous", "mass")
OFF, SPREAD = 0.15, 0.2  # of the truth: how far numbers to begin with are off, and what the priors say


def log_of(machine, seed, seconds):
    """What sensors read of a random operator's work, every 20 ms."""
    run = simulate(machine, "exact", random_operator(seed, seconds, functions=machine.names), dt=5e-3, every=4)
    rng = np.random.default_rng(seed)
    columns = {}
    for name in run.names:
        columns[name] = run[name] + rng.normal(0.0, NOISE.get(name.split(".")[-1], 0.0), len(run))
    return Table(columns, {name: run.unit(name) for name in run.names})


def begun(machine, paths, rng):
    """The machine with other numbers, and how far they may be off."""
    truth = {number.path: number.value for number in machine.numbers}
    values = {path: truth[path] * np.exp(OFF * rng.normal()) for path in paths}
    for f in machine.names:
        static, coulomb = (f"functions.{f}.friction.{name}" for name in ("static", "coulomb"))
        if static in values:
            values[static] = max(values[static], 1.05 * values[coulomb])
    return machine.with_values(values), {path: SPREAD * truth[path] for path in paths}, truth


def mechanics(name, seed):
    machine, rng = load_machine(name), np.random.default_rng(seed)
    truth = {number.path: number.value for number in machine.numbers}
    spreads = mechanical_spreads(machine, 0.3)
    values = {}
    for path in spreads:
        scale = rng.uniform(0.75, 1.3)
        values[path] = truth[path] * (0.8 if ".inertia." in path else scale)
    for f in machine.names:
        values[f"functions.{f}.friction.static"] = 1.4 * values[f"functions.{f}.friction.coulomb"]
    log = log_of(machine, seed, 600.0)
    began = time.perf_counter()
    prior = machine.with_values(values)
    fit = fit_mechanics(log, prior, mechanical_spreads(prior, 0.3))
    seconds = time.perf_counter() - began
    base = base_parameters(machine)
    true_base = base.combine @ inertial_values(machine, base.numbers)
    off = np.array([abs(b.value / t - 1.0) for b, t in zip(fit.base, true_base, strict=True)])
    sharp = np.array([b.sd < 0.05 * abs(b.value) for b in fit.base])
    print(
        f"{name}: masses and friction from 10 min of pressures and angles, by regression ({seconds:.0f} s): {sharp.sum()} of {len(off)} base "
        f"parameters known to 5 % (one standard deviation), of these off by {100 * np.median(off[sharp]):.2f} % (median), {100 * off[sharp].max():.1f} % "
        "(largest)",
        flush=True,
    )
    for kind in ("coulomb", "viscous"):
        own = [abs(e.value / truth[e.path] - 1.0) for e in fit.estimates.numbers if e.path.endswith(kind)]
        print(
            f"  {kind} friction off by {100 * np.median(own):.2f} % (median), {100 * np.max(own):.1f} % (largest)",
            flush=True,
        )


def sensors(name, seed):
    machine = load_machine(name)
    paths = [n.path for n in machine.numbers if n.path.endswith(FREE)] + [f"links.{machine.tip[0]}.mass"]
    prior, spreads, truth = begun(machine, paths, np.random.default_rng(seed))
    log = log_of(machine, seed, 67.0)
    print(
        f"{name}: {len(paths)} numbers that begin {100 * OFF:.0f} % off, through simulation of 64 windows of 1 s; largest error in % by kind"
    )
    print(f"  {'sensors':28s}" + "".join(f"{group:>15s}" for group in GROUPS) + f"{'determined':>12s}{'s':>6s}")
    for title, kinds in SETS.items():
        columns = [column for column in sensors_of(machine, log) if column.split(".")[-1] in kinds]
        began = time.perf_counter()
        fit = fit_by_shooting(log, prior, spreads, sensors=columns, seconds=1.0, most=64)
        seconds = time.perf_counter() - began
        numbers = fit.estimates.numbers
        worst = [
            max(100 * abs(e.value / truth[e.path] - 1.0) for e in numbers if e.path.endswith(f".{group}"))
            for group in GROUPS
        ]
        known = sum(e.determined for e in numbers)
        print(
            f"  {title:28s}" + "".join(f"{w:15.2f}" for w in worst) + f"{known:9d}/{len(numbers)}{seconds:6.0f}",
            flush=True,
        )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("machines", nargs="*", default=["loader_crane", "cat215b_bucket"])
    parser.add_argument("--seed", type=int, default=21)
    given = parser.parse_args()
    for name in given.machines:
        mechanics(name, given.seed)
    for name in given.machines:
        sensors(name, given.seed)


if __name__ == "__main__":
    main()
