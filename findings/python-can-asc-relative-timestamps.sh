#!/bin/sh
# Title: python-can reads the header `timestamps relative` of an ASC log and then takes times from line to line for times since the start.
# Surprise: of the two kinds of times of the format ("base hex timestamps absolute|relative") relative ones count from the event before.
#   `ASCReader` keeps the word in `timestamps_format` and uses it nowhere; its option `relative_timestamp` is about the date of the start.
# Versions: python-can 4.6.1.
# What we do: such a log is refused with the advice to save it with absolute times (src/polydraulic/measure/formats/can).
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet python-can==4.6.1
cat >"$folder/show.py" <<'PYTHON'
import os
import sys
from importlib.metadata import version

import can

os.chdir(sys.argv[1])
with open("a.asc", "w") as file:
    file.write("date Mon Mar 4 10:00:00.000 am 2024\nbase hex  timestamps relative\nno internal events logged\n")
    file.writelines(f"   0.100000 1  123             Rx   d 1 0{k}\n" for k in range(3))  # a tenth of a second apart
with can.ASCReader("a.asc") as reader:
    times = [message.timestamp for message in reader]
    kind = reader.timestamps_format
print("python-can", version("python-can"))
print("described: times relative to the event before, so 0.1, 0.2 and 0.3 s")
print("seen:     ", times, "s, with timestamps_format", repr(kind))
there = times == [0.1, 0.1, 0.1] and kind == "relative"
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
"$folder/venv/bin/python" "$folder/show.py" "$folder"
