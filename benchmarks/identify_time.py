"""How long `identify` takes for 25 minutes of a log, next to `fit-machine` of an earlier commit on the same rows.

``python benchmarks/identify_time.py [--old FOLDER] [--rounds N] [--caches FOLDER]``: processor time of whole commands with all their
children, which neighbours do not add to; rounds are interleaved, and a ratio is the median of those within a round. `--old` is a
checkout of an earlier commit with an environment of its own in ``.venv``. The log has every sensor of all functions of cat215b at 20 ms, noise as `record --example` has it, of an operator who drives
spools to their ends. Both commands run once before on its first minutes, so that nothing is compiled; not where ``--caches FOLDER`` names what
such a run has compiled before.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from identify import recorded
from polydraulic import load_machine, write_table
from polydraulic.identification.equations.identified_file import file_text, machine_data
from polydraulic.parameters.layout.adapt import full_stroke
from polydraulic.tables import Table
from polydraulic.thesis.rough_machine import rough_machine
from polydraulic.thesis.timing import ratio_of
from waits import HERE, Build, shown

SECONDS, FIRST = 1500.0, 12000  # of the log, and rows of it to warm up with
_COMMAND = "import sys; from polydraulic.cli import main; sys.argv = ['polydraulic', *sys.argv[1:]]; main()"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--old", type=Path, help="checkout of an earlier commit, with its environment in .venv")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seed", type=int, default=6007, help="of the operator who is recorded")
    parser.add_argument("--caches", type=Path, help="folder with `now` and `old`, of compiled functions")
    asked = parser.parse_args()
    machine = load_machine("cat215b")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        log = recorded(machine, folder, asked.seed, SECONDS, full_stroke(machine))
        few = {name: values[:FIRST] for name, values in log.columns.items()}
        write_table(log, folder / "log.parquet")
        write_table(Table(few, log.units, log.info), folder / "few.parquet")
        rough = rough_machine(machine, np.random.default_rng(asked.seed))
        (folder / "rough.toml").write_text(file_text(machine_data(rough), {}, []))
        print(f"\n{len(log)} rows of {len(machine.names)} functions", flush=True)
        home = asked.caches.resolve() if asked.caches else folder
        builds = {"identify": Build("now", sys.executable, HERE.parent / "src", home)}
        words = {"identify": ["identify", "{}", "--machine", folder / "rough.toml", "--out", folder / "found.toml"]}
        if asked.old:
            old = asked.old.resolve()
            builds["fit-machine"] = Build("old", old / ".venv/bin/python", old / "src", home)
            words["fit-machine"] = ["fit-machine", "{}", "--out", folder / "machine.json"]
        seconds = {name: [] for name in builds}
        for rows in (*([] if asked.caches else ["few"]), *["log"] * asked.rounds):
            for name, build in builds.items():
                (home / build.name).mkdir(parents=True, exist_ok=True)
                took, _ = build("-c", _COMMAND, *(folder / f"{rows}.parquet" if w == "{}" else w for w in words[name]))
                print(f"  {rows}, {name}: {took:.1f} s", file=sys.stderr, flush=True)
                if rows == "log":
                    seconds[name].append(took)
        for name, took in seconds.items():
            shown(f"{builds[name].name}: {name}", took)
        if asked.old:
            print(f"    fit-machine / identify {ratio_of(seconds['fit-machine'], seconds['identify'])}")
        found = load_machine(folder / "found.toml")
        for circuit in machine.circuits:
            off = found.circuit(circuit.name).pump.flow / circuit.pump.flow - 1.0
            assert abs(off) < 0.01, f"pump of {circuit.name} off by {off:.2%}"


if __name__ == "__main__":
    main()
