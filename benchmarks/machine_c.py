"""The exported machine in C, and as an FMU, next to the compiled loop of `simulate`: time of a step, and size.

``python benchmarks/machine_c.py`` needs gcc. All make the same steps from the same voltages and keep every row, whose bits are
asserted to be equal, unless gcc fuses operations unasked; C adds the position of the stick's tip. Times are processor times.
"""

import ctypes
import re
import subprocess
import tempfile
import zipfile
from pathlib import Path
from shutil import which

import numpy as np

from polydraulic import load_machine, load_scenario
from polydraulic.export.fmu.machine import export_machine_fmu
from polydraulic.export.machine import export_machine, machine_parts
from polydraulic.parameters.layout.adapt import adapted
from polydraulic.simulation.layout.runs import prepared_run
from polydraulic.thesis.timing import paired_times
from show import left_out, show

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
# The calls of an importer of FMI 2: set three inputs, make a step, get all outputs.
IMPORTER = """#include <stddef.h>
#include <stdint.h>

void *fmi2Instantiate(const char *, int, const char *, const char *, const void *, int, int);
int fmi2EnterInitializationMode(void *);
int fmi2ExitInitializationMode(void *);
int fmi2SetReal(void *, const unsigned *, size_t, const double *);
int fmi2GetReal(void *, const unsigned *, size_t, double *);
int fmi2DoStep(void *, double, double, int);
void fmi2FreeInstance(void *);

void loop(const double *voltage, int64_t n, double *rows)
{
    static const void *const calls[5];
    unsigned refs[64];
    for (unsigned i = 0; i < 64; i++) {
        refs[i] = i;
    }
    void *c = fmi2Instantiate("m", 1, "TOKEN", NULL, calls, 0, 0);
    fmi2EnterInitializationMode(c);
    fmi2ExitInitializationMode(c);
    fmi2GetReal(c, refs + 3, N_OUT, rows);
    for (int64_t k = 0; k < n; k++) {
        fmi2SetReal(c, refs, 3, voltage + 3 * k);
        fmi2DoStep(c, (double)k * 0.005, 0.005, 1);
        fmi2GetReal(c, refs + 3, N_OUT, rows + (k + 1) * N_OUT);
    }
    fmi2FreeInstance(c);
}
"""
# Where there is FMA, gcc 12 fuses neighbouring products and sums (vfmaddsub) in spite of -ffp-contract=off, unless told not to.
FUSED = "gcc -O3 -march=native"
COMPILERS = {
    "gcc -O2": ["-O2"],
    FUSED: ["-O3", "-march=native"],
    f"{FUSED} -fno-tree-slp-vectorize": ["-O3", "-march=native", "-fno-tree-slp-vectorize"],
    "gcc -Os": ["-Os"],
}


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


def imported(machine, flow, locked, folder, n_out):
    """The loop of an importer around the binary of an FMU, and the bytes of that binary and of the whole FMU."""
    path = export_machine_fmu(machine, flow, folder / "m.fmu", version=2, name="m", locked=locked).main
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    token = re.search(r'guid="(.*?)"', (folder / "modelDescription.xml").read_text())[1]
    (folder / "loop.c").write_text(IMPORTER.replace("TOKEN", token))
    (binary,) = (folder / "binaries").rglob("m.*")
    library = folder / "loop.so"
    flags = ["-O2", "-fPIC", "-shared", f"-DN_OUT={n_out}", f"-Wl,-rpath,{binary.parent}"]
    subprocess.run(["gcc", *flags, "loop.c", binary, "-o", library], check=True, cwd=folder)
    return ctypes.CDLL(str(library)).loop, binary.stat().st_size, path.stat().st_size


def compare(machine, flow, name):
    scenario = load_scenario(name)
    loop = prepared_run(machine, flow, scenario)
    _, _, _, _, voltage, _, states, _ = loop.args
    machine, n = adapted(machine, scenario), len(voltage)
    n_out = len(machine_parts(machine, flow, locked=scenario.locked).outputs)
    calls, notes, rows = {"simulate's loop": loop}, {}, {}

    def add(label, loop):
        rows[label] = out = np.empty((n + 1, n_out))
        v, made = ctypes.c_void_p(voltage.ctypes.data), ctypes.c_void_p(out.ctypes.data)
        calls[label] = lambda: loop(v, ctypes.c_int64(n), made)

    with tempfile.TemporaryDirectory() as folder:
        for label, flags in COMPILERS.items():
            place = Path(folder) / label.replace(" ", "")
            place.mkdir()
            loop, code, data, source = compiled(machine, flow, scenario.locked, place, flags)
            notes[label] = f"{code} bytes of code, {data} of data; {source} of source"
            add(label, loop)
        place = Path(folder) / "fmu"
        place.mkdir()
        loop, binary, whole = imported(machine, flow, scenario.locked, place, n_out)
        notes["FMU, a step a call"] = f"binary of {binary} bytes, FMU of {whole}"
        add("FMU, a step a call", loop)
        times = paired_times(calls)
    for label, found in rows.items():
        equal = np.array_equal(found[:, : states.shape[1]], states)
        assert equal or label == FUSED, f"{name}, flow {flow}: bits of {label} differ"
        notes[label] = f"bits {'equal' if equal else 'differ'}; {notes[label]}"
    show(f"{name}, flow {flow}: a step", times, "ns", per=n, notes=notes)


def main():
    if which("gcc") is None:
        left_out("the machine in C and as an FMU", "install gcc")
        return
    machine = load_machine("cat215b")
    for flow in ("exact", "polynomial"):
        for name in ("sine", "step", "pulse", "task"):
            compare(machine, flow, name)


if __name__ == "__main__":
    main()
