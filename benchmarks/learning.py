"""How long it takes to learn: what commands and estimators need, next to an earlier build.

    python benchmarks/learning.py [--old PATH] [--pairs N] [--only PART ...] [--minutes N] [--rows N]

PATH is an environment (the folder that holds ``bin/python``) in which the earlier build is installed; without it this one is timed alone.
Every measurement is a process of its own, and builds alternate. Times are processor time of the process and of all that it starts, and the
time that passed; a ratio is that of the earlier build to this one, the median of all pairs. Next to them stands the error, by which both are judged.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

from polydraulic import Table, load_models, read_table, write_table

RIG = """
import json, sys, time
import numpy as np
from polydraulic import AbductiveRegressor
from polydraulic.networks import learn_from
"""
FRIEDMAN = """
def friedman(n, seed=0, noise=1.0):
    rng = np.random.default_rng(seed)
    X = rng.uniform(size=(n, 10))
    y = 10 * np.sin(np.pi * X[:, 0] * X[:, 1]) + 20 * (X[:, 2] - 0.5) ** 2 + 10 * X[:, 3] + 5 * X[:, 4]
    return X, y + noise * rng.normal(size=n)

def error(model):
    X, y = friedman(20_000, 1, 0.0)
    return float(np.sqrt(np.mean((model.predict(X) - y) ** 2)))
