"""What a user waits for when a log is read: CSV and MDF 4 to tables, and the whole command, next to what reads the same files elsewhere.

``python benchmarks/importing.py [--rounds N] [--size MB] [--old PYTHON]``. Each call is a process of its own, so that its peak memory can be told, and
processes of one kind take turns; ratios are those of one round, their medians with quartiles. Times begin when libraries are imported; those of
the command and what it is compared with are of whole processes. Elapsed times are what a user waits for, those of the processor hold
on a busy machine. All values of every channel are summed, and the sums of all who read a file must agree. `--old` adds the same with the polydraulic of another environment.

The log is made here: an excavator's levers, pressures, flows and angles at 100 Hz, half of the MDF file scaled whole numbers.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter, process_time

import numpy as np

RASTER = 0.01  # s
LEVERS, PRESSURES, FLOWS, ANGLES = 4, 9, 4, 4
DEADBAND = 15.0  # %
SCALE = 0.01  # of the whole numbers of the MDF file
SMALL = 16  # MB, of the MDF file


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=float, default=100.0, help="of the CSV file, MB")
    parser.add_argument("--old", type=Path, help="interpreter of an environment with another polydraulic")
    parser.add_argument("--one", nargs="*", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(CALLS[given.one[0]](*given.one[1:])))
        return
    builds = {"": Path(sys.executable)} | ({"old: " if given.old else "": given.old} if given.old else {})
    with TemporaryDirectory() as place:
        folder = Path(place)
        text, mdf, channels = folder / "log.csv", folder / "log.mf4", folder / "map.toml"
        run(builds[""], "write", text, mdf, channels, 1e6 * given.size)
        print(
            f"{text.name}: {text.stat().st_size / 1e6:.0f} MB, {mdf.name}: {mdf.stat().st_size / 1e6:.0f} MB, {len(names())} channels"
        )
        compare("CSV", given.rounds, "pyarrow's streaming reader", {
            "pyarrow's streaming reader": (builds[""], "arrow", text),
            **{f"{of}import_log": (python, "import", text, channels, folder / "out.parquet") for of, python in builds.items()},
        })  # fmt: skip
        compare("MDF 4", given.rounds, "asammdf, select", {
            "asammdf, select": (builds[""], "asammdf", mdf),
            "asammdf, get of each channel": (builds[""], "asammdf-get", mdf),
            **{f"{of}read": (python, "read", mdf) for of, python in builds.items()},
            **{f"{of}import_log": (python, "import", mdf, channels, folder / "out.parquet") for of, python in builds.items()},
        })  # fmt: skip
        for of, python in builds.items():
            compare(f"{of}`import` of the MDF file with its quality page, whole processes", given.rounds, "import_log alone", {
                "import_log alone": (python, "import", mdf, channels, folder / "out.parquet", "whole"),
                "command": (python, None, mdf, channels, folder / "out.parquet"),
            })  # fmt: skip


def compare(title, rounds, base, calls):
    """Run calls in turn, and print medians, ratios and peaks of memory."""
    found = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            found[name].append(run(*call))
    sums = [one["sum"] for runs in found.values() for one in runs if "sum" in one]
    assert np.allclose(sums, sums[:1], rtol=1e-9), sums
    width = max(30, *map(len, calls))
    print(f"\n{title}: {rounds} rounds")
    print(
        f"  {'':{width}s} {'elapsed':>9s}  {'ratio (quartiles)':24s} {'of CPU':>9s}  {'ratio (quartiles)':24s} {'peak':>8s}"
    )
    for name, runs in found.items():
        line = f"  {name:{width}s}"
        for key in ("seconds", "cpu"):
            ratios = [one[key] / other[key] for one, other in zip(runs, found[base], strict=True)]
            low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75))
            ratio = "1" if name == base else f"{middle:.3g} ({low:.3g} to {high:.3g})"
            line += f" {median(one[key] for one in runs):7.2f} s  {ratio:24s}"
        print(f"{line} {max(one['peak'] for one in runs):5.0f} MB", flush=True)


def run(python, what, *arguments):
    """One call in a process of its own; `what` is None for the whole command."""
    if what is not None:
        command = [python, __file__, "--one", what, *arguments]
    else:
        log, channels, out = arguments
        main_ = "import sys; from polydraulic.cli import main; sys.exit(main())"
        command = [python, "-c", main_, "import", log, "--channels", channels, "--out", out]
    own = python == Path(sys.executable)  # another environment has a polydraulic of its own
    settings = {key: value for key, value in os.environ.items() if own or key != "PYTHONPATH"}
    began = perf_counter()
    with subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, text=True, env=settings) as process:
        said = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, said
    whole = {
        "seconds": perf_counter() - began,
        "cpu": used.ru_utime + used.ru_stime,
        "peak": used.ru_maxrss / 1024,
    }
    return whole | (json.loads(said.splitlines()[-1]) if what is not None else {})


def timed(call):
    """What a call computes, s of elapsed and of processor time, and the peak of memory so far, MB."""
    began, cpu = perf_counter(), process_time()
    found = call()
    times = {"seconds": perf_counter() - began, "cpu": process_time() - cpu}
    return found, times | {"peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3}


def of_arrow(path):
    """The sum of all values that pyarrow's streaming reader makes of a CSV file, on one thread."""
    import pyarrow.compute as pc
    from pyarrow import csv

    def call():
        with csv.open_csv(path, csv.ReadOptions(use_threads=False)) as reader:
            return sum(pc.sum(column).as_py() for batch in reader for column in batch.columns[1:])

    found, times = timed(call)
    return times | {"sum": found}


