"""How often 90 % intervals of identified numbers hold the truth, over short logs of a random operator with the noise of sensors.

``python benchmarks/identify_intervals.py [MACHINE ...] [--logs N] [--first SEED]``: five minutes with all sensors and a file whose conductances are off by
up to half. Nothing was chosen by these seeds. A curve is compared at its knots, within the travel of the log, where the valve is open and the
curve is said to be known within a tenth of its largest value. Ways without flows: ``benchmarks/identify_intervals_others.py``.
"""

import argparse

import numpy as np
from joblib import Parallel, cpu_count, delayed

from identify_sensors import log_of
from polydraulic import load_machine
from polydraulic.identification import identify
from polydraulic.identification.equations.numbers.estimates import COVERED
from polydraulic.thesis.rough_machine import rough_machine
from show import table

CURVES = ("inlet", "bypass", "outlet_positive", "outlet_negative")


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


def listed(way, machine, seed):
    """All of one log."""
    return list(way(machine, seed))


def judge(title, **ways):
    """Read the command line, and print how often intervals of each way hold the truth; a way gives kind, error and standard error."""
    parser = argparse.ArgumentParser(description=title)
    parser.add_argument("machines", nargs="*", default=["cat215b"])
    parser.add_argument("--logs", type=int, default=20)
    parser.add_argument("--first", type=int, default=1001)
    given = parser.parse_args()
    heads = ["way", "number", "intervals", "hold the truth", "rms error, in standard errors"]
    for machine in given.machines:
        rows = held(load_machine(machine), range(given.first, given.first + given.logs), ways)
        table(f"{machine}: 90 % intervals over {given.logs} logs", heads, rows)


def held(machine, seeds, ways):
    """Rows of the table of a machine: of each kind of number, how many intervals there are, and how many hold the truth."""
    rows = []
    for name, way in ways.items():
        all_of = {}
        found = Parallel(n_jobs=cpu_count(), return_as="generator")(delayed(listed)(way, machine, s) for s in seeds)
        for seed, own in zip(seeds, found, strict=True):
            for kind, off, sd in own:
                all_of.setdefault(kind, []).append(abs(off) / max(sd, 1e-300))
            inside = sum(abs(off) <= COVERED * sd for _, off, sd in own)
            print(f"  {name}, log {seed}: {inside} of {len(own)}", flush=True)
        all_of["all"] = [z for of_kind in all_of.values() for z in of_kind]
        for kind, z in all_of.items():
            share = np.mean(np.array(z) <= COVERED)
            rows.append([name, kind, str(len(z)), f"{100 * share:.0f} %", f"{np.sqrt(np.mean(np.square(z))):.2f}"])
    return rows


if __name__ == "__main__":
    judge(__doc__.splitlines()[0], flows=by_flows)
