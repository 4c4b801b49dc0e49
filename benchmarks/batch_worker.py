"""Batches with networks on one thread, as often as asked: ``python batch_worker.py FOLDER``, with voltages in FOLDER/NAME.npy.

Reads a name a line, runs that batch and prints processor seconds and the sum of all final values. It calls what every build has had.
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np

from polydraulic import build_flow, load_machine, simulate_batch


def main():
    machine = load_machine("cat215b")
    flow = build_flow("polynomial", machine)
    for name in map(str.strip, sys.stdin):
        voltages = np.load(Path(sys.argv[1]) / f"{name}.npy")
        start = process_time()
        batch = simulate_batch(machine, flow, voltages, threads=1)
        print(process_time() - start, float(batch.final.sum()).hex(), flush=True)


if __name__ == "__main__":
    main()
