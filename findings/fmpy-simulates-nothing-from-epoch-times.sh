#!/bin/sh
# Title: fmpy.simulate_fmu returns the start alone, without a word, where start_time and stop_time are times since 1970 a second apart.
# Surprise: "stop_time: the stop time of the simulation" (documentation of `simulate_fmu`): the result ends there. The loop ends where
#   math.isclose(time, stop_time) holds, whose tolerance is 1e-9 of the times themselves: 1.7 s at 1.7e9 s.
# Versions: FMPy 0.3.32.
# What we do: nothing in the package, whose FMUs step from such times as from 0; tests of that step an FMU themselves (tests/export/fmu).
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet fmpy==0.3.32 pythonfmu==0.7.0
cat >"$folder/clock.py" <<'PYTHON'
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class Clock(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.steps = 0.0
        self.register_variable(Real("steps", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.steps += 1.0
        return True
PYTHON
cat >"$folder/show.py" <<'PYTHON'
import sys

import fmpy

print("FMPy", fmpy.__version__)
rows = {
    start: len(fmpy.simulate_fmu("Clock.fmu", start_time=start, stop_time=start + 1.0, output_interval=0.01))
    for start in (0.0, 1711850398.0)
}
print("described: 101 rows of a second in steps of 10 ms, from any start")
print("seen:     ", ", ".join(f"{count} from {start:.0f} s" for start, count in rows.items()))
there = rows == {0.0: 101, 1711850398.0: 1}
print("the behaviour is there" if there else "the behaviour has changed")
sys.exit(0 if there else 1)
PYTHON
cd "$folder"
PATH="$folder/venv/bin:$PATH"
pythonfmu build -f clock.py >build.log 2>&1 || { cat build.log; exit 2; }
python show.py