"""
MEMORY = """
model = AbductiveRegressor().fit(*friedman(N))
print(json.dumps({"rms against the truth": error(model)}))
"""
BLOCKS = """
import resource
class Blocks:
    def __iter__(self):
        return (friedman(50_000, seed) for seed in range(N // 50_000))
model = AbductiveRegressor().fit_blocks(Blocks())
print(json.dumps({"rms against the truth": error(model), "GiB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20}))
"""
VALVE = """
def flow(X):
    '''Flow of a pump (in3/s) into an actuator, of spool travel (in) and line pressure (psi), past an open bypass.'''
    inlet = np.interp(X[:, 0], [0.0, 0.188, 0.376, 0.564], [0.0, 0.0, 44.0, 88.0])
    bypass = np.interp(X[:, 0], [0.0, 0.188, 0.376, 0.564], [16.0, 5.219, 0.0, 0.0]) ** 2
    drop = X[:, 1] - 50.0
    root = np.sqrt(np.maximum(bypass * (171.5**2 + (inlet**2 - bypass) * drop), 0.0))
    return np.clip(inlet * (171.5**2 - bypass * drop) / (inlet * 171.5 + root + 1e-300), 0.0, 171.5)
"""
FUNCTION = """
box = [(0.0, 0.564), (0.0, 4000.0)]
found = learn_from(flow, box, tolerance=0.15)
grid = np.stack(np.meshgrid(*[np.linspace(*ends, 801) for ends in box]), axis=-1).reshape(-1, 2)
largest = float(np.abs(found.model.predict(grid) - flow(grid)).max())
print(json.dumps({"largest error": largest, "regions": len(found.model.networks), "evaluations": found.n_evaluations}))
"""
RIDGE = """
from sklearn.linear_model import RidgeCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler
from threadpoolctl import threadpool_limits
X, y = friedman(1000)
ridge = make_pipeline(StandardScaler(), PolynomialFeatures(3, include_bias=False), RidgeCV(np.logspace(-3, 3, 7)))
ratios = []
with threadpool_limits(1):
    for pair in range(8):
        times = []
        for model in (AbductiveRegressor(), ridge):
            began = time.thread_time()
            model.fit(X, y)
            times.append(time.thread_time() - began)
        ratios.append(times[0] / times[1])
X, y = friedman(1000, 2, 0.0)
model = AbductiveRegressor().fit(*friedman(1000))
r2 = 1.0 - float(np.mean((model.predict(X) - y) ** 2) / np.var(y))
print(json.dumps({"fit in times of a cubic ridge grid": float(np.median(ratios[1:])), "R2": r2}))
"""
COMMAND = "from polydraulic.cli import main; main()"
SIGNALS = ["boom.voltage", "stick.voltage", "boom.angle", "stick.angle"]


def build(prefix):
    """Interpreter and surroundings of a build: this one, or that of an environment."""
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return (
        (sys.executable, dict(os.environ)) if prefix is None else (str(Path(prefix) / "bin" / "python"), surroundings)
    )


def measured(of, folder, arguments):
    """What a process printed, its processor time with that of all that it started, and the time that passed."""
    python, surroundings = of
    began = perf_counter()
    with (
        tempfile.TemporaryFile(mode="w+") as said,
        subprocess.Popen(
            [python, "-W", "ignore", *arguments], cwd=folder, env=surroundings, stdout=said, stderr=subprocess.DEVNULL
        ) as process,
    ):
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            sys.exit(f"{' '.join(arguments)[:200]} ended with {process.returncode}")
        said.seek(0)
        return said.read(), usage.ru_utime + usage.ru_stime, perf_counter() - began


def tables(folder, minutes):
    """A log of an operator at work, the part of it that a dynamic model learns from, a table of a valve, and short ones that warm up."""
    folder = Path(folder)
    units = {
        "spool": "mm",
        "p_a": "bar",
        "p_b": "bar",
        "q_in": "l/min",
        "q_out": "l/min",
        "voltage": "V",
        "angle": "deg",
    }
    ranges = {"mm": [-16, 16], "bar": [-10, 500], "l/min": [-400, 800], "V": [-1.1, 1.1], "deg": [-9999, 9999]}
    roles = {"q_in": "output", "q_out": "output", "angle": "output"}
    channels = [
        f'[[channel]]\nsource = "{link}.{what}"\nrole = "{roles.get(what, "input")}"\nunit = "{unit}"\nrange = {ranges[unit]}\n'
        for link in ("swing", "boom", "stick")
        for what, unit in units.items()
    ]
    (folder / "map.toml").write_text('raster = "20 ms"\n' + "\n".join(channels))
    for words in (
        "record --example --out sensors.toml",
        f"record random:1:{60 * minutes} --sensors sensors.toml --out log.mf4",
        "import log.mf4 --channels map.toml --out machine.parquet",
    ):
        measured(build(None), folder, ["-c", COMMAND, *words.split()])
    log = read_table(folder / "machine.parquet")
    for name, n in (("dynamic", 14_000), ("dynamic_short", 1_000)):
        kept = ["time", "segment", *SIGNALS]
        write_table(Table({c: log[c][:n] for c in kept}, {c: log.unit(c) for c in kept}), folder / f"{name}.parquet")
    place = {"np": np}
    exec(VALVE, place)
    rng = np.random.default_rng(0)
    for name, n in (("valve", 20_000), ("valve_short", 500)):
        x = rng.uniform(size=(n, 3)) * (0.564, 4000.0, 1.0)
        y = place["flow"](x) * (1.0 + 0.3 * np.sin(5.0 * x[:, 2]))
        write_table(Table({"x": x[:, 0], "p": x[:, 1], "s": x[:, 2], "q": y}, {}), folder / f"{name}.parquet")


def stated(file, *names):
    """What model files state of errors on rows held out."""
    return {
        f"{model.output.name}: {name}": model.training[name]
        for model in load_models(file)
        for name in names
        if name in model.training
    }


def of_command(folder, words, *names):
    def run(of):
        _, cpu, wall = measured(of, folder, ["-c", COMMAND, *words.split(), "--out", "model.json"])
        return stated(Path(folder) / "model.json", *names), cpu, wall

    return run


def of_script(folder, text):
    def run(of):
        said, cpu, wall = measured(of, folder, ["-c", RIG + text])
        return json.loads(said), cpu, wall

    return run


def parts(folder, rows):
    """Title, a short run that compiles and fills caches, and the run, by name."""
    dynamic = "--inputs boom.voltage,stick.voltage --outputs boom.angle,stick.angle --dynamic"
    valve = "--inputs x,p,s --outputs q --regions"
    return {
        "dynamic": (
            "fit --dynamic, 14000 rows, 2 inputs, 2 outputs",
            of_command(folder, f"fit dynamic_short.parquet {dynamic}"),
            of_command(folder, f"fit dynamic.parquet {dynamic}", "free_run_rms"),
        ),
        "regions": (
            "fit --regions 64, 20000 rows x 3",
            of_command(folder, f"fit valve_short.parquet {valve} 2"),
            of_command(folder, f"fit valve.parquet {valve} 64", "held_out_rms"),
        ),
        "machine": (
            "fit-machine",
            of_command(folder, f"fit valve_short.parquet {valve} 2"),
            of_command(folder, "fit-machine machine.parquet", "held_out_flow_rms"),
        ),
        "memory": (
            f"{rows} rows x 10 in memory",
            of_script(folder, FRIEDMAN + MEMORY.replace("N", "2_000")),
            of_script(folder, FRIEDMAN + MEMORY.replace("N", str(rows))),
        ),
        "blocks": (
            f"{rows} rows x 10 in blocks, which are made anew for each pass",
            of_script(folder, FRIEDMAN + MEMORY.replace("N", "2_000")),
            of_script(folder, FRIEDMAN + BLOCKS.replace("N", str(rows))),
        ),
        "friedman": (
            "Friedman 1, 1000 rows x 10",
            of_script(folder, FRIEDMAN + MEMORY.replace("N", "2_000")),
            of_script(folder, FRIEDMAN + RIDGE),
        ),
        "function": (
            "learn_from, steep valve, tolerance 0.15 in3/s",
            of_script(folder, FRIEDMAN + MEMORY.replace("N", "2_000")),
            of_script(folder, VALVE + FUNCTION),
        ),
    }


def in_words(found):
    return ", ".join(
        f"{name} {value:.4g}" if isinstance(value, float) else f"{name} {value}" for name, value in found.items()
    )


def compared(title, warm, run, builds, pairs):
    """Print medians of both builds, and of the ratios of pairs."""
    runs = {name: [] for name in builds}
    for of in builds.values():
        warm(of)
    for _ in range(pairs):
        for name, of in builds.items():
            runs[name].append(run(of))
    print(f"\n{title}; {pairs} run(s) of each, load average {os.getloadavg()[0]:.1f}")
    for name, found in runs.items():
        cpu, wall = (median(one[place] for one in found) for place in (1, 2))
        print(f"  {name}: {cpu:.1f} s of processor time, {wall:.1f} s; {in_words(found[-1][0])}")
    if len(builds) > 1:
        old, new = runs.values()
        for place, what in ((1, "processor time"), (2, "time that passed")):
            ratios = [a[place] / b[place] for a, b in zip(old, new, strict=True)]
            print(f"  earlier / now, {what}: {median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--old", help="environment of an earlier build, such as ../old/.venv")
    parser.add_argument("--pairs", type=int, default=5, help="runs of each build")
    parser.add_argument("--rows", type=int, default=1_000_000, help="of the large tables, a multiple of 50000")
    parser.add_argument("--minutes", type=int, default=30, help="of the log that a machine is learnt from")
    parser.add_argument(
        "--only", nargs="+", help="parts of it: dynamic, regions, machine, memory, blocks, friedman, function"
    )
    options = parser.parse_args()
    builds = ({} if options.old is None else {"earlier": build(options.old)}) | {"now": build(None)}
    with tempfile.TemporaryDirectory() as folder:
        wanted = {
            name: part
            for name, part in parts(folder, options.rows).items()
            if options.only is None or name in options.only
        }
        if {"dynamic", "regions", "machine"} & set(wanted):
            tables(folder, options.minutes)
        for part in wanted.values():
            compared(*part, builds, options.pairs)


if __name__ == "__main__":
    main()
