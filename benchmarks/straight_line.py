"""Networks as straight-line machine code: steps next to the exact flow, batches next to exact lanes and to another build, and what it costs.

``python benchmarks/straight_line.py [--other PYTHON]`` prints and asserts nothing. PYTHON is the interpreter of an environment with another
build of polydraulic: both builds run the same batches in turn, each in a process of its own that is kept, and their final values are compared.
Times are processor times, batches run on one thread.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import weakref
from pathlib import Path
from time import process_time

import numpy as np

from polydraulic import build_flow, load_machine, load_scenario, simulate, simulate_batch
from polydraulic.flow.polynomial import shipped_models
from polydraulic.networks.model import machine_code
from polydraulic.thesis.timing import PAIRED, PAIRS, paired_times, ratio_of, time_runs
from show import left_out, show, table

SCENARIOS = ("sine", "task", "step", "pulse")
MACHINES, STEPS, DT, BATCH_PAIRS = 256, 2600, 5e-3, 11
WORKER = Path(__file__).parent / "batch_worker.py"


def steps(machine):
    """One machine: the compiled loop over a whole scenario, all columns recorded."""
    models = {
        "exact": build_flow("exact", machine),
        "polynomial, cascade": build_flow("polynomial", machine),
        "polynomial, direct": build_flow("polynomial", machine, arrangement="direct"),
        "neural": build_flow("neural", machine),
    }
    found = {name: time_runs(machine, models, load_scenario(name), base="exact") for name in SCENARIOS}
    rows = [[name, *(str(found[s][name].ratio) for s in SCENARIOS)] for name in models if name != "exact"]
    rows.append(["exact, ns", *(f"{found[s]['exact'].seconds / STEPS * 1e9:.0f}" for s in SCENARIOS)])
    table(f"Time of a step, ratio to exact, {PAIRED}", ["flow model", *SCENARIOS], rows)


def varied(machine, name):
    """Voltages of a scenario, of each machine and link scaled by its own factor."""
    voltages = load_scenario(name).voltages(np.arange(STEPS) * DT, machine.names)
    return voltages * np.random.default_rng(0).uniform(0.7, 1.3, (MACHINES, 1, len(machine.names)))


def batches(machine):
    """Lanes with networks next to exact lanes."""
    models = {name: build_flow(name, machine) for name in ("exact", "polynomial", "neural")}
    for name in ("sine", "step"):
        inputs = varied(machine, name)
        calls = {
            kind: (lambda flow=flow, inputs=inputs: simulate_batch(machine, flow, inputs, threads=1).final.sum())
            for kind, flow in models.items()
        }
        times = paired_times(calls, pairs=BATCH_PAIRS, clock=process_time)
        show(f"a step of each of {MACHINES} machines, {name}", times, "ns", per=STEPS * MACHINES)


def against(machine, other):
    """The same batches with networks by another build and by this one, in turn."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENARIOS:
            np.save(Path(folder) / f"{name}.npy", varied(machine, name))
        workers = [
            subprocess.Popen(
                [python, WORKER, folder], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
            )
            for python, env in ((other, environment), (sys.executable, os.environ))
        ]

        def ask(worker, name):
            worker.stdin.write(f"{name}\n")
            worker.stdin.flush()
            seconds, total = worker.stdout.readline().split()
            return float(seconds), total

        print("\nthe other build / this one")
        for name in SCENARIOS:
            found = [[ask(worker, name) for worker in workers] for _ in range(BATCH_PAIRS + 1)][1:]
            seconds = np.array([[one[0] for one in pair] for pair in found])
            same = "same" if len({total for pair in found for _, total in pair}) == 1 else "other"
            each = np.median(seconds, axis=0) / STEPS / MACHINES * 1e9
            ratio = ratio_of(seconds[:, 0], seconds[:, 1])
            print(f"  {name:6s} {each[0]:6.0f} ns / {each[1]:5.0f} ns: {ratio!s:24s} {same} final values", flush=True)
        for worker in workers:
            worker.communicate()


def by_name(machine):
    """A short run with a flow model by name, and with one that is built."""
    flow, scenario = build_flow("polynomial", machine), load_scenario("sine")
    calls = {
        "a model that is built": lambda: simulate(machine, flow, scenario, t_end=0.5)["boom.angle"].sum(),
        "by name": lambda: simulate(machine, "polynomial", scenario, t_end=0.5)["boom.angle"].sum(),
    }
    show(f"`simulate` of half a second, {PAIRS} pairs", paired_times(calls), "ms")


def cost():
    """Machine code of the package's networks: compiled, and read by the next process."""
    rows = []
    for name in ("cascade", "direct", "neural", "fine"):
        models = shipped_models(name, limited=name != "neural")
        with tempfile.TemporaryDirectory() as folder:
            machine_code.cache_folder = lambda folder=folder: folder
            seconds = []
            for _ in range(2):
                machine_code._in_memory = weakref.WeakValueDictionary()  # as in a new process
                start = process_time()
                machine_code.network_code(models)
                seconds.append(process_time() - start)
            size = sum(file.stat().st_size for file in Path(folder).rglob("*.code"))
        regions = sum(len(model.networks) for model in models)
        rows.append([name, str(len(models)), str(regions), *(f"{s:.2f}" for s in seconds), f"{size / 1e6:.2f}"])
    table("Machine code", ["networks", "models", "regions", "compiled, s", "read, s", "MB"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--other", help="python of an environment with another build")
    options = parser.parse_args()
    machine = load_machine("cat215b")
    steps(machine)
    batches(machine)
    if options.other:
        against(machine, options.other)
    else:
        left_out("another build", "--other PYTHON, the interpreter of an environment that has it")
    by_name(machine)
    cost()


if __name__ == "__main__":
    main()
