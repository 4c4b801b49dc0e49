#!/bin/sh
# Title: numba calls a function many times slower if its argument is a named tuple whose class shares name and fields with another class.
# Surprise: "Named tuple classes, as returned by collections.namedtuple, are supported in the same way regular tuples are supported" (Supported
#   Python features), which have no such cost. The dispatcher's fast path knows a named tuple by the names of class
#   and fields and not by the class, takes the second class for the first, finds nothing compiled for that, and has every number of the
#   argument looked at in Python, at each call. Results stay right.
# Versions: numba 0.68.1; others were not tried.
# What we do: src/polydraulic/flow/layout/text_module.py gives the classes of each generated module names of their own.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numba==0.68.1
cat >"$folder/show.py" <<'PYTHON'
import sys
from collections import namedtuple
from time import process_time

import numba

FIELDS = [f"number_{k}" for k in range(100)]


def call(name):
    """Processor seconds of a call of a function of its own with a named tuple of a class of its own."""
    value = namedtuple(name, FIELDS)(*map(float, range(len(FIELDS))))
    last = numba.njit(lambda numbers: numbers[99])
    assert last(value) == 99.0
    assert len(last.signatures) == 1
    best = 1.0
    for _ in range(5):
        start = process_time()
        for _ in range(500):
            last(value)
        best = min(best, (process_time() - start) / 500)
    return best


print("numba", numba.__version__)
times = {"Plant": call("Plant"), "Plant, another class": call("Plant"), "Valves": call("Valves")}
for name, seconds in times.items():
    print(f"{name:22s} {1e6 * seconds:8.1f} us a call")
first, second, other = times.values()
print("described: each function is compiled for its argument, so that calls take equally long")
there = second > 3.0 * first and second > 3.0 * other
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
"$folder/venv/bin/python" "$folder/show.py"
