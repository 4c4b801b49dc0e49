"""Readers given hostile files, each in a child process with limits: ``python -m helpers.fuzz READER FIRST LAST`` from ``tests``.

It prints a line of JSON for each input: its number, and what came of it. The same number gives the same input.
"""

import json
import os
import random
import resource
import signal
import sys
import tempfile
import traceback
import warnings
from contextlib import suppress
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

import numpy as np

from helpers.can_made import DBC, LONG, LONG_GROUP, bus, in_parts, long_message, write_bus
from helpers.mutations import damaged, misspelt, repacked, reshaped

TOGETHER = 16  # inputs that share a child process; if it dies, each of the rest gets its own
SECONDS = 10  # of one processor, for one child
MEMORY = 1 << 30  # bytes beyond what is loaded already
RESULT, REFUSED, SLOW, DIED = "result", "InputError", "too slow", "died"
MAP = """raster = "10 ms"
atmosphere = "1.013 bar"
{time}
[[channel]]
source = "x"
name = "boom.spool"
role = "input"
unit = "mm"
range = [-20, 20]

[[channel]]
source = "p"
role = "input"
unit = "bar(a)"
between = "hold"
raster = "20 ms"

[[channel]]
source = "q"
role = "output"
unit = "l/min"
"""
OWN_TIME = '[[channel]]\nsource = "time"\nrole = "time"\nunit = "s"\n'
BUS_MAP = """raster = "20 ms"
atmosphere = "1.013 bar"
""" + "".join(
    f"""[[channel]]
source = "{source}"
name = "{source}"
role = "{role}"
unit = "{unit}"
"""
    + ('kind = "share"\n' if unit == "%" else "")
    for source, role, unit in (
        ("spool", "input", "mm"),
        ("a", "input", "bar(a)"),
        ("speed", "input", "rpm"),
        ("first", "input", "bar(a)"),
        ("mode", "input", "1"),
        ("p_head", "output", "bar(a)"),
    )
)
N = 60
TIME = np.arange(N) * 0.01
SIGNALS = {"x": 10.0 * np.sin(TIME), "p": 100.0 + np.round(20.0 * np.cos(3.0 * TIME), 1), "q": 50.0 * np.sin(TIME) ** 2}


class Reader(NamedTuple):
    """What is fuzzed.

    Attributes
    ----------
    ending : str
    make : function of a path
        Writes a valid file.
    read : function of a path
    changes : tuple of functions of bytes and a generator
    """

    ending: str
    make: object
    read: object
    changes: tuple


def _log(path):
    from polydraulic.measure import import_log, load_channels, suggest_channels

    own = path.with_name("map.toml")
    own.write_text(MAP.format(time=OWN_TIME))
    suggest_channels([path])
    import_log([path], load_channels(own), path.with_name("out.parquet"))


def _bus_log(path):
    (path.parent / "bus.dbc").write_text(DBC)
    _decoded(path, path.parent / "bus.dbc")


def _database(path):
    _decoded(path.with_name("bus.blf"), path)


def _decoded(path, database):
    from polydraulic.measure import import_log, load_channels, suggest_channels

    own, long = path.with_name("map.toml"), path.with_name("long.dbc")
    own.write_text(BUS_MAP)
    long.write_text(LONG)
    suggest_channels([path], dbc=[database, long])
    import_log([path], load_channels(own), path.with_name("out.parquet"), dbc=[database, long])


def _table(path):
    from polydraulic.tables import read_table

    read_table(path)


def _log_and_table(path):
    from polydraulic import InputError

    with suppress(InputError):
        _table(path)
    _log(path)


def _model(path):
    from polydraulic.networks import load_models

    for model in load_models(path):
        model.predict(np.zeros((3, len(model.inputs))))


def _machine(path):
    from polydraulic import load_machine
    from polydraulic.simulation.layout.prepare import start_vector

    start_vector(load_machine(path))


def _scenario(path):
    from polydraulic import load_scenario

    scenario = load_scenario(path)
    scenario.voltages(np.linspace(0.0, scenario.duration, 50))


def _sensors(path):
    from polydraulic.measure.bench.sensors import load_sensors

    load_sensors(path)


