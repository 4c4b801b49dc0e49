"""Steps of the machines that come with the package, single and in lanes, next to those of cat215b; as C; first compilation.

``python benchmarks/layouts.py`` needs gcc for the machines as C, whose bits are asserted to be those of the loop. All machines do the work
of the same random operator; rows are recorded, and the last one summed. Torque limits are those of the machines, or none where the
name says so. Compilation is timed in a process of its own with an empty cache, once.
"""

import ctypes
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from shutil import which

import numpy as np

from machine_c import LOOP
from polydraulic import load_machine
from polydraulic.export import export_machine
from polydraulic.parameters.load import machine_names
from polydraulic.parameters.scenario import random_operator
from polydraulic.simulation.batch.batch import simulate_batch
from polydraulic.simulation.layout.columns import columns_of
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.simulation.layout.runs import step_inputs
from polydraulic.thesis.timing import paired_times
from show import left_out, show

DT, SECONDS, MACHINES = 5e-3, 20.0, 64
STEPS = int(SECONDS / DT)
FREE = " without torque limit"
FIRST = """
import time
from polydraulic import load_machine, simulate, simulate_batch

from polydraulic.parameters.scenario import random_operator
machine = load_machine({name!r})
scenario = random_operator(1, 0.1, functions=machine.names)
begun = time.process_time()
simulate(machine, "exact", scenario)
print(time.process_time() - begun)
begun = time.process_time()
simulate_batch(machine, "exact", scenario)
print(time.process_time() - begun)
"""


def machine_of(name):
    """A machine by its name, as it comes or without torque limit."""
    machine = load_machine(name.removesuffix(FREE))
    if name.endswith(FREE):
        circuits = (c._replace(pump=c.pump._replace(torque_limit_enabled=False)) for c in machine.circuits)
        machine = machine._replace(circuits=tuple(circuits))
    return machine


def arranged_layout(name):
    """The loop of a machine of any layout, and what it reads and fills."""
    machine = machine_of(name)
    ready, counts = prepare_layout(machine, DT), np.zeros(2, dtype=np.int64)
    scenario = random_operator(1, SECONDS, functions=machine.names)
    inputs = step_inputs(machine, scenario, np.arange(STEPS) * DT)
    rows = np.empty((STEPS + 1, len(columns_of(machine).columns)))
    return (
        ready.module.run,
        (ready.valves, np.zeros(ready.n_memory), ready.plant, ready.start, inputs, 1, rows, counts),
        rows,
    )


def single(name):
    """A run of one machine: the sum of its last row."""
    loop, arguments, rows = arranged_layout(name)
    return lambda: (loop(*arguments), rows[-1].sum())[1]


def in_c(name, folder):
    """The same run by the exported C, with the bits of the loop."""
    loop, arguments, rows = arranged_layout(name)
    loop(*arguments)
    inputs, n = arguments[4], arguments[4].shape[1]
    paths = export_machine(machine_of(name), "exact", folder, name="m")
    (folder / "loop.c").write_text(LOOP.replace("3 * k", f"{n} * k"))
    sources = ["loop.c", *(str(path) for path in paths if path.suffix == ".c")]
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run(["gcc", *flags, *sources, "-lm", "-o", "m.so"], check=True, cwd=folder)
    function = ctypes.CDLL(str(folder / "m.so")).loop
    out = np.empty((STEPS + 1, rows.shape[1] + 3))  # and the tip

    def steps():
        function(ctypes.c_void_p(inputs.ctypes.data), ctypes.c_int64(STEPS), ctypes.c_void_p(out.ctypes.data))

    steps()
    assert np.array_equal(out[:, :-3], rows), f"{name}: bits of C differ"
    return steps


def lanes(name):
    """A batch of machines on one thread: the sum of all that is kept."""
    machine = machine_of(name)
    n, rng = len(machine.names), np.random.default_rng(0)
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


def has_limit(name):
    """Whether a pump of a machine of any layout has a torque limit."""
    return any(c.pump.torque_limit_enabled for c in load_machine(name).circuits)


def main():
    layouts = [name for name in machine_names() if name != "cat215b"]
    names = ["cat215b", *layouts, *(name + FREE for name in layouts if has_limit(name))]
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
    if which("gcc") is None:
        left_out("machines as C", "there is no gcc")
    else:
        for name in layouts:
            with tempfile.TemporaryDirectory() as folder:
                calls = {"the compiled loop": single(name), "C, gcc -O2": in_c(name, Path(folder))}
                show(f"{name} as C: a step", paired_times(calls), "ns", per=STEPS)
    print("\nFirst run and first batch with an empty cache, CPU seconds")
    for name in ["cat215b", *layouts]:
        alone, batch = first_seconds(name)
        print(f"  {name:34s} {alone:12.1f} s {batch:12.1f} s", flush=True)
    print(f"\n{time.perf_counter() - begun:.0f} s in all")


if __name__ == "__main__":
    main()
