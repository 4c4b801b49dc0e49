"""The exported machine in C next to the compiled loop of `simulate`: time of a step, and size.

``python benchmarks/machine_c.py`` prints and asserts nothing; it needs gcc. Both make the same steps from the same voltages and
keep every row; C adds the position of the stick's tip. Times are processor times, medians of turns within this run.
"""

import ctypes
import subprocess
import tempfile
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from polydraulic import load_machine, load_scenario
from polydraulic.export.machine import export_machine, outputs
from polydraulic.simulation.loop import N_RECORD, run
from polydraulic.simulation.runs import arrange

LOOP = """#include "m.h"
#include <string.h>

void loop(const double *voltage, int64_t n, double *rows)
{
    m_machine m;
    m_init(&m);
    memcpy(rows, m.out, sizeof m.out);
    for (int64_t k = 0; k < n; k++) {
        m_step(&m, voltage + 3 * k);
        memcpy(rows + (k + 1) * M_N_OUTPUTS, m.out, sizeof m.out);
    }
}
"""
COMPILERS = {"gcc -O2": ["-O2"], "gcc -O3 -march=native": ["-O3", "-march=native"], "gcc -Os": ["-Os"]}


def in_turn(calls, repeats=21):
    """Median seconds of each call; the calls take turns, after one that compiles."""
    seconds = {name: [] for name in calls}
    for repeat in range(repeats + 1):
        for name, call in calls.items():
            start = process_time()
            call()
            if repeat:
                seconds[name].append(process_time() - start)
    return {name: median(values) for name, values in seconds.items()}


def compiled(machine, flow, locked, folder, flags):
    """The loop in C, and the bytes of code and of constant data that the machine takes."""
    (folder / "loop.c").write_text(LOOP)
    paths = export_machine(machine, flow, folder, name="m", locked=locked)
    sources = [str(path) for path in paths if path.suffix == ".c"]
    command = ["gcc", "-std=c99", "-ffp-contract=off", "-fPIC", *flags]
    library, joined = folder / "m.so", folder / "all.o"
    subprocess.run([*command, "-shared", "loop.c", *sources, "-lm", "-o", library], check=True, cwd=folder)
    subprocess.run([*command, "-r", *sources, "-o", joined], check=True, cwd=folder)
    listed = subprocess.run(["size", "-A", joined], check=True, capture_output=True, text=True).stdout
    sizes = {row[0]: int(row[1]) for row in map(str.split, listed.splitlines()) if len(row) == 3 and row[1].isdigit()}
    code = sum(size for name, size in sizes.items() if name.startswith(".text"))
    data = sum(size for name, size in sizes.items() if name.startswith((".rodata", ".data")))
    return ctypes.CDLL(str(library)).loop, code, data, sum(path.stat().st_size for path in paths)


def compare(machine, flow, name):
    scenario = load_scenario(name)
    arranged = arrange(machine, flow, scenario)
    n = len(arranged.voltage)
    rows = np.empty((n + 1, len(outputs())))
    calls, sizes = {"simulate's loop": lambda: run(*arranged)}, {}
    with tempfile.TemporaryDirectory() as folder:
        for label, flags in COMPILERS.items():
            place = Path(folder) / label.replace(" ", "")
            place.mkdir()
            loop, *sizes[label] = compiled(scenario.adapt(machine), flow, scenario.locked, place, flags)
            arguments = (
                ctypes.c_void_p(arranged.voltage.ctypes.data),
                ctypes.c_int64(n),
                ctypes.c_void_p(rows.ctypes.data),
            )
            calls[label] = lambda loop=loop, arguments=arguments: loop(*arguments)
        seconds = in_turn(calls)
    same = np.array_equal(rows[:, :N_RECORD], arranged.rows)
    print(f"\n{name}, flow {flow}: {n} steps, bits {'equal' if same else 'DIFFER'}")
    for label, value in seconds.items():
        text = f"  {label:24s} {value / n * 1e9:8.1f} ns a step   ratio {value / seconds[next(iter(seconds))]:5.2f}"
        if label in sizes:
            code, data, source = sizes[label]
            text += f"   {code} bytes of code, {data} of data; {source} of source"
        print(text)


def main():
    machine = load_machine("cat215b")
    for flow in ("exact", "polynomial"):
        for name in ("sine", "step", "pulse", "task"):
            compare(machine, flow, name)


if __name__ == "__main__":
    main()
