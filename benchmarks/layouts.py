"""Steps of the machines that come with the package, single and in lanes, next to the three links of cat215b; and their first compilation.

``python benchmarks/layouts.py`` prints and asserts nothing. All machines do the work of the same random operator; rows are recorded, and
the last one summed. Compilation is timed in a process of its own with an empty cache, once.
"""

import os
import subprocess
import sys
import tempfile
import time

import numpy as np

from polydraulic import load_machine
from polydraulic.parameters.load import function_names, machine_names
from polydraulic.parameters.scenario import random_operator
from polydraulic.simulation.batch.batch import simulate_batch
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange
from polydraulic.thesis.timing import paired_times
from show import show

DT, SECONDS, MACHINES = 5e-3, 20.0, 64
STEPS = int(SECONDS / DT)
FIRST = """
import time
from polydraulic import load_machine, simulate, simulate_batch
from polydraulic.parameters.load import function_names
from polydraulic.parameters.scenario import random_operator
machine = load_machine({name!r})
scenario = random_operator(1, 0.1, functions=function_names(machine))
begun = time.process_time()
simulate(machine, "exact", scenario)
print(time.process_time() - begun)
begun = time.process_time()
simulate_batch(machine, "exact", scenario)
print(time.process_time() - begun)
"""


def single(name):
    """A run of one machine: the sum of its last row."""
    machine = load_machine(name)
    scenario = random_operator(1, SECONDS, functions=function_names(machine))
    if name == "cat215b":
        arranged = arrange(machine, "exact", scenario, dt=DT)
        return lambda: (run(*arranged), arranged.rows[-1].sum())[1]
    ready, counts = prepare_layout(machine, DT), np.zeros(2, dtype=np.int64)
    inputs = step_inputs(machine, scenario, np.arange(STEPS) * DT)
    rows = np.empty((STEPS + 1, len(columns_of(machine).columns)))
    arguments = (ready.valves, np.zeros(ready.n_memory), ready.plant, ready.start, inputs, 1, rows, counts)
    return lambda: (ready.module.run(*arguments), rows[-1].sum())[1]


def lanes(name):
    """A batch of machines on one thread: the sum of all that is kept."""
    machine = load_machine(name)
    n, rng = len(function_names(machine)), np.random.default_rng(0)
    voltage = np.repeat(rng.uniform(-0.8, 0.8, (MACHINES, STEPS // 200, n)), 200, axis=1)
    return lambda: simulate_batch(machine, "exact", voltage, dt=DT, threads=1).final.sum()


def first_seconds(name):
    """CPU seconds of the first run and of the first batch with an empty cache."""
    with tempfile.TemporaryDirectory() as folder:
        found = subprocess.run(
            [sys.executable, "-c", FIRST.format(name=name)],
            env={**os.environ, "XDG_CACHE_HOME": folder},
            check=True,
            capture_output=True,
            text=True,
        )
    return [float(line) for line in found.stdout.split()]


def main():
    names = ["cat215b", *(name for name in machine_names() if name != "cat215b")]
    begun = time.perf_counter()
    show(
        f"One step of one machine, {STEPS} steps", paired_times({name: single(name) for name in names}), "ns", per=STEPS
    )
    per = STEPS * MACHINES
    show(
        f"One step of one of {MACHINES} machines in lanes, one thread",
        paired_times({name: lanes(name) for name in names}, clock=time.process_time),
        "ns",
        per=per,
    )
    print("\nFirst run and first batch with an empty cache, CPU seconds")
    for name in names:
        alone, batch = first_seconds(name)
        print(f"  {name:34s} {alone:12.1f} s {batch:12.1f} s", flush=True)
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
