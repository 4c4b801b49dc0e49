"""What a row costs a machine that is watched: `FaultWatch.update`, each call by itself, rows that complete a block apart.

``python benchmarks/watch_update.py [MACHINE ...] [--minutes N]``. Processor time of the thread, so that other programs do not count; the garbage
collector is off. A leak begins in the middle: blocks are diagnosed from the alarm on.
"""

import argparse
import gc
import time

import numpy as np

from polydraulic import load_machine
from polydraulic.thesis.diagnosis_study import case_of_log, work_log
from polydraulic.watch import FaultWatch
from show import table

SEED, LEARNT = 4100, 300.0  # s


def times_of(watch, log):
    """Microseconds of each row, and which of them completed a block."""
    took, full = [], []
    for at, row in zip(log["time"].tolist(), log.matrix(list(watch.of.columns)), strict=True):
        before, began = watch.blocks, time.thread_time_ns()
        watch.update(at, row)
        took.append(1e-3 * (time.thread_time_ns() - began))
        full.append(watch.blocks > before)
    return np.array(took), np.array(full)


def study(name, minutes):
    """Row of one machine."""
    machine = load_machine(name)
    case = case_of_log(machine, machine, work_log(machine, SEED, LEARNT))
    first = machine.functions[0].name
    log = work_log(machine, SEED + 1, 60.0 * minutes, [f"{first}.leak_across 10 % from {30.0 * minutes:g} s"])
    times_of(FaultWatch(case.of, case.expected), log)
    watch = FaultWatch(case.of, case.expected)
    gc.collect()
    gc.disable()
    took, full = times_of(watch, log)
    gc.enable()
    rows, blocks = took[~full], took[full]
    return [
        name, str(len(case.of.columns)), str(len(case.of.directions)), f"{np.median(rows):.1f}", f"{np.percentile(rows, 99.9):.1f}",
        f"{np.median(blocks) / 1e3:.2f}", f"{np.percentile(blocks, 99) / 1e3:.2f}", f"{blocks.max() / 1e3:.2f}", str(len(watch.alarms)),
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "machines", nargs="*", default=["wheel_loader", "cat215b", "excavator_22t", "cat215b_crossover"]
    )
    parser.add_argument("--minutes", type=float, default=5.0)
    options = parser.parse_args()
    heads = ["machine", "sensors", "tests", "row, us", "99.9 %", "block, ms", "99 %", "worst", "alarms"]
    table("A row of a machine that is watched", heads, [study(name, options.minutes) for name in options.machines])


if __name__ == "__main__":
    main()
