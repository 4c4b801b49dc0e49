"""Try an installed package: simulate, fit, prove, export C, from an empty folder. Run by `make build`, in a fresh environment."""

import subprocess
import sys
import tempfile
from importlib.metadata import files, version
from importlib.resources import files as data
from pathlib import Path

import polydraulic
from polydraulic import load_machine, load_scenario, simulate

HOME = Path(polydraulic.__file__).parent
assert HOME.is_relative_to(sys.prefix), f"{HOME} is not in the environment {sys.prefix}"
assert polydraulic.__version__ == version("polydraulic"), "the metadata give another version"

installed = {str(path) for path in files("polydraulic") or ()}
NEEDED = [
    "py.typed", "__init__.pyi", "parameters/sets/cat215b.toml", "parameters/scenarios/task.toml", "flow/trained/cascade.json",
    "export/fmu/sources/fmu.h", "export/fmu/sources/LICENSE-FMI.txt", "measure/bench/example_sensors.toml", "pages/page.css",
    "plotting/templates/animation.html", "thesis/report/thesis.toml",
]  # fmt: skip
for name in NEEDED:
    assert f"polydraulic/{name}" in installed, f"the distribution lacks {name}"
    assert (data("polydraulic") / name).is_file(), name

run = simulate(load_machine("cat215b"), "polynomial", load_scenario("single_08"), t_end=0.5)
assert run.info["steps_out_of_domain"] == 0

COMMAND = Path(sys.executable).with_name("polydraulic")
with tempfile.TemporaryDirectory() as folder:
    for line in (
        "sample --circuit boom --rows 400 --out boom.csv",
        "fit boom.csv --inputs boom.travel,boom.p_in --outputs boom.q_in --layers 2 --bounds 0,0.0028104 --out q_in.json --card q_in.html",
        "check q_in.json --range 0,0.0029",
        "export q_in.json --to c --out c",
    ):
        subprocess.run([COMMAND, *line.split()], cwd=folder, check=True)
    made = sorted(str(path.relative_to(folder)) for path in Path(folder).rglob("*") if path.is_file())
    assert made == ["boom.csv", "c/boom_q_in.c", "c/boom_q_in.h", "q_in.card.json", "q_in.html", "q_in.json"], made
print(f"polydraulic {version('polydraulic')} works in {sys.prefix}")
