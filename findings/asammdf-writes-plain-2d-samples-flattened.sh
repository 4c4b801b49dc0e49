#!/bin/sh
# Title: asammdf flattens a plain 2-D array of samples and writes its first values as a scalar channel, without an error.
# Surprise: three values for each of four time stamps become the first row and a value of the second, at the times of the four rows.
#   `Signal` takes samples that are "array-like", and checks that they are as many as the time stamps. `MDF4.append` says "For channel
#   dependencies type Signals, the `samples` attribute must be a np.recarray", so a plain array might be refused, as in version 3 of the
#   format; it should not be accepted and its values moved in time. A plain array of bytes is written whole; `Signal.astype` of a
#   signal of bytes that was read gives a plain array of which `append` loses most.
# Versions: asammdf 8.8.28; 7.4.5 with NumPy 1.26.4 does the same.
# What we do: src/polydraulic/measure/bench/recording.py hands asammdf one signal for each sensor, of one dimension.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet asammdf==8.8.28 numpy==2.4.6
cat >"$folder/show.py" <<'PYTHON'
import os
import sys
from importlib.metadata import version

import numpy as np
from asammdf import MDF, Signal

os.chdir(sys.argv[1])
time = np.arange(4) * 0.1
rows = np.arange(1.0, 13.0).reshape(4, 3)  # three values for each of four time stamps


def written(samples, form="4.10"):
    """Return the samples that a file has after a signal of them was appended and saved, or the error."""
    try:
        with MDF(version=form) as file:
            file.append(Signal(samples, time, name="p"))
            path = file.save("a", overwrite=True)
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    with MDF(path) as file:
        found = file.get("p").samples
    return (found if found.dtype.names is None else found["p"]).tolist()


def widened():
    """Return what is written of a signal of bytes that was read and made wider."""
    with MDF() as file:
        file.append(Signal(rows.astype("u1"), time, name="p"))
        return written(file.get("p").astype("i2").samples)


plain, older, octets, wide = written(rows), written(rows, "3.30"), written(rows.astype("u1")), widened()
record = written(np.rec.fromarrays([rows], dtype=[("p", "f8", (3,))]))
print("asammdf", version("asammdf"), "numpy", np.__version__)
print("described: samples are array-like, here", rows.tolist(), "- to be written as they are, or refused")
print("seen:      plain array, version 4.10:    ", plain)
print("           plain array, version 3.30:    ", older)
print("           record array, version 4.10:   ", record)
print("           plain array of bytes:         ", octets)
print("           these, read, and astype('i2'):", wide)
lost = plain == wide == [1, 2, 3, 4]  # the first four of the twelve values, as the times of four rows
there = lost and octets == rows.tolist() == record and older.startswith("ValueError")
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
"$folder/venv/bin/python" "$folder/show.py" "$folder"