def _channels(path):
    from polydraulic.measure import load_channels

    load_channels(path)


def _packaged(*names):
    def make(path):
        path.write_bytes(files("polydraulic").joinpath(*names).read_bytes())

    return make


def _make_model(path):
    from helpers.small_network import NODES
    from polydraulic.networks import Model, Network, Variable, save_models
    from polydraulic.networks.model.partition import grid

    network = Network(tuple(NODES), (0.0, 1.0), (1.0, 2.0), (-3.0, -3.0), (3.0, 4.0), 2.0, 1.0)
    one = Model((Variable("a", "m"), Variable("b", "Pa")), Variable("y", "Pa"), (network,))
    other = Model(one.inputs, Variable("z", "m3/s"), (network, network), grid({1: [0.5]}))
    save_models([one, other], path)


def _make_text(path):
    rows = np.column_stack([TIME, *SIGNALS.values()])
    path.write_text(
        "time [s],x [mm],p [bar],q [l/min]\n" + "".join(",".join(f"{v:.6g}" for v in row) + "\n" for row in rows)
    )


def _make_recording(path):
    rows = [(t, np.sin(t), np.cos(t), 0.5) for t in TIME]
    path.write_text("time,swing,boom,stick\n" + "".join(",".join(f"{v:.6g}" for v in row) + "\n" for row in rows))


