"""Valves in series next to another method, over a million random states of each kind: what the largest errors of their flows are.

``python benchmarks/series_errors.py [--states 1000000] [3 4 6]`` prints and asserts nothing; the numbers are those of the valves. States are
those of the tests: valves of the machine at random spools (real), conductances over six decades (hard), just opening, dead ends, ports equal,
at return or relief (edges). Every block of 20,000 has another torque limit: none, exponent 0.5, 1, 2. The other method is a bisection in twice the machine's
precision; where that does not decide, one in a hundred digits. Errors are shares of the pump's flow.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from helpers.series_judge_exactly import judged_surely
from helpers.series_made import STATES, pump_of, series, solved
from polydraulic import load_machine
from polydraulic.machine.circuits.series.check import REPAIRED, UNPROVED
from show import table

BLOCK = 20_000
EXPONENTS = (0.0, 0.5, 1.0, 2.0)  # of the torque limit; 0: none
HEADER = (
    "kind",
    "states",
    "largest error",
    "above 1e-9",
    "repaired",
    "largest of these",
    "refused",
    "judged in 100 digits",
    "doubt of the judge",
)


def series_block(n, machine, kind, exponent, seed):
    """Errors, statuses, how many were judged in a hundred digits and the judge's doubt."""
    states, pump = STATES[kind](machine, n, BLOCK, np.random.default_rng(seed)), pump_of(machine, exponent)
    found = solved(series(n).solve_all, states, pump)
    true, again, doubt = judged_surely(states, pump)
    return np.abs(found[:, : n + 3] - true).max(axis=1) / pump.flow, found[:, n + 4], again, doubt


def judged(block, machine, kind, size):
    """A row of the table."""
    parts = [block(machine, kind, EXPONENTS[seed % 4], 1000 + seed) for seed in range(max(size // BLOCK, 1))]
    errors, statuses = (np.concatenate([part[place] for part in parts]) for place in (0, 1))
    repaired = errors[statuses == REPAIRED]
    return (
        kind,
        f"{len(errors):d}",
        f"{errors.max():.2g}",
        f"{np.count_nonzero(errors > 1e-9):d}",
        f"{len(repaired):d}",
        f"{repaired.max(initial=0.0):.2g}",
        f"{np.count_nonzero(statuses == UNPROVED):d}",
        f"{sum(part[2] for part in parts):d}",
        f"{max(part[3] for part in parts):.2g}",
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("numbers", nargs="*", type=int, default=[3, 4, 6])
    parser.add_argument("--states", type=int, default=1_000_000)
    chosen = parser.parse_args()
    machine = load_machine("cat215b")
    for n in chosen.numbers:
        rows = (judged(lambda *given, n=n: series_block(n, *given), machine, kind, chosen.states) for kind in STATES)
        table(f"{n} valves in series", HEADER, rows)


if __name__ == "__main__":
    main()
