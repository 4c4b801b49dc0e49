"""Kernels translated, compiled and loaded."""

import ctypes
import inspect
import subprocess
from typing import NamedTuple

import numpy as np
import pytest

from helpers.c_machine import STRICT
from polydraulic.errors import InputError
from polydraulic.export.translate.program import Program

INCLUDES = "".join(f"#include <{name}.h>\n" for name in ("math", "stdbool", "stddef", "stdint", "string"))
_SHIFT = 0.25


class Pair(NamedTuple):
    """Two numbers."""

    a: float  # first
    static: float


class Large(NamedTuple):
    """Goes by pointer."""

    one: Pair
    two: Pair
    n: int
    rows: np.ndarray


def library(folder, *kernels):
    """Shared library of the kernels, each with its example arguments."""
    program = Program()
    for kernel, examples in kernels:
        program.entry(kernel.__name__, kernel, examples)
    prototypes = "".join(f"{f.prototype};\n" for f in program.functions.values() if "static" not in f.prototype)
    text = f"{INCLUDES}\n{program.scope.structs()}\n{prototypes}\n{program.code()}"
    (folder / "k.c").write_text(text)
    command = ["gcc", *STRICT, "-O2", "-ffp-contract=off", "-shared", "-fPIC", "k.c", "-lm", "-o", "k.so"]
    subprocess.run(command, check=True, cwd=folder)
    loaded = ctypes.CDLL(str(folder / "k.so"))
    for kernel, examples in kernels:
        function = getattr(loaded, kernel.__name__)
        function.restype = ctypes.c_double
        kinds = {float: ctypes.c_double, int: ctypes.c_int64, np.ndarray: ctypes.c_void_p}
        function.argtypes = [kinds[type(example)] for example in examples]
    return loaded, text


def write_two(v, x):
    """Writes into an array and gives a number."""
    v[0], v[1] = x, 2.0 * x
    v[2] += _SHIFT
    return v[0] * v[1]


EXAMPLES = {"x": 1.0, "n": 3, "v": np.zeros(3), "p": Pair(1.0, 2.0)}  # by name of the parameter


def refusal(kernel):
    """Why a kernel does not translate: the line of its source, counted from 0, and the message behind the place."""
    with pytest.raises(InputError) as error:
        Program().entry("f", kernel, [EXAMPLES[name] for name in inspect.signature(kernel).parameters])
    file, line, message = str(error.value).split(":", 2)
    assert file == inspect.getsourcefile(kernel)
    return int(line) - inspect.getsourcelines(kernel)[1], message
