#!/bin/sh
# Title: scipy.io.whosmat ends in a TypeError where a MAT file up to v7 holds an object, such as a timetable or a string.
# Surprise: "List variables inside a MATLAB file" (documentation of `whosmat`), of a file that `loadmat` reads, the object as MatlabOpaque.
#   Nothing is listed, not even the arrays beside the object, so that variables cannot be read one at a time.
# Versions: SciPy 1.17.1. A change was proposed as https://github.com/scipy/scipy/pull/17271.
# What we do: src/polydraulic/measure/formats/mat/variables.py lists the variables itself, and names objects with their classes.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet scipy==1.17.1 numpy==2.4.6
cat >"$folder/show.py" <<'PYTHON'
import io
import sys

import numpy as np
import scipy
from scipy.io import loadmat, savemat, whosmat


def element(kind, data):
    return np.array([kind, len(data)], dtype="<u4").tobytes() + data + bytes(-len(data) % 8)


# a variable of class 17: flags, its name, the system of its class, its class, and a reference that MATLAB alone can follow
texts = b"".join(element(1, text) for text in (b"rig", b"MCOS", b"timetable"))
reference = element(6, np.array([13, 0], dtype="<u4").tobytes()) + element(5, np.array([6, 1], dtype="<i4").tobytes())
reference += element(1, b"") + element(6, np.array([0xDD000000, 2, 1, 1, 1, 1], dtype="<u4").tobytes())
file = io.BytesIO()
savemat(file, {"t": np.arange(9.0)})
content = file.getvalue() + element(14, element(6, np.array([17, 0], dtype="<u4").tobytes()) + texts + element(14, reference))

print("SciPy", scipy.__version__, "numpy", np.__version__)
read = loadmat(io.BytesIO(content))
print("loadmat:  ", {name: type(item).__name__ for name, item in read.items() if not name.startswith("__")})
print("described: whosmat lists the variables: t and the object")
try:
    seen = whosmat(io.BytesIO(content))
except TypeError as error:
    seen = f"TypeError: {error}"
print("seen:     ", seen)
there = seen == "TypeError: 'NoneType' object is not iterable" and read["t"].shape == (1, 9)
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
"$folder/venv/bin/python" "$folder/show.py"
