"""A few figures of speed, kept from commit to commit: ``make bench-history``, or ``python benchmarks/history.py [--show]``.

Without `--show` a fixed set of short benchmarks is run, and their medians are appended to ``benchmarks/history.jsonl`` with date, commit,
processor, number of cores and load. Each is timed in pairs with a yardstick, a loop of NumPy that no commit changes, and kept as a multiple of
it, too: that is what is compared, since machines have better and worse hours. `--show` says of each figure how it went, and which is slower
now than it was; only runs on the same processor with as many cores are compared.
"""

import argparse
import json
import os
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

from keep import commit, machine
from polydraulic import AbductiveRegressor, build_flow, load_machine, load_scenario, simulate_batch
from polydraulic.export import bundle, to_c
from polydraulic.flow.polynomial import shipped_models
from polydraulic.simulation.layout.runs import prepared_run
from polydraulic.thesis.timing import paired_times

FILE = Path(__file__).parent / "history.jsonl"
PAIRS = 9
SLOWER = 1.15  # of the median of earlier runs: what is told
MARKS = "▁▂▃▄▅▆▇█"


def calls():
    """The fixed set: what each call does must not change, or it needs another name."""
    excavator, task = load_machine("cat215b"), load_scenario("task")
    rng = np.random.default_rng(0)
    X, many, steps = rng.uniform(size=(1000, 6)), rng.uniform(size=(200000,)), np.zeros((256, 400, 3))
    y = 10.0 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20.0 * (X[:, 2] - 0.5) ** 2 + 10.0 * X[:, 3] + 5.0 * X[:, 4]
    steps[:] = rng.uniform(-0.7, 0.7, (256, 1, 3))
    models = shipped_models()
    largest = max(models, key=lambda model: len(model.networks))
    rows = largest.domain()[:, 0] + np.ptp(largest.domain(), axis=1) * rng.uniform(size=(20000, len(largest.inputs)))
    program = [sys.executable, "-c", "import polydraulic.cli"]
    return {
        "yardstick": lambda: np.sort(many).sum() + float(np.sin(many).sum()),
        "task, exact, 2600 steps": prepared_run(excavator, build_flow("exact", excavator), task),
        "task, polynomial, 2600 steps": prepared_run(excavator, build_flow("polynomial", excavator), task),
        "batch of 256 x 400, keeping none": lambda: simulate_batch(excavator, "exact", steps, threads=1).final.sum(),
        "batch of 256 x 400, keeping rows": lambda: simulate_batch(
            excavator, "exact", steps, threads=1, keep=["rows"]
        ).rows.sum(),
        "20000 rows through 150 regions": lambda: largest.predict(rows).sum(),
        "fit of 1000 x 6": lambda: AbductiveRegressor(max_layers=2).fit(X, y).predict(X).sum(),
        "C of 150 regions": lambda: len(to_c(bundle([largest]))[1]),
        "import of the command line": lambda: subprocess.run(program, check=True),
    }


def seconds():
    """Processor time of this process and of those that it waited for."""
    used = os.times()
    return process_time() + used.children_user + used.children_system


def measure():
    """Run the set, and append a line."""
    found = paired_times(calls(), pairs=PAIRS, clock=seconds)
    entry = {
        "date": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
        "machine": machine(),
        "load_average": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "seconds": {name: float(f"{time.seconds:.4g}") for name, time in found.items()},
        "yardsticks": {name: float(f"{time.ratio.median:.4g}") for name, time in found.items() if name != "yardstick"},
    }
    with FILE.open("a", encoding="utf-8") as file:
        file.write(json.dumps(entry, ensure_ascii=False) + "\n")
    for name, time in found.items():
        print(f"{name:36s} {1e3 * time.seconds:10.3f} ms   {time.ratio} yardsticks")


def show(entries):
    """Say how each figure went on the machine of the last run; how many are slower than before."""
    if not entries:
        print(f"{FILE.name} is empty: run python benchmarks/history.py")
        return 0
    last = entries[-1]
    here = [entry for entry in entries if entry["machine"] == last["machine"]]
    print(f"{last['machine']}: {len(here)} of {len(entries)} runs, {here[0]['date']} to {last['date']}, in yardsticks")
    slower = []
    for name, now in last["yardsticks"].items():
        values = [entry["yardsticks"][name] for entry in here if name in entry["yardsticks"]]
        before = values[:-1]
        text = f"  {name:36s} {curve(values[-40:]):40s} {now:10.4g}"
        if before:
            text += f"   {now / median(before):.2f} of the median before"
            if now > SLOWER * median(before):
                text += "   SLOWER"
                slower.append(name)
        print(text)
    print(f"slower than before: {', '.join(slower)}" if slower else "nothing is slower than before")
    return len(slower)


def curve(values):
    """Values as a line of blocks."""
    low, high = min(values), max(values)
    span = (high - low) or 1.0
    return "".join(MARKS[round((len(MARKS) - 1) * (value - low) / span)] for value in values)


def read(path):
    """Entries of a history."""
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.exists() else []


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--show", action="store_true", help="say which figures are slower than before")
    if not parser.parse_args().show:
        measure()
    show(read(FILE))


if __name__ == "__main__":
    main()
