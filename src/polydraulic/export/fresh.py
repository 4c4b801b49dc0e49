"""Exported files in processes of their own, as a user's program would use them: what they answer at given points.

In this process a name that hides another one could go unseen; in a new interpreter, or in a C program with the usual headers, it shows.
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.build import compile_program, find_compiler
from polydraulic.export.c.run import Run, RunTrial, run_texts
from polydraulic.export.c.source import to_c
from polydraulic.export.c.text import DOUBLE
from polydraulic.export.fmu.networks import export_fmu
from polydraulic.export.model_bundle import Bundle
from polydraulic.export.onnx.model import export_onnx
from polydraulic.export.targets import export_models


class Answers(NamedTuple):
    """Outputs (n, n_output), Jacobians (n, n_output, n_input), distance outside (n,)."""

    y: np.ndarray
    slopes: np.ndarray | None = None
    outside: np.ndarray | None = None


class NotHereError(Exception):
    """What a target needs is not here."""


class FailedError(Exception):
    """A target was written and does not run."""


def run_python(whole: Bundle, folder: Path, X: np.ndarray) -> Answers:
    """The functions of the exported module in a new interpreter."""
    written = export_models(whole.models, "python", folder, name=whole.name).main
    return _interpreted(
        folder, {"kind": "python", "module": written.stem, "names": whole.identifiers()[1], "places": whole.places}, X
    )


def run_c(whole: Bundle, folder: Path, real: str, prove: bool, X: np.ndarray) -> Answers:
    """The exported source in a C program that includes its header beside those of the library."""
    command = _compiler()
    try:
        header, source = to_c(whole, real=real, prove=prove)
    except InputError as error:
        raise NotHereError(str(error)) from error
    n, m = len(whole.inputs), len(whole.models)
    main = Template(files(__package__).joinpath("templates", "fresh.c.txt").read_text(encoding="utf-8"))
    text = {f"{whole.name}.h": header, f"{whole.name}.c": source}
    text["own_main.c"] = main.substitute(name=whole.name, real=real, n=n, m=m)
    program, points, answers = (folder / f"own_{what}_{real}" for what in ("program", "points", "answers"))
    try:
        compile_program(command, text, [f"{whole.name}.c", "own_main.c"], program)
    except InputError as error:
        raise FailedError(str(error)) from error
    np.ascontiguousarray(X, dtype=np.float64).tofile(points)
    _run([str(program), str(points), str(answers)], folder)
    rows = np.fromfile(answers).reshape(len(X), m + n * m + 1)
    return Answers(rows[:, :m], rows[:, m:-1].reshape(len(X), m, n), rows[:, -1])


def run_fmu(whole: Bundle, folder: Path, version: int, kind: str, X: np.ndarray) -> Answers:
    """The exported FMU through FMPy in a new interpreter."""
    place, n, m = _unpacked(whole, folder, version), len(whole.inputs), len(whole.models)
    job = {"kind": "fmu", "place": place, "version": version, "fmi_type": kind, "n_inputs": n, "n_outputs": m}
    return _interpreted(folder, job, X)


def run_c_rows(whole: Bundle, run: Run, folder: Path, trial: RunTrial) -> Answers:
    """The exported run in a C program, through rows that are measured and on by itself."""
    command, name = _compiler(), whole.name
    header, source = to_c(whole)
    text = {f"{name}.h": header, f"{name}.c": source, **run_texts(whole, run, DOUBLE)}
    main = Template(files(__package__).joinpath("templates", "fresh_run.c.txt").read_text(encoding="utf-8"))
    n, m = len(run.inputs), len(run.outputs)
    text["own_main.c"] = main.substitute(name=name, n=n, m=m, measured=trial.measured, inputs="own_row, " if n else "")
    program, rows, answers = (folder / f"own_{what}_run" for what in ("program", "points", "answers"))
    try:
        compile_program(command, text, [f"{name}.c", f"{name}_run.c", "own_main.c"], program)
    except InputError as error:
        raise FailedError(str(error)) from error
    np.ascontiguousarray(trial.signals).tofile(rows)
    _run([str(program), str(rows), str(answers)], folder)
    return Answers(np.fromfile(answers).reshape(-1, m))


def run_fmu_rows(whole: Bundle, run: Run, folder: Path, version: int, trial: RunTrial) -> Answers:
    """The exported FMU of a run through FMPy in a new interpreter, a row a step."""
    place, n, m = _unpacked(whole, folder, version), len(run.inputs), len(run.outputs)
    job = {"kind": "fmu_rows", "place": place, "version": version, "n_signals": n + m, "n_outputs": m}
    return _interpreted(folder, {**job, "raster": run.raster, "measured": trial.measured}, trial.signals)


def run_onnx(whole: Bundle, folder: Path, real: str, X: np.ndarray) -> Answers:
    """The exported graph through ONNX Runtime in a new interpreter."""
    _need("onnx")
    _need("onnxruntime")
    path = export_onnx(whole.models, folder / f"own_{real}.onnx", name=whole.name, real=real).main
    return _interpreted(folder, {"kind": "onnx", "place": str(path), "real": real}, X)


def _unpacked(whole: Bundle, folder: Path, version: int) -> str:
    """Folder of the exported FMU."""
    _need("fmpy")
    _compiler()
    import fmpy

    place = folder / f"own_fmi{version}"
    if not place.exists():
        try:
            path = export_fmu(whole.models, folder / f"own_fmi{version}.fmu", version=version, name=whole.name).main
        except InputError as error:
            raise FailedError(str(error)) from error
        fmpy.extract(str(path), unzipdir=str(place))
    return str(place)


def _need(package: str) -> None:
    if find_spec(package) is None:
        raise NotHereError(f'needs {package}: pip install "polydraulic[verify]"')


def _compiler() -> list[str]:
    command = find_compiler()
    if command is None:
        raise NotHereError("no C compiler is installed")
    return command


def _interpreted(folder: Path, job: dict[str, Any], X: np.ndarray) -> Answers:
    """Answers of `fresh_script`, which stands in the folder of the exported file."""
    script, points, answers = (folder / f"own_{name}" for name in ("script.py", "points.json", "answers.json"))
    script.write_text(files(__package__).joinpath("fresh_script.py").read_text(encoding="utf-8"), encoding="utf-8")
    points.write_text(json.dumps({**job, "X": X.tolist()}), encoding="utf-8")
    answers.unlink(missing_ok=True)
    _run([sys.executable, str(script), str(points), str(answers)], folder)
    found = json.loads(answers.read_text(encoding="utf-8"))
    return Answers(**{name: np.array(values, dtype=np.float64) for name, values in found.items()})


def _run(command: Sequence[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        said = done.stderr.strip().splitlines()
        raise FailedError(said[-1] if said else f"ended with code {done.returncode}")
