"""What a user waits for: steps, `verify` of a model of many regions, batches that keep their rows, start-up, the first compilation.

``python benchmarks/waits.py [steps] [verify] [kept] [start] [compile] [--old FOLDER] [--rounds N]``: parts by name, all if there is none.
`--old` is a checkout of an earlier commit with an environment of its own in ``.venv``, which takes its turns in processes of their own.
Processes are compared by the processor time that they and their children took, which neighbours do not add to; rounds are interleaved,
and a ratio is the median of those within a round, with quartiles. Nothing is asserted but that both builds find the same.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from polydraulic import save_models
from polydraulic.flow.polynomial import shipped_models
from polydraulic.thesis.timing import ratio_of

HERE = Path(__file__).parent
_STEPS = """
import json
from time import process_time
from polydraulic import load_machine, load_scenario, simulate, simulate_batch
from polydraulic.parameters.scenario import random_operator
machine, long, batch = load_machine("cat215b"), random_operator(1, 600.0), [load_scenario("task")] * 256
def timed(run):
    took, total = [], run()
    for _ in range(15):
        start = process_time()
        assert run() == total
        took.append(process_time() - start)
    return sorted(took)[7], total.hex()
def alone():
    run = simulate(machine, "exact", long)
    return float(sum(run[name].sum() for name in run.names))
def lanes():
    return float(simulate_batch(machine, "exact", batch, threads=1).final.sum())
print(json.dumps([timed(alone), timed(lanes)]))
"""
_VERIFY = """
import json, sys
from pathlib import Path
from polydraulic.export import export_c, verify_models
from polydraulic.networks import load_models
models = load_models(sys.argv[1])
files = export_c(models, sys.argv[2], name="swing")
found, not_tried = verify_models(models)
size = next(Path(sys.argv[2]).glob("*.c")).stat().st_size
print(json.dumps([size, {a.target: [max(a.inside, a.border, a.outside), a.holds] for a in found}, len(not_tried)]))
"""
_KEPT = """
import json
from resource import RUSAGE_SELF, getrusage
from polydraulic import load_machine, load_scenario, simulate_batch
n, rounds, machine = 256, 9, load_machine("cat215b")
inputs = [load_scenario("task")] * n
def run(**keep):
    start = getrusage(RUSAGE_SELF)
    batch = simulate_batch(machine, "exact", inputs, threads=1, **keep)
    end = getrusage(RUSAGE_SELF)
    assert batch.final.sum() + (0.0 if batch.rows is None else batch.rows.sum()) != 0.0
    user = end.ru_utime - start.ru_utime
    return user, user + end.ru_stime - start.ru_stime
run(), run(keep=["rows"])
times = [(run(), run(keep=["rows"])) for _ in range(rounds)]
print(json.dumps([times, n * 2600]))
"""
_COMPILE = """
import sys
from polydraulic import load_machine, load_scenario, simulate
print(float(simulate(load_machine("cat215b"), sys.argv[1], load_scenario("task"), t_end=0.1)["boom.angle"].sum()))
"""


class Build:
    """A build of the package: its interpreter, and the environment in which it runs."""

    def __init__(self, name, python, source, home):
        self.name, self.python = name, str(python)
        left_out = ("PYTHONPATH", "PYTHONDONTWRITEBYTECODE", "NUMBA_CACHE_DIR")
        self.environment = {key: value for key, value in os.environ.items() if key not in left_out}
        self.environment |= {"XDG_CACHE_HOME": str(home / name), "OMP_NUM_THREADS": "1", "PYTHONPATH": str(source)}

    def __call__(self, *arguments, **more):
        """Processor seconds of a process and its children, and what it printed."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command, environment = [self.python, *map(str, arguments)], self.environment | more
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, cwd=environment["XDG_CACHE_HOME"]
        )
        if done.returncode:
            sys.exit(f"{self.name}: {' '.join(command)[:200]}\n{done.stderr[-2000:]}")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, done.stdout


def shown(name, seconds, base=None, base_name=""):
    """A line with median and ratio."""
    ratio = f"  {base_name} takes {ratio_of(base, seconds)} times as long" if base is not None else ""
    print(f"  {name:44s} {np.median(seconds):8.3f} s{ratio}", flush=True)


def steps(builds, rounds, folder):
    """Steps of cat215b with exact circuits: ten minutes of a random operator in one run, and 256 tasks in lanes."""
    found, totals = {b.name: [] for b in builds}, set()
    for _ in range(rounds):
        for build in builds:
            runs = json.loads(build("-c", _STEPS)[1])
            found[build.name].append([took for took, _ in runs])
            totals.add((build.name, *(total for _, total in runs)))
    print("\nsteps of cat215b, exact circuits: medians of 15 runs in a process, processor time")
    for build in builds:
        times = np.array(found[build.name]).T
        old = [None, None] if build is builds[-1] else np.array(found[builds[-1].name]).T
        for what, mine, other in zip(("120,000 single steps, recorded", "256 tasks in lanes"), times, old, strict=True):
            shown(f"{build.name}: {what}", mine, other, builds[-1].name)
    assert len(totals) == len(builds)  # the same in each of its runs


