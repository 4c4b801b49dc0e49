"""The exported machine in a shared library, driven from here."""

import ctypes
import subprocess

import numpy as np

from polydraulic.export.machine import machine_c, machine_parts

STRICT = (
    "-std=c99 -Wall -Wextra -Werror -Wconversion -Wdouble-promotion -Wshadow -Wstrict-prototypes -Wmissing-prototypes "
    "-Wcast-qual -Wvla -pedantic"
).split()


_OBJECTS = {}  # compiled once for each text


def compiled(files, folder, *flags, compiler="gcc"):
    """Write the files and compile the sources into one library or program."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text)
    headers = "".join(text for name, text in files.items() if name.endswith(".h"))
    objects = []
    for name in (name for name in files if name.endswith(".c")):
        key = (files[name], headers, flags, compiler)
        if key not in _OBJECTS:
            _OBJECTS[key] = (folder / name).with_suffix(".o")
            subprocess.run([compiler, *STRICT, *flags, "-c", folder / name, "-o", _OBJECTS[key]], check=True)
        objects.append(_OBJECTS[key])
    target = folder / "m.so"
    subprocess.run([compiler, *flags, *objects, "-lm", "-o", target], check=True)
    return target


class CMachine:
    """One machine; `out` is the row of its outputs, seen through memory."""

    def __init__(self, machine, flow, folder, *, optimise="-O2", **options):
        parts = machine_parts(machine, flow, **options)
        n_memory, n_out = parts.n_memory, len(parts.outputs)
        files = machine_c(machine, flow, name="m", **options)
        n_waiting = next(int(line.split()[2]) for line in files["m.h"].splitlines() if "define M_N_WAITING" in line)

        class Struct(ctypes.Structure):
            _fields_ = (
                ("out", ctypes.c_double * n_out),
                ("memory", ctypes.c_double * n_memory),
                ("waiting", ctypes.c_double * (len(parts.functions) * n_waiting)),
                ("rest", ctypes.c_double),
                ("steps", ctypes.c_int64),
            )

        library = ctypes.CDLL(str(compiled(files, folder, "-shared", "-fPIC", optimise)))
        self.struct = Struct()
        self.out = np.frombuffer(self.struct, count=n_out)
        self.at = ctypes.byref(self.struct)
        self._init, self._step, self._advance = library.m_init, library.m_step, library.m_advance
        self._advance.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_double]
        self._step.argtypes = [ctypes.c_void_p, ctypes.c_void_p]

    def init(self):
        return self._init(self.at)

    def step(self, voltage):
        return self._step(self.at, np.ascontiguousarray(voltage, dtype=float).ctypes.data)

    def advance(self, voltage, duration):
        return self._advance(self.at, np.ascontiguousarray(voltage, dtype=float).ctypes.data, duration)

    def run(self, voltage):
        """Outputs at the start and after each step, and the status of each step."""
        rows, status = np.empty((len(voltage) + 1, len(self.out))), np.zeros(len(voltage) + 1, dtype=int)
        voltage = np.ascontiguousarray(voltage)
        address = voltage.ctypes.data
        status[0], rows[0] = self.init(), self.out
        for k in range(len(voltage)):
            status[k + 1] = self._step(self.at, address + voltage.strides[0] * k)
            rows[k + 1] = self.out
        return rows, status
