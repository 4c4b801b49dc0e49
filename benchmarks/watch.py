"""Faults watched for in logs of simulated machines: how many are found, how soon, how they are named, and how often there is nothing to find.

``python benchmarks/watch.py [MACHINE ...] [--seeds N] [--hours H] [--every N] [--keep FOLDER]``: it prints Markdown tables and asserts nothing.
The machine that is watched is identified from 15 min of its own healthy log, with noise as `record --example` has it, beginning from a file that
is off as in `benchmarks/identify.py`; what is to be expected is learnt from the same log. ``MACHINE+`` has hysteresis of 2 % of each spool's travel,
flow forces and friction that holds, which the watched machine has not; ``MACHINE~`` is watched by pressures, positions and levers alone. Every fault of the catalogue, in its smallest size, begins at 30 s
and stays for two minutes. A fault has an occasion to show in a second in which it would move what is read by a standard deviation at least.

Settings were chosen on operators 11, 99 and 200 of cat215b as it is, and 31 to 34 of wheel_loader, unidentified. The judges' seeds, from 7000 on, chose
nothing but one thing: false alarms of healthy logs from 7500 on, all of them of sensors that were taken to stay at one value, led to the rule for
these that there is now.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from identify import rough
from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification import identify
from polydraulic.identification.watching.watch_log import learnt_from, log_blocks, watched_columns
from polydraulic.measure import example_sensors, load_sensors
from polydraulic.measure.bench.sensors import Reading
from polydraulic.parameters.fault_catalogue import fault_catalogue, timed_faults
from polydraulic.parameters.layout.parts import Effects, FlowForce
from polydraulic.parameters.layout.payload import with_payload
from polydraulic.tables import Table
from polydraulic.watch.blocks import starts_of
from polydraulic.watch.expected import whitened
from polydraulic.watch.flat import RESTS, flat_blocks
from polydraulic.watch.watch import FaultWatch, block_scores, watched
from show import table

FEW = ("*.p_?", "*.angle", "*.voltage")
LIMIT = 1.1  # V: full travel of all spools
LEARNT, BEGIN, LASTS = 900.0, 30.0, 120.0  # s
FIRST_SEED, IDENTIFIED_SEED, WITHIN = 7000, 3011, 60
UNITS = {
    "spool": "m",
    "p_a": "Pa",
    "p_b": "Pa",
    "q_in": "m3/s",
    "q_out": "m3/s",
    "voltage": "V",
    "angle": "rad",
    "position": "m",
}


def plain(name):
    """The machine's own name."""
    return name.rstrip("+~")


def truth(name):
    """A shipped machine, with effects that its watcher knows nothing of where the name ends in a plus."""
    machine = load_machine(plain(name))
    if not name.endswith("+"):
        return machine
    force = FlowForce(50e3, 860.0, np.radians(69.0))
    return machine._replace(
        functions=tuple(
            f._replace(effects=Effects(True, None, 0.02 * f.valve.knots[-1], force)) for f in machine.functions
        )
    )