def _make_parquet(path):
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {"time": TIME, **SIGNALS, "count": np.arange(N), "word": ["on", "off"] * (N // 2)}
    pq.write_table(pa.table(columns), path, compression=None)


def _make_mdf(version):
    def make(path):
        from asammdf import MDF, Signal

        with MDF(version=version) as file:
            for (name, values), unit in zip(SIGNALS.items(), ("mm", "bar", "l/min"), strict=True):
                scaled = np.round(values * 100).astype(np.int16)
                file.append([Signal(scaled, TIME, unit, name, conversion={"a": 0.01, "b": 0.0})])
            saved = file.save(path, overwrite=True)
        saved.rename(path)

    return make


def _frames():
    long = [frame for k in range(20) for frame in in_parts(0.05 * k, LONG_GROUP, long_message(k))]
    return sorted(bus(100) + long)


def _make_bus(path):
    write_bus(path, _frames())


def _make_blf(path):
    import can

    with can.BLFWriter(
        str(path), compression_level=0, max_container_size=4000
    ) as writer:  # bytes that say what they are
        for time, frame, extended, data in _frames():
            writer.on_message_received(can.Message(1.7e9 + time, frame, extended, channel=0, data=data, dlc=len(data)))


def _make_database(path):
    path.write_text(DBC)
    _make_blf(path.with_name("bus.blf"))


def _make_mat5(path):
    from scipy.io import savemat

    savemat(path, {"time": TIME[:, None], **SIGNALS, "more": {"a": np.ones((3, N)), "b": "text"}})


def _make_mat73(path):
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in {"time": TIME, **SIGNALS}.items():
            file[name] = values[None]
            file[name].attrs["MATLAB_class"] = b"double"
        file["more/a"] = np.ones((N, 3))


BYTES, TEXT = (damaged,), (misspelt, misspelt, damaged)
READERS = {
    "model file": Reader("json", _make_model, _model, (reshaped, reshaped, *TEXT)),
    "parameter set": Reader("toml", _packaged("parameters", "sets", "cat215b.toml"), _machine, TEXT),
    "scenario": Reader("toml", _packaged("parameters", "scenarios", "task.toml"), _scenario, TEXT),
    "recording": Reader("csv", _make_recording, _scenario, TEXT),
    "sensors": Reader("toml", _packaged("measure", "bench", "example_sensors.toml"), _sensors, TEXT),
    "channel map": Reader("toml", lambda path: path.write_text(MAP.format(time=OWN_TIME)), _channels, TEXT),
    "CSV": Reader("csv", _make_text, _log_and_table, TEXT),
    "Parquet": Reader("parquet", _make_parquet, _log_and_table, BYTES),
    "MDF 4": Reader("mf4", _make_mdf("4.10"), _log, BYTES),
    "MDF 3": Reader("dat", _make_mdf("3.30"), _log, BYTES),
    "MAT v5": Reader("mat", _make_mat5, _log, BYTES),
    "MAT v7.3": Reader("mat", _make_mat73, _log, BYTES),
    "BLF": Reader("blf", _make_blf, _bus_log, (damaged, damaged, repacked)),
    "ASC": Reader("asc", _make_bus, _bus_log, TEXT),
    "bus log in MDF 4": Reader("mf4", _make_bus, _bus_log, BYTES),
    "CAN database": Reader("dbc", _make_database, _database, TEXT),
}


def hostile(reader, number, content):
    """The input of a number; the valid file for -1."""
    if number < 0:
        return content
    rng = random.Random(f"{reader} {number}")
    return rng.choice(READERS[reader].changes)(content, rng)


def _child(task, told):
    """Run a task in a child process with limits, which writes what came of it to a file; the signal that ended it, or 0."""
    told.unlink(missing_ok=True)
    child = os.fork()
    if child == 0:
        try:
            quiet = os.open(os.devnull, os.O_WRONLY)
            os.dup2(quiet, 1)
            os.dup2(quiet, 2)
            used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
            signal.alarm(6 * SECONDS)  # for whatever waits
            warnings.simplefilter("ignore")
            with told.open("w") as out:
                task(out)
        finally:
            os._exit(0)
    status = os.waitpid(child, 0)[1]
    return os.WTERMSIG(status) if os.WIFSIGNALED(status) else 0


def _outcome(read, path):
    """What comes of reading a file, and what was said."""
    from polydraulic import InputError

    try:
        read(path)
    except InputError as error:
        return REFUSED, str(error)
    except BaseException:
        said = traceback.format_exc()[-3000:]
        return said.strip().splitlines()[-1], said
    return RESULT, ""


def run(reader, first, last, folder):
    """Outcomes of inputs: (number, outcome, what was said) of each; the valid file comes first, as number -1."""
    kind, place, told = READERS[reader], folder / reader.replace(" ", "-"), folder / "told.txt"
    place.mkdir()
    sound, path = place / f"sound.{kind.ending}", place / f"log.{kind.ending}"
    _child(lambda out: kind.make(sound), told)  # libraries start threads, which do not survive a fork
    content = sound.read_bytes()

    def several(numbers):
        def task(out):
            for number in numbers:
                path.write_bytes(hostile(reader, number, content))
                print(json.dumps((number, *_outcome(kind.read, path))), file=out, flush=True)

        ended = _child(task, told)
        found = [json.loads(line) for line in told.read_text().splitlines() if line.endswith("]")]
        if len(numbers) == 1 and not found:
            late = ended in (signal.SIGXCPU, signal.SIGALRM, signal.SIGKILL)
            return [(*numbers, SLOW if late else DIED, signal.Signals(ended).name if ended else "")]
        return found

    numbers = [-1, *range(first, last)]
    for begin in range(0, len(numbers), TOGETHER):
        part = numbers[begin : begin + TOGETHER]
        found = several(part)
        yield from found
        for number in part[len(found) :]:  # one of them ended the process: which one?
            yield from several([number])


def main():
    """Print a line for each input of the readers that are named, or of all."""
    os.environ["ARROW_DEFAULT_MEMORY_POOL"] = "system"  # others reserve more than the limit
    import asammdf  # noqa: F401  # loaded once, and not in every child
    import can  # noqa: F401
    import cantools  # noqa: F401
    import h5py  # noqa: F401
    import pint  # noqa: F401
    import pyarrow.csv
    import pyarrow.parquet  # noqa: F401
    import scipy.io  # noqa: F401

    import polydraulic.measure.importing
    import polydraulic.measure.suggest
    import polydraulic.networks
    import polydraulic.simulation.runs  # noqa: F401

    chosen = list(READERS) if sys.argv[1] == "all" else [sys.argv[1]]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["TMPDIR"] = tempfile.tempdir = folder
        for reader in chosen:
            for outcome in run(reader, int(sys.argv[2]), int(sys.argv[3]), Path(folder)):
                print(json.dumps((reader, *outcome)), flush=True)


if __name__ == "__main__":
    main()
