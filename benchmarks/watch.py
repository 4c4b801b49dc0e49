"""Faults watched for in logs of simulated machines: how many are found, how soon, how they are named, and how often there is nothing to find.

``python benchmarks/watch.py [MACHINE[:H] ...] [--seeds N] [--every N] [--hours H] [--minutes M] [--keep FOLDER]``: it prints Markdown tables and
asserts nothing. The machine that is watched is identified from 15 min of its own healthy log, with noise as `record --example` has it, beginning
from a file that is off (`rough_machine`); what is to be expected is learnt from the same log. ``MACHINE+`` has hysteresis of 2 % of each spool's
travel, flow forces and friction that holds, which the watched machine has not; ``MACHINE~`` is watched by pressures, positions and levers alone;
``MACHINE^`` has sensors of its pumps' pressures as well.
Every fault of the catalogue, in its smallest size, begins at 30 s and stays for two minutes; drifts of sensors stay for seven and a half. A fault has
an occasion to show in a second in which it would move what is read by a standard deviation at least; one that has fewer than a minute of them is
hidden if it had a minute without the errors of the watched machine. Where these stray by so much that an alarm would take more than such a minute, no
second is an occasion. Healthy logs of 10 min are watched of all machines in turn, until there are as
many hours of each (H of those with a number of their own), or so many minutes of the clock have passed. What has been watched is kept in the folder
as well, log by log: a run that was interrupted goes on where it ended, so a folder is for one state of the program. An hour takes some five seconds of
a processor.

Settings were chosen on operators 11, 99 and 200 of cat215b as it is, 31 to 34 of wheel_loader, unidentified, of drifts 60000 to 60113 of
wheel_loader, and of what strays 500000 to 500023, with 21001 to 21003 to learn from. Operators from 7000 to 7900, from 8000 to 8900 and from 100000 on
judged before: false alarms of theirs led to the rules for sensors that stay at one value, and for offsets that stray. Those from 14000 and 300000 on
chose nothing.
"""

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

from polydraulic import load_machine
from polydraulic.identification import identify
from polydraulic.parameters.layout.parts import Effects, FlowForce
from polydraulic.thesis.diagnosis_study import (
    SURE,
    WITHIN,
    Healthy,
    WatchedFault,
    case_of_log,
    drifts_watched,
    fault_kind,
    faults_watched,
    most_per_hour,
    watch_fault,
    watch_healthy,
    watch_unusual,
    work_log,
)
from polydraulic.thesis.rough_machine import rough_machine
from show import table

FEW = ("*.p_?", "*.angle", "*.voltage")
LEARNT = 900.0  # s
FIRST_SEED, IDENTIFIED_SEED = 14000, 14911
HEALTHY_SEED, HEALTHY_LASTS = 300_000, 600.0  # s


class Kept:
    """What was watched, one line of a file each, so that it is watched once; without a folder nothing is kept."""

    def __init__(self, folder):
        self.path = folder / "watched.jsonl" if folder else None
        lines = self.path.read_text(encoding="utf-8").splitlines() if self.path and self.path.is_file() else []
        self.known = dict(json.loads(line) for line in lines)

    def __call__(self, key, make):
        """The value under a key: as it was kept, or made and kept."""
        if key not in self.known:
            self.known[key] = make()
            if self.path:
                with self.path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps([key, self.known[key]]) + "\n")
        return self.known[key]


def plain(name):
    """The machine's own name."""
    return name.rstrip("+~^")


def truth(name):
    """A shipped machine, with effects that its watcher knows nothing of where the name has a plus."""
    machine = load_machine(plain(name))
    if "+" not in name:
        return machine
    force = FlowForce(50e3, 860.0, np.radians(69.0))
    return machine._replace(
        functions=tuple(
            f._replace(effects=Effects(True, None, 0.02 * f.valve.knots[-1], force)) for f in machine.functions
        )
    )


def learnt(name, keep):
    """A machine's case: identified, or as it was kept; and what is to be expected of it."""
    true, began = truth(name), time.process_time()
    log = work_log(true, IDENTIFIED_SEED, LEARNT)
    kept = keep / f"{name.rstrip('~^')}_{IDENTIFIED_SEED}.toml" if keep else None
    if kept is not None and kept.is_file():
        machine = load_machine(kept)
    else:
        found = identify(log, rough_machine(load_machine(plain(name)), np.random.default_rng(IDENTIFIED_SEED)))
        machine = found.machine
        if kept is not None:
            found.write(kept)
    if name.endswith("^"):
        log = work_log(true, IDENTIFIED_SEED, LEARNT, pumps=[c.name for c in true.circuits])
    case = case_of_log(true, machine, log, FEW if name.endswith("~") else None)
    say(f"{name}: identified and learnt, {time.process_time() - began:.0f} s")
    return case


def say(words):
    """To whom waits."""
    print(words, file=sys.stderr, flush=True)


def faults_of(name, case, kinds, seeds, kept):
    """What became of these faults."""
    found = []
    for kind in kinds:
        for seed in range(FIRST_SEED, FIRST_SEED + seeds):
            key = f"{name} {kind.name} {seed}"
            found.append(WatchedFault(*kept(key, lambda kind=kind, seed=seed: list(watch_fault(case, kind, seed)))))
            say(f"  {name} {seed}: {found[-1]}")
    return found