def log_of(machine, seed, seconds, faults=()):
    """What sensors read of a random operator's work: rows in which all of them are known."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sensors.toml"
        path.write_text(example_sensors(machine=machine))
        bench = load_sensors(path)
    timed = timed_faults(machine, list(faults))
    dt = 2.5e-3 if machine.functions[0].effects.declared else 5e-3  # flow forces of worn edges want shorter steps
    work = random_operator(seed, seconds, limit=LIMIT, functions=machine.names)
    run = simulate(machine, "exact", work, dt=dt, faults=timed)
    columns = {}
    for number, sensor in enumerate(bench.sensors):
        reading = Reading(sensor, np.random.default_rng([seed, number]))
        at, value = reading.of(run, timed)
        columns[sensor.column] = reading.conversion.to_si(value)
    known = np.flatnonzero(np.all([np.isfinite(v) for v in columns.values()], axis=0))
    segment = np.concatenate([[0], np.cumsum(np.diff(known) > 1)]).astype(float)
    rows = {"time": at[known], "segment": segment, **{name: v[known] for name, v in columns.items()}}
    return Table(rows, {"time": "s", "segment": "", **{name: UNITS[name.split(".")[-1]] for name in columns}})


def judged(watch, of, expected, log, fault):
    """Alarms of a log; of a fault, the seconds in which it could show until each block, and when blocks begin."""
    starts = starts_of(log["time"], log["segment"], of.shape)
    readings, begins = log_blocks(of, log, starts), log["time"][starts + of.shape.before]
    watch.judge(readings, begins)
    names = [d.name for d in of.directions]
    if fault is None:
        return begins, None
    if fault in names:
        white = whitened(block_scores(of, readings, expected.noise, expected.scales), expected.offset, expected.jitter)
        place = names.index(fault)
        shows = white.information[:, place] / expected.together[place] >= 1.0
    else:  # of a sensor that stays: wherever its function works
        column = fault.rpartition(".")[0]
        states = flat_blocks(of.machine, readings, of.shape, expected.noise)[column]
        shows = states != RESTS
    return begins, np.cumsum(shows & (begins >= BEGIN))


def study(name, options):
    """Rows of one machine: of faults, healthy work and unusual work; and what was named otherwise, by fault and name."""
    true = truth(name)
    began = time.perf_counter()
    log = log_of(true, IDENTIFIED_SEED, 300.0 if options.quick else LEARNT)
    kept = options.keep / f"{name.rstrip('~')}.toml" if options.keep else None
    if kept is not None and kept.is_file():
        machine = load_machine(kept)
    else:
        found = identify(log, rough(load_machine(plain(name)), np.random.default_rng(IDENTIFIED_SEED)))
        machine = found.machine
        if kept is not None:
            found.write(kept)
    columns = watched_columns(machine, log, "log", FEW if name.endswith("~") else None)
    of = watched(machine, columns, 0.02)
    expected = learnt_from(of, log, np.ones(len(log), dtype=bool), 0.1)
    print(f"{name}: identified and learnt, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)

    names = {d.name for d in of.directions} | {f"{c}.freeze" for c in columns}
    kinds = [k for k in fault_catalogue(true) if k.name in names]
    found, confused = Counter(), Counter()
    delays, clock = [], []
    for kind in kinds[:: options.every]:
        for seed in range(FIRST_SEED, FIRST_SEED + options.seeds):
            size = f" {kind.shown(min(map(abs, kind.sizes)))}" if kind.sizes else ""
            faulty = log_of(true, seed, BEGIN + LASTS, [f"{kind.name}{size} from {BEGIN:g} s"])
            watch = FaultWatch(of, expected)
            begins, shown = judged(watch, of, expected, faulty, kind.name)
            early = [a for a in watch.alarms if a.seen <= BEGIN]
            found["early"] += len(early)
            alarms = [a for a in watch.alarms if a.seen > BEGIN]
            if alarms:
                at = int(np.searchsorted(begins, alarms[0].seen)) - 1
                seconds, suspects = int(shown[min(at, len(shown) - 1)]), [s.name for s in alarms[0].suspects]
                named = suspects[0] if suspects else "unknown"
                delays.append(seconds)
                clock.append(alarms[0].seen - BEGIN)
                found["in time" if seconds <= WITHIN else "late"] += 1
                found["named"] += named == kind.name
                found["kind"] += named.rpartition(".")[2] == kind.name.rpartition(".")[2]
                if named != kind.name:
                    confused[kind.name, named] += 1
            elif shown[-1] < WITHIN:
                found["no occasion"] += 1
            else:
                found["missed"] += 1
                confused[kind.name, "nothing"] += 1
            print(
                f"  {name} {kind.name} {seed}: {alarms[0].suspects[0].name if alarms else '-'} {alarms[0].seen if alarms else ''} {shown[-1]}",
                file=sys.stderr,
                flush=True,
            )
    could = found["in time"] + found["late"] + found["missed"]
    alarmed = max(found["in time"] + found["late"], 1)
    faults = [
        name, str(could), str(found["no occasion"]), f"{found['in time'] / max(could, 1):.1%}", f"{np.median(delays):.0f}",
        f"{np.percentile(delays, 95):.0f}", f"{np.median(clock):.1f}", f"{found['named'] / alarmed:.1%}", f"{found['kind'] / alarmed:.1%}",
    ]  # fmt: skip
    print(faults, file=sys.stderr, flush=True)
    false, hours = found["early"], len(kinds[:: options.every]) * options.seeds * BEGIN / 3600.0
    for number in range(round(options.hours * 6.0)):
        watch = FaultWatch(of, expected)
        begins, _ = judged(watch, of, expected, log_of(true, FIRST_SEED + 500 + number, 600.0), None)
        false, hours = false + len(watch.alarms), hours + len(begins) / 3600.0
        for alarm in watch.alarms:
            print(f"  false alarm of {name}: {alarm}", file=sys.stderr, flush=True)
    healthy = [name, f"{hours:.1f}", str(false), f"{false / hours:.2f}"]
    print(healthy, file=sys.stderr, flush=True)
    unusual = [[name, *row] for row in unusual_work(true, of, expected)]
    return faults, healthy, unusual, confused


def unusual_work(true, of, expected):
    """Cold oil and payloads: what they are named, over a minute and a half each."""
    thick = {f"functions.{f.name}.friction.viscous": 2.0 * f.friction.viscous for f in true.functions}
    mass = next(k for k in fault_catalogue(true) if k.name == "tip.payload_unknown").sizes[0]
    for what, machine in (
        ("oil cold, viscous friction doubled", true.with_values(thick)),
        (f"payload of {mass:.0f} kg", with_payload(true, mass)),
        (f"payload of {4.0 * mass:.0f} kg", with_payload(true, 4.0 * mass)),
    ):
        watch = FaultWatch(of, expected)
        judged(watch, of, expected, log_of(machine, FIRST_SEED + 900, 90.0), None)
        yield what, "; ".join(dict.fromkeys(a.suspects[0].name for a in watch.alarms if a.suspects)) or "no alarm"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "machines", nargs="*", default=["cat215b", "cat215b+", "wheel_loader", "excavator_22t", "cat215b~"]
    )
    parser.add_argument("--seeds", type=int, default=1, help="operators for each fault")
    parser.add_argument("--hours", type=float, default=2.0, help="healthy hours of each machine")
    parser.add_argument("--every", type=int, default=1, help="of the catalogue's faults every so many only")
    parser.add_argument("--jobs", type=int, default=2, help="machines at once")
    parser.add_argument("--keep", type=Path, help="folder of machines that were identified, for the next time")
    parser.add_argument("--quick", action="store_true", help="5 minutes of log to learn from")
    options = parser.parse_args()
    with ProcessPoolExecutor(options.jobs) as pool:
        found = list(pool.map(study, options.machines, [options] * len(options.machines)))
    heads = [
        "machine",
        "faults",
        "no occasion to show",
        f"found in {WITHIN} s",
        "median",
        "95 %",
        "median by the clock, s",
        "named",
        "kind named",
    ]
    table(
        "Faults in their smallest sizes; seconds in which they can show until they are found",
        heads,
        [f[0] for f in found],
    )
    table("Healthy work", ["machine", "hours", "false alarms", "per hour"], [f[1] for f in found])
    table("Unusual work", ["machine", "work", "named"], [row for f in found for row in f[2]])
    other = [[m, *key, str(n)] for m, f in zip(options.machines, found, strict=True) for key, n in sorted(f[3].items())]
    table("Named otherwise", ["machine", "fault", "named", "times"], other)


if __name__ == "__main__":
    main()
