"""How often 90 % intervals of identified numbers hold the truth, over short logs of a random operator with the noise of sensors.

``python benchmarks/identify_intervals.py [MACHINE] [--logs N] [--first SEED] [--ways flows pressures runs]``: by flows, five minutes with all sensors
and a file whose conductances are off by up to half; by pressures, masses and friction from five minutes of positions and pressures; by
runs, pilots, pumps and a mass from 35 s of commands and positions alone. Nothing was chosen by these seeds. A curve is compared at its
knots, within the travel of the log, where the valve is open and the curve is said to be known within a tenth of its largest value.
"""

import argparse

import numpy as np
from joblib import Parallel, cpu_count, delayed

from identify_sensors import JOINTS, begun, log_of
from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification import identify
from polydraulic.identification.equations.mechanics.base_parameters import base_parameters
from polydraulic.identification.equations.mechanics.fit import fit_mechanics, mechanical_spreads
from polydraulic.identification.equations.mechanics.inertia import inertial_values
from polydraulic.identification.equations.numbers.estimates import COVERED
from polydraulic.identification.equations.shooting.fit import fit_by_shooting
from polydraulic.identification.equations.shooting.windows import sensors_of
from polydraulic.thesis.rough_machine import rough_machine
from show import table

FREE = ("pilot.gain", "pilot.time_constant", "pump.flow")
CURVES = ("inlet", "bypass", "outlet_positive", "outlet_negative")
SPREAD, OFF, OFF_INERTIA = 0.3, 0.15, 0.05


def by_flows(machine, seed):
    """Kind, error and standard error of pilots, pumps and curves."""
    log = log_of(machine, seed, 300.0)
    found = identify(log, rough_machine(machine, np.random.default_rng(seed)))
    truth = {number.path: number.value for number in machine.numbers}
    for path, new in found.changes.items():
        if path in truth:
            yield path.split(".")[-1], new.value - truth[path], new.uncertainty
    for circuit in found.circuits.values():
        for name, v in circuit.valves.items():
            knots, true = np.array(v.curves.knots), machine.function(name).valve
            inside = (knots > v.seen[0]) & (knots < v.seen[1])
            for key in CURVES:
                values, errors = np.array(getattr(v.curves, key)), v.errors[key]
                known = inside & (errors < 0.1 * values.max()) & (errors > 0.0)
                off = values - np.interp(knots, true.knots, getattr(true, key))
                for k in np.flatnonzero(known):
                    yield "outlet" if "outlet" in key else key, off[k], errors[k]


def prior_of(machine, rng):
    """A machine with other masses and friction, all of them possible."""
    truth = {number.path: number.value for number in machine.numbers}
    for _ in range(100):
        values = {
            path: truth[path] * np.exp((OFF_INERTIA if ".inertia." in path else OFF) * rng.normal())
            for path in mechanical_spreads(machine, SPREAD)
        }
        for f in machine.names:
            static, coulomb = (f"functions.{f}.friction.{name}" for name in ("static", "coulomb"))
            values[static] = max(values[static], 1.05 * values[coulomb])
        try:
            return machine.with_values(values)
        except InputError:
            continue
    raise SystemExit("no possible machine among a hundred")


def by_pressures(machine, seed):
    """The same of what motion determines of masses, and of friction."""
    prior = prior_of(machine, np.random.default_rng(seed))
    fit = fit_mechanics(log_of(machine, seed, 300.0), prior, mechanical_spreads(prior, SPREAD))
    base = base_parameters(machine)
    for b, true in zip(fit.base, base.combine @ inertial_values(machine, base.numbers), strict=True):
        if b.determined:
            yield "inertia and gravity", b.value - true, b.sd
    truth = {number.path: number.value for number in machine.numbers}
    for e in fit.estimates.numbers:
        if e.determined and ".friction." in e.path:
            yield e.path.split(".")[-1], e.value - truth[e.path], e.sd


def by_runs(machine, seed):
    """The same of pilots, pumps and the last link's mass."""
    paths = [n.path for n in machine.numbers if n.path.endswith(FREE)] + [f"links.{machine.tip[0]}.mass"]
    prior, spreads, truth = begun(machine, paths, np.random.default_rng(seed))
    log = log_of(machine, seed, 35.0)
    columns = [column for column in sensors_of(machine, log) if column.split(".")[-1] in JOINTS]
    for e in fit_by_shooting(log, prior, spreads, sensors=columns, seconds=1.0, most=32).estimates.numbers:
        if e.determined:
            yield e.path.split(".")[-1], e.value - truth[e.path], e.sd


WAYS = {"flows": by_flows, "pressures": by_pressures, "runs": by_runs}


def listed(way, machine, seed):
    """All of one log."""
    return list(WAYS[way](machine, seed))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machine", nargs="?", default="loader_crane")
    parser.add_argument("--logs", type=int, default=20)
    parser.add_argument("--first", type=int, default=1001)
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    given = parser.parse_args()
    machine, rows = load_machine(given.machine), []
    for way in given.ways:
        all_of, seeds = {}, range(given.first, given.first + given.logs)
        found = Parallel(n_jobs=cpu_count(), return_as="generator")(delayed(listed)(way, machine, s) for s in seeds)
        for seed, own in zip(seeds, found, strict=True):
            for kind, off, sd in own:
                all_of.setdefault(kind, []).append(abs(off) / max(sd, 1e-300))
            inside = sum(abs(off) <= COVERED * sd for _, off, sd in own)
            print(f"  {way}, log {seed}: {inside} of {len(own)}", flush=True)
        all_of["all"] = [z for of_kind in all_of.values() for z in of_kind]
        for kind, z in all_of.items():
            share = np.mean(np.array(z) <= COVERED)
            rows.append([way, kind, str(len(z)), f"{100 * share:.0f} %", f"{np.sqrt(np.mean(np.square(z))):.2f}"])
    heads = ["way", "number", "intervals", "hold the truth", "rms error, in standard errors"]
    table(f"{given.machine}: 90 % intervals over {given.logs} logs", heads, rows)


if __name__ == "__main__":
    main()