def verify(builds, rounds, folder):
    """`verify` of the package's model with the most regions, and its exported C."""
    model = max(shipped_models(), key=lambda m: len(m.networks))
    save_models([model], folder / "swing.json")
    seconds, found = {b.name: [] for b in builds}, {}
    for _ in range(rounds):
        for build in builds:
            took, printed = build("-c", _VERIFY, folder / "swing.json", folder / f"c_{build.name}")
            seconds[build.name].append(took)
            found[build.name] = json.loads(printed)
    print(
        f"\nverify of {model.output.name}, {len(model.networks)} regions, 3000 points: processor time with all children"
    )
    for build in builds:
        old = seconds[builds[-1].name] if build is not builds[-1] else None
        shown(build.name, seconds[build.name], old, builds[-1].name)
        size, targets, _ = found[build.name]
        held = [name for name, (_, holds) in targets.items() if holds]
        print(f"    exported C {size / 1e6:.3f} MB; {len(held)} of {len(targets)} targets agree")
    if len(builds) > 1:
        print(
            f"    C of {builds[0].name} / {builds[-1].name}: {found[builds[0].name][0] / found[builds[-1].name][0]:.3f}"
        )
        exact = [{k: v for k, v in found[b.name][1].items() if "double" in k or "fmi" in k} for b in builds]
        assert all(one[k][1] and other[k][1] for one, other in [exact] for k in one)


def kept(builds, rounds, folder):
    """Batches that keep all rows of all columns, against those that keep none; the system's time is that of giving fresh memory."""
    print("\nsimulate_batch, 256 machines, task, one thread: keeping all rows / keeping none")
    for build in builds:
        times, steps = json.loads(build("-c", _KEPT)[1])
        for k, what in enumerate(("the program alone", "with the system")):
            none, rows = np.array(times)[:, :, k].T
            ns = [1e9 * float(np.median(part)) / steps for part in (none, rows)]
            text = f"{ratio_of(rows, none)}; {ns[0]:.0f} and {ns[1]:.0f} ns a step of a machine"
            print(f"  {build.name}, {what:18s} {text}", flush=True)


def start(builds, rounds, folder):
    """A warm `simulate` against what numba alone takes to be imported; `--help` against an empty program."""
    run = "import sys; from polydraulic.cli import main; sys.argv = ['polydraulic', {}]; main()"
    programs = {
        "simulate task --out": run.format("'simulate', 'task', '--out', 'task.parquet'"),
        "import numba": "import numba",
        "--help": run.format("'--help'"),
        "pass": "pass",
    }
    print("\nstart-up: processor time, warm caches")
    found = {}
    for build in builds:
        for _ in range(2):
            for program in programs.values():
                build("-c", program)
        found[build.name] = {name: [] for name in programs}
    for _ in range(rounds):
        for build in builds:
            for name, program in programs.items():
                found[build.name][name].append(build("-c", program)[0])
    for build in builds:
        times = found[build.name]
        for name in programs:
            shown(f"{build.name}: {name}", times[name])
        print(f"    simulate / import numba {ratio_of(times['simulate task --out'], times['import numba'])}")
        print(f"    --help / pass {ratio_of(times['--help'], times['pass'])}")
    if len(builds) > 1:
        one, other = (found[b.name]["--help"] for b in (builds[0], builds[-1]))
        print(f"    --help of {builds[0].name} / {builds[-1].name}: {ratio_of(one, other)}")


def compilation(builds, rounds, folder):
    """The first run with an empty cache, less one with a warm one."""
    print("\nfirst compilation: processor time of the first run less that of a warm one")
    for flow in ("exact", "polynomial"):
        found = {b.name: [] for b in builds}
        for k in range(rounds):
            for build in builds:
                home = folder / f"cold_{build.name}_{flow}_{k}"
                home.mkdir()
                cold, warm = (build("-c", _COMPILE, flow, XDG_CACHE_HOME=str(home))[0] for _ in range(2))
                found[build.name].append(cold - warm)
        for build in builds:
            shown(f"{build.name}: {flow}", found[build.name])
        if len(builds) > 1:
            print(
                f"    {flow}: {builds[0].name} / {builds[-1].name} {ratio_of(found[builds[0].name], found[builds[-1].name])}"
            )


PARTS = {"steps": steps, "verify": verify, "kept": kept, "start": start, "compile": compilation}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", choices=[*PARTS, []], help="all if there is none")
    parser.add_argument("--old", type=Path, help="checkout of an earlier commit, with its environment in .venv")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        builds = [Build("now", sys.executable, HERE.parent / "src", folder)]
        if asked.old:
            builds.append(Build("old", asked.old.resolve() / ".venv/bin/python", asked.old.resolve() / "src", folder))
        for build in builds:
            (folder / build.name).mkdir()
        for name in asked.parts or PARTS:
            PARTS[name](builds, asked.rounds, folder)


if __name__ == "__main__":
    main()
