"""Two pumps with a crossover next to another method, over a million random states of each kind: what the largest errors of their flows are.

``python benchmarks/crossover_errors.py [--states 1000000]`` prints and asserts nothing. States are those of the tests: valves of the machine at random
spools (real), conductances over six decades (hard), just opening, dead ends, ports equal, at return or relief (edges); crossovers over three decades, a
tenth of them shut, three tenths just opening, half of them with an opening pressure. Every block of 20,000 has another torque limit: none, exponent 0.5, 1, 2. The other method is
brackets within brackets on the pressures of all nodes, in twice the machine's precision. Errors are shares of the smaller pump's flow; *bracketed* is what the
certificate of the passes refuses.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from helpers.crossover_made import STATUS, judged, off, random_states, solved
from helpers.series_made import STATES
from polydraulic import load_machine
from polydraulic.machine.circuits.series.check import REPAIRED, UNPROVED
from show import table

BLOCK = 20_000
EXPONENTS = (0.0, 0.5, 1.0, 2.0)  # of the torque limit; 0: none
HEADER = (
    "kind",
    "states",
    "open crossovers",
    "largest error",
    "above 1e-9",
    "bracketed",
    "refused",
    "doubt of the judge",
)


def row(machine, kind, size):
    """A row of the table."""
    errors, crossing, bracketed, refused, doubts = [], 0, 0, 0, []
    for seed in range(max(size // BLOCK, 1)):
        states = random_states(machine, kind, EXPONENTS[seed % 4], BLOCK, 1000 + seed + seed // 4)
        found = solved(states)
        true = judged(states, found)
        errors.append(off(found, true, states))
        crossing += np.count_nonzero(found[:, 4] > 0.0)
        bracketed += np.count_nonzero(found[:, STATUS] == REPAIRED)
        refused += np.count_nonzero(found[:, STATUS] == UNPROVED)
        doubts.append(true[:, -1].max())
    errors = np.concatenate(errors)
    above = np.count_nonzero(errors > 1e-9)
    counts = f"{above}", f"{bracketed}", f"{refused}"
    return kind, f"{len(errors)}", f"{crossing}", f"{errors.max():.2g}", *counts, f"{max(doubts):.2g}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--states", type=int, default=1_000_000)
    chosen = parser.parse_args()
    machine = load_machine("cat215b")
    table("Two pumps with a crossover", HEADER, (row(machine, kind, chosen.states) for kind in STATES))


if __name__ == "__main__":
    main()