def of_asammdf(path, each=False):
    """The sum of all values of an MDF file by asammdf: all channels at once, which is its quickest way, or one by one."""
    from asammdf import MDF

    def call():
        with MDF(path) as file:
            signals = (file.get(name) for name in names()) if each else file.select(names())
            return sum(float(signal.samples.sum()) for signal in signals)

    found, times = timed(call)
    return times | {"sum": found}


def of_read(path):
    """The sum of all values that a log of ours gives, block by block."""
    from polydraulic.measure import open_log
    from polydraulic.measure.findings import Findings

    with open_log(path):  # what the format needs is imported
        pass

    def call():
        with open_log(path) as log:
            blocks = log.read(log.signals[0].group, names(), None, Findings())
            return sum(float(values.sum()) for block in blocks for values in block.values.values())

    found, times = timed(call)
    return times | {"sum": found}


def of_import(path, channels, out, whole=""):
    """From a log to a table; the sum of its values in the units of the log is taken after that, unless the whole process counts."""
    from polydraulic.measure import import_log, load_channels, open_log
    from polydraulic.tables import read_table

    given = load_channels(channels)
    if whole:
        import_log(Path(path), given, Path(out))
        return {}
    with open_log(path):  # what the format needs is imported
        pass
    imported, times = timed(lambda: import_log(Path(path), given, Path(out)))
    assert imported.n_row > 0
    table = read_table(out)
    factors = {"%": 0.01, "bar": 1e5, "l/min": 1e-3 / 60.0, "deg": np.pi / 180.0}
    return times | {"sum": sum(float(table[name].sum()) / factors[unit] for name, unit in units().items())}


def write(text, mdf, channels, size):
    """Write the logs and their map."""
    write_csv(Path(text), float(size))
    write_mdf(Path(mdf), 1e6 * SMALL)
    write_map(Path(channels))
    return {}


CALLS = {
    "arrow": of_arrow,
    "asammdf": of_asammdf,
    "asammdf-get": lambda path: of_asammdf(path, each=True),
    "read": of_read,
    "import": of_import,
    "write": write,
}


def units():
    """Units of the channels by name."""
    kinds = (("lever", LEVERS, "%"), ("p", PRESSURES, "bar"), ("q", FLOWS, "l/min"), ("angle", ANGLES, "deg"))
    return {f"{name}_{n}": unit for name, count, unit in kinds for n in range(count)}


def names():
    """Names of the channels."""
    return list(units())


def log_of(n_row, seed=0):
    """Channels of a log: levers that wander, flows that follow them beyond a deadband, angles, pressures."""
    from scipy.signal import lfilter

    rng = np.random.default_rng(seed)
    keep = np.exp(-RASTER / 1.5)
    columns = []
    levers = [
        np.clip(lfilter([1.0 - keep], [1.0, -keep], rng.normal(0.0, 500.0, n_row)), -100.0, 100.0)
        for _ in range(LEVERS)
    ]
    columns += levers
    columns += [
        120.0 + 40.0 * lfilter([0.02], [1.0, -0.98], rng.normal(0.0, 8.0, n_row)) + rng.normal(0.0, 0.3, n_row)
        for _ in range(PRESSURES)
    ]
    lag = np.exp(-RASTER / 0.06)
    for lever in levers[:FLOWS]:
        beyond = np.sign(lever) * np.maximum(np.abs(lever) - DEADBAND, 0.0)
        columns.append(lfilter([1.0 - lag], [1.0, -lag], 2.0 * np.roll(beyond, 8)) + rng.normal(0.0, 0.5, n_row))
    for n in range(ANGLES):
        turned = np.cumsum(columns[LEVERS + PRESSURES + n]) * RASTER / 60.0
        columns.append(60.0 * np.sin(turned) + rng.normal(0.0, 0.02, n_row))
    return [np.round(column, 2) for column in columns]


def write_csv(path, size):
    """Write a log as text of about `size` bytes."""
    import pyarrow as pa
    from pyarrow import csv

    each = sum(map(len, names())) // len(names())  # about as long as a number with its comma
    n_row = int(size / (each + 1.8) / (len(names()) + 1.3))
    columns = log_of(n_row)
    time_s = np.round(np.arange(n_row) * RASTER, 2)
    csv.write_csv(pa.table([time_s, *columns], names=["time", *names()]), path)


def write_mdf(path, size):
    """Write a log as MDF 4; every other channel is of whole numbers with a scaling."""
    from asammdf import MDF, Signal
    from asammdf.blocks.conversion_utils import from_dict

    n_row = int(size / (8 + 2 * ((len(names()) + 1) // 2) + 8 * (len(names()) // 2)))
    time_s = np.arange(n_row) * RASTER
    signals = []
    for n, ((name, unit), values) in enumerate(zip(units().items(), log_of(n_row), strict=True)):
        if n % 2:
            signals.append(Signal(values, time_s, unit, name))
        else:
            whole = np.round(values / SCALE).astype(np.int16)
            signals.append(Signal(whole, time_s, unit, name, conversion=from_dict({"a": SCALE, "b": 0.0})))
    with MDF(version="4.10") as file:
        file.append(signals)
        file.save(path, overwrite=True)


def write_map(path):
    """Write the channel map: levers and pressures are inputs, flows and angles outputs."""
    text = f'raster = "{1e3 * RASTER:g} ms"\n[[channel]]\nsource = "time"\nrole = "time"\nunit = "s"\n'
    for name, unit in units().items():
        role = "output" if name.startswith(("q", "angle")) else "input"
        text += f'[[channel]]\nsource = "{name}"\nrole = "{role}"\nunit = "{unit}"\n'
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
