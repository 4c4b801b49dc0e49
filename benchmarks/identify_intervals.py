"""How often 90 % intervals of identified numbers hold the truth, over short logs that lack all sensors but commands and angles.

``python benchmarks/identify_intervals.py [MACHINE] [--logs N]``. Nothing was chosen by these seeds.
"""

import argparse

import numpy as np

from identify_sensors import JOINTS, begun, log_of
from polydraulic import load_machine
from polydraulic.identification.equations.shooting.fit import fit_by_shooting
from polydraulic.identification.equations.shooting.windows import sensors_of

FREE = ("pilot.gain", "pilot.time_constant", "pump.flow")


def coverage(name, logs):
    machine = load_machine(name)
    paths = [n.path for n in machine.numbers if n.path.endswith(FREE)]
    paths.append(f"links.{machine.tip[0]}.mass")
    inside = []
    for seed in range(1001, 1001 + logs):
        rng = np.random.default_rng(seed)
        prior, spreads, truth = begun(machine, paths, rng)
        log = log_of(machine, seed, 35.0)
        columns = [column for column in sensors_of(machine, log) if column.split(".")[-1] in JOINTS]
        numbers = fit_by_shooting(log, prior, spreads, sensors=columns, seconds=1.0, most=32).estimates.numbers
        inside.append([e.low <= truth[e.path] <= e.high for e in numbers if e.determined])
        print(f"  log {seed}: {sum(inside[-1])} of {len(inside[-1])}", flush=True)
    every = np.concatenate(inside)
    print(
        f"{name}: 90 % intervals of {len(every)} numbers from {logs} logs of 35 s, commands and angles alone: {100 * every.mean():.0f} % hold the truth",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("machine", nargs="?", default="loader_crane")
    parser.add_argument("--logs", type=int, default=20)
    given = parser.parse_args()
    coverage(given.machine, given.logs)


if __name__ == "__main__":
    main()