def fault_row(name, found):
    """How many were found, how soon, and how they were named."""
    alarmed, outcomes = [f for f in found if f.named], Counter(f.outcome for f in found)
    could, named, delays = sum(f.could for f in found), max(len(alarmed), 1), [f.delay for f in alarmed] or [np.nan]
    return [
        name, str(could), str(outcomes["no occasion"]), str(outcomes["hidden"]), f"{outcomes['in time'] / max(could, 1):.1%}",
        f"{np.median(delays):.0f}", f"{np.percentile(delays, 95):.0f}", f"{np.median([f.clock for f in alarmed] or [np.nan]):.1f}",
        f"{sum(f.named == f.fault for f in alarmed) / named:.1%}", f"{sum(fault_kind(f.named) == fault_kind(f.fault) for f in alarmed) / named:.1%}",
    ]  # fmt: skip


def drift_row(name, found):
    """How many drifts were found, and named as such."""
    alarmed = [f for f in found if f.named]
    biases = sum(f.named == f.fault.replace(".drift", ".bias") for f in alarmed)
    clock = np.median([f.clock for f in alarmed] or [np.nan])
    named = sum(f.named == f.fault for f in alarmed)
    return [name, str(len(found)), str(len(alarmed)), f"{clock:.0f}", str(named), str(biases)]


def watch_hours(cases, hours, until, kept):
    """Seconds and false alarms of so many hours of each machine's healthy work; of each alarm machine, operator and what it was named."""
    seconds, false, named = Counter(), Counter(), []
    logs = {name: round(hours[name] * 3600.0 / HEALTHY_LASTS) for name in cases}
    for number in range(max(logs.values(), default=0)):
        for name, case in ((name, case) for name, case in cases.items() if number < logs[name]):
            if time.monotonic() > until:
                return seconds, false, named
            seed = HEALTHY_SEED + number
            log = kept(
                f"{name} healthy {seed}",
                lambda case=case, seed=seed: list(watch_healthy(case, case.true, seed, HEALTHY_LASTS)),
            )
            healthy = Healthy(*log)
            seconds[name] += healthy.seconds
            false[name] += len(healthy.named)
            named += [[name, str(seed), alarm] for alarm in healthy.named]
        say(f"  healthy logs: {number + 1} of each, {sum(false.values())} false alarms")
    return seconds, false, named


def healthy_row(name, alarms, seconds):
    """What there was in how many hours, and how many there may be."""
    hours = seconds / 3600.0
    return [name, f"{hours:.1f}", str(alarms), f"{alarms / hours:.2f}", f"{most_per_hour(alarms, seconds):.2f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "machines", nargs="*", default=["cat215b", "cat215b+", "wheel_loader", "wheel_loader+", "loader_crane"]
    )
    parser.add_argument("--seeds", type=int, default=1, help="operators for each fault")
    parser.add_argument("--every", type=int, default=1, help="of the catalogue's faults every so many only")
    parser.add_argument("--hours", type=float, default=2.0, help="healthy hours of each machine")
    parser.add_argument("--minutes", type=float, default=np.inf, help="after which no other healthy log is begun")
    parser.add_argument("--keep", type=Path, help="folder of what was identified and watched, for the next time")
    options = parser.parse_args()
    if options.keep:
        options.keep.mkdir(parents=True, exist_ok=True)
    kept = Kept(options.keep)
    until = time.monotonic() + 60.0 * options.minutes
    cases, faults, drifts, confused, seconds, false = {}, [], [], Counter(), Counter(), Counter()
    unusual, hours = [], {}
    for name, _, own in (text.partition(":") for text in options.machines):
        hours[name] = float(own or options.hours)
        case = cases[name] = learnt(name, options.keep)
        found = faults_of(name, case, faults_watched(case)[:: options.every], options.seeds, kept)
        grown = faults_of(name, case, drifts_watched(case)[:: options.every], options.seeds, kept)
        faults.append(fault_row(name, found))
        drifts.append(drift_row(name, grown))
        confused.update((name, f.fault, f.named or "nothing") for f in found if f.could and f.named != f.fault)
        false[name] = sum(f.alarms_before for f in (*found, *grown))
        seconds[name] = sum(f.judged_before for f in (*found, *grown))
        unusual += [
            [name, *row] for row in kept(f"{name} unusual", lambda case=case: watch_unusual(case, FIRST_SEED + 900))
        ]
    *more, alarms = watch_hours(cases, hours, until, kept)
    seconds.update(more[0])
    false.update(more[1])
    heads = [
        "machine", "faults", "no occasion to show", "hidden", f"found in {WITHIN} s", "median", "95 %", "median by the clock, s", "named", "kind named",
    ]  # fmt: skip
    table("Faults in their smallest sizes; seconds in which they can show until they are found", heads, faults)
    drift_heads = ["machine", "drifts", "found", "median by the clock, s", "named drift", "named bias"]
    table("Sensors that drift, to the smallest bias that counts in ten minutes", drift_heads, drifts)
    rows = [healthy_row(name, false[name], seconds[name]) for name in cases]
    rows.append(healthy_row("all", sum(false.values()), sum(seconds.values())))
    bound = f"at most per hour, {SURE:.0%} sure"
    table("Healthy work", ["machine", "hours", "false alarms", "per hour", bound], rows)
    table("False alarms in healthy work", ["machine", "operator", "named"], alarms)
    table("Unusual work", ["machine", "work", "named"], unusual)
    other = [[*key, str(n)] for key, n in sorted(confused.items())]
    table("Named otherwise", ["machine", "fault", "named", "times"], other)


if __name__ == "__main__":
    main()
