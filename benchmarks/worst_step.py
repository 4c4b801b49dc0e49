"""The longest of many single steps, as a multiple of the median: what real time has to wait for, on every shipped machine.

``python benchmarks/worst_step.py [MACHINE ...] [--steps N] [--clock wall|thread]``. Each step is timed by itself: of the exported C in a loop in
C, which needs gcc, and of a `Simulator` as a Python program calls it, with the garbage collector off. Levers jump ten times a second between
random voltages, so that joints meet their stops and pumps their relief valves. Wall time counts whatever else the core does, an operating
system included: run it on a quiet core (``taskset -c 1``). The thread's own time leaves out what others take, and its clock is coarser to read.
"""

import argparse
import ctypes
import gc
import subprocess
import tempfile
import time
from pathlib import Path
from shutil import which

import numpy as np

from polydraulic import Simulator, build_flow, load_machine
from polydraulic.export.machine import export_machine
from polydraulic.parameters.load import machine_names
from show import left_out, table

HELD, ROWS = 20, 20000  # steps of 5 ms between jumps of the levers; voltages that come again and again
LOOP = """#define _POSIX_C_SOURCE 200809L
#include "m.h"
#include <time.h>

double loop(const double *levers, int64_t rows, int64_t width, int64_t n, int own_clock, uint32_t *ns)
{
    static m_machine m;
    double sum = 0.0;
    m_init(&m);
    for (int64_t k = 0; k < n; k++) {
        struct timespec from, to;
        clock_gettime(own_clock ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &from);
        m_step(&m, levers + width * (k % rows));
        clock_gettime(own_clock ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &to);
        const int64_t took = (to.tv_sec - from.tv_sec) * 1000000000LL + (to.tv_nsec - from.tv_nsec);
        ns[k] = took < 4294967295LL ? (uint32_t)took : 4294967295U;
        sum += m.out[k % M_N_OUTPUTS];
    }
    return sum;
}
"""


def levers_of(machine):
    """Voltages (ROWS, n_function) that jump at random."""
    rng = np.random.default_rng(0)
    return np.repeat(rng.uniform(-1.0, 1.0, (ROWS // HELD, len(machine.names))), HELD, axis=0)


def of_c(machine, steps, clock):
    """Nanoseconds of each step of the exported C."""
    levers, ns = levers_of(machine), np.zeros(steps, dtype=np.uint32)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        paths = export_machine(machine, build_flow("exact", machine), folder, name="m")
        (folder / "loop.c").write_text(LOOP)
        sources = [str(path) for path in paths if path.suffix == ".c"]
        command = [
            "gcc",
            "-std=c99",
            "-O2",
            "-ffp-contract=off",
            "-fPIC",
            "-shared",
            "loop.c",
            *sources,
            "-lm",
            "-o",
            "loop.so",
        ]
        subprocess.run(command, check=True, cwd=folder)
        loop = ctypes.CDLL(str(folder / "loop.so")).loop
        loop.restype = ctypes.c_double
        wide = [ctypes.c_int64(value) for value in (*levers.shape, steps)]
        found = loop(
            ctypes.c_void_p(levers.ctypes.data), *wide, int(clock == "thread"), ctypes.c_void_p(ns.ctypes.data)
        )
    assert np.isfinite(found)
    return ns


def of_python(machine, steps, clock):
    """Nanoseconds of each call of a simulator's step."""
    levers, ns = levers_of(machine), np.zeros(steps, dtype=np.uint32)
    now = time.thread_time_ns if clock == "thread" else time.perf_counter_ns
    sim = Simulator(machine)
    sim.step(levers[0])
    gc.disable()
    try:
        for k in range(steps):
            lever = levers[k % ROWS]
            start = now()
            sim.step(lever)
            ns[k] = now() - start
    finally:
        gc.enable()
    assert np.all(np.isfinite(sim.values))
    return ns


def row(name, way, ns):
    """A line of the table; the first thousandth of the steps fills caches."""
    ns = ns[len(ns) // 1000 :].astype(np.float64)
    middle, high, largest = float(np.median(ns)), float(np.quantile(ns, 0.99999)), float(ns.max())
    over = int(np.sum(ns > 20.0 * middle))
    return [name, way, f"{middle:.0f}", f"{high / middle:.1f}", f"{largest / middle:.1f}", f"{over} of {len(ns)}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("machines", nargs="*", help="all that are shipped if there is none")
    parser.add_argument("--steps", type=int, default=10_000_000)
    parser.add_argument("--clock", choices=("wall", "thread"), default="wall")
    asked = parser.parse_args()
    rows = []
    for name in asked.machines or machine_names():
        machine = load_machine(name)
        if which("gcc") is None:
            left_out(f"{name} in C", "install gcc")
        else:
            rows.append(row(name, "C", of_c(machine, asked.steps, asked.clock)))
        rows.append(row(name, "Simulator.step", of_python(machine, asked.steps, asked.clock)))
    header = ["machine", "", "median, ns", "99.999 % / median", "largest / median", "over 20 medians"]
    table(f"single steps of 5 ms, flow exact, {asked.clock} time", header, rows)


if __name__ == "__main__":
    main()
