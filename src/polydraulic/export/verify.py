"""The same points through every target that can be built here, and the largest differences from the package."""

import ctypes
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.build import compile_library, find_compiler
from polydraulic.export.c.source import to_c
from polydraulic.export.fmu.networks import export_fmu
from polydraulic.export.formula import to_python
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.export.onnx import to_onnx
from polydraulic.files import Scratch
from polydraulic.networks.model.model import Model
from polydraulic.progress import Progress, quiet

ROUNDING = 1e-9  # of an output's size: what double precision may differ by


class Agreement(NamedTuple):
    """How far one target is from the package for one output.

    Attributes
    ----------
    target : str
    output : str
        Name and unit.
    inside, border, outside : float
        Largest difference in the output's unit, by where the points lie; infinite if it gives no number.
    slopes : float or None
        Largest difference of a slope, as a share of the largest slope by that input, in single precision away from borders;
        None if the target has none.
    domain : int or None
        Points at which it disagrees on whether the inputs are in the domain; None if it does not say.
    size : float
        Largest magnitude of the output.
    exact : bool
        Whether the target computes in double precision.
    """

    target: str
    output: str
    inside: float
    border: float
    outside: float
    slopes: float | None
    domain: int | None
    size: float
    exact: bool

    @property
    def holds(self) -> bool:
        """Whether a target of double precision agrees to rounding; that of single precision is for the reader to judge."""
        largest = max(self.inside, self.border, self.outside, (self.slopes or 0.0) * self.size)
        return not self.exact or (largest <= ROUNDING * self.size and not self.domain)


class _Answers(NamedTuple):
    """Outputs (n, n_output), Jacobians (n, n_output, n_input), distance outside (n,)."""

    y: np.ndarray
    slopes: np.ndarray | None = None
    outside: np.ndarray | None = None


def verify_models(
    models: Sequence[Model],
    *,
    n: int = 3000,
    seed: int = 0,
    progress: Progress = quiet,
) -> tuple[list[Agreement], dict[str, str]]:
    """Run the same points through the package and through every target.

    Parameters
    ----------
    models : sequence of Model
        One an output.
    n : int
        Points: two thirds inside the domain, a sixth on faces and borders of regions, a sixth around the domain.
    seed : int
        Of the points.
    progress : Progress, optional
        Told each target as it begins.

    Returns
    -------
    agreements : list of Agreement
        One a target and output.
    not_tried : dict
        Why a target could not be tried here, by its name.

    Raises
    ------
    InputError
        If the models do not go together, or there are fewer than 6 points.
    """
    if n < 6:
        raise InputError(f"n = {n}: verifying needs at least 6 points")
    whole = bundle(models)
    found: list[Agreement] = []
    not_tried = {"sympy, latex": "formulas to read; they follow the networks inside the domain only"}
    double, single = (_expected(whole, n, seed, dtype) for dtype in (np.float64, np.float32))
    with Scratch() as scratch:
        targets = list(_targets(whole, scratch.folder))
        for done, (target, exact, run) in enumerate(targets):
            progress(target, done, len(targets))
            X, expected = double if exact else single
            try:
                answers = run(X)
            except _NotHereError as reason:
                not_tried[target] = str(reason)
                continue
            found += _compared(whole, target, exact, expected, answers)
    return found, not_tried


def agreement_table(found: Sequence[Agreement], not_tried: dict[str, str]) -> str:
    """`verify_models` as text.

    Parameters
    ----------
    found : sequence of Agreement
    not_tried : dict
    """
    names = [f"{a.target}: {a.output}" for a in found]
    width = max((len(name) for name in names), default=0)
    titles = ("inside", "on borders", "outside", "slopes", "domain")
    lines = ["largest differences from the package, in units of the output; slopes as a share of the largest one"]
    lines.append(f"{'':{width}s}" + "".join(f"{title:>12s}" for title in titles))
    for name, a in zip(names, found, strict=True):
        slopes = "-" if a.slopes is None else f"{a.slopes:.2g}"
        domain = "-" if a.domain is None else "agrees" if a.domain == 0 else f"{a.domain} differ"
        numbers = "".join(f"{value:12.2g}" for value in (a.inside, a.border, a.outside))
        lines.append(f"{name:{width}s}{numbers}{slopes:>12s}{domain:>12s}{'' if a.holds else '  DIFFERS'}")
    if any(not a.exact for a in found):
        lines.append("single precision rounds borders too: next to one it may answer for the other side")
    lines += [f"not tried: {target}: {why}" for target, why in not_tried.items()]
    return "\n".join(lines)


class _Expected(NamedTuple):
    """The same from the package."""

    y: np.ndarray
    slopes: np.ndarray
    outside: np.ndarray


class _NotHereError(Exception):
    """What a target needs is not here."""


def _expected(whole: Bundle, n: int, seed: int, dtype: Any) -> tuple[np.ndarray, _Expected]:
    X = whole.points(n, seed).astype(dtype).astype(np.float64)
    return X, _Expected(whole.predict(X), whole.slopes(X), whole.outside(X))


def _compared(whole: Bundle, target: str, exact: bool, expected: _Expected, found: _Answers) -> Iterator[Agreement]:
    n, size = len(expected.y), np.abs(expected.y).max(axis=0)
    difference = np.abs(found.y - expected.y)
    difference[np.isnan(difference)] = np.inf
    parts = [difference[start:end].max(axis=0) for start, end in (
        (0, 2 * n // 3), (2 * n // 3, 5 * n // 6), (5 * n // 6, n))]  # fmt: skip
    domain = None
    if found.outside is not None:
        domain = int(np.sum((found.outside > 0.0) != (expected.outside > 0.0)))
    for k, output in enumerate(whole.outputs):
        slopes = None
        if found.slopes is not None:
            rows = slice(None) if exact else slice(2 * n // 3)  # slopes jump at borders
            scale = np.abs(expected.slopes[:, k]).max(axis=0)
            off = np.abs(found.slopes[rows, k] - expected.slopes[rows, k]) / np.where(scale > 0.0, scale, 1.0)
            slopes = float(np.where(np.isnan(off), np.inf, off).max())
        inside, border, outside = (float(part[k]) for part in parts)
        yield Agreement(target, str(output), inside, border, outside, slopes, domain, float(size[k]) or 1.0, exact)


def _targets(whole: Bundle, folder: Path) -> Iterator[tuple[str, bool, Callable[[np.ndarray], _Answers]]]:
    """Name, whether it is in double precision, and what runs it."""
    yield "python", True, partial(_python, whole)
    for real in ("double", "float"):
        yield f"c {real}", real == "double", partial(_c, whole, folder, real)
    for version in (2, 3):
        for kind, short in (("ModelExchange", "me"), ("CoSimulation", "cs")):
            yield f"fmi{version} {short}", True, partial(_fmu, whole, folder, version, kind)
    for real in ("double", "float"):
        yield f"onnx {real}", real == "double", partial(_onnx, whole, real)


def _python(whole: Bundle, X: np.ndarray) -> _Answers:
    columns = []
    for model, place in zip(whole.models, whole.places, strict=True):
        names: dict[str, Any] = {}
        exec(to_python(model, "f"), names)
        columns.append([names["f"](*row) for row in X[:, list(place)].tolist()])
    return _Answers(np.array(columns).T)


def _compiler() -> list[str]:
    command = find_compiler()
    if command is None:
        raise _NotHereError("no C compiler is installed")
    return command


def _c(whole: Bundle, folder: Path, real: str, X: np.ndarray) -> _Answers:
    command = _compiler()
    try:
        header, source = to_c(whole, real=real)
    except InputError as error:
        raise _NotHereError(str(error)) from error
    path = folder / f"{whole.name}_{real}"
    path.write_bytes(
        compile_library(command, {f"{whole.name}.h": header, f"{whole.name}.c": source}, [f"{whole.name}.c"])
    )
    library, dtype = ctypes.CDLL(str(path)), np.float64 if real == "double" else np.float32
    slopes, outside = (getattr(library, whole.name + end) for end in ("_slopes", "_outside"))
    outside.restype = ctypes.c_double if real == "double" else ctypes.c_float
    m, size = len(whole.models), len(whole.inputs)
    x, scratch = np.ascontiguousarray(X, dtype=dtype), np.empty(size, dtype=dtype)
    y, dy, far = np.empty((len(X), m), dtype=dtype), np.empty((len(X), m, size), dtype=dtype), np.empty(len(X))
    for i in range(len(X)):
        row, out, partials = (array[i].ctypes.data_as(ctypes.c_void_p) for array in (x, y, dy))
        slopes(row, out, partials)
        far[i] = outside(row, scratch.ctypes.data_as(ctypes.c_void_p))
    return _Answers(y.astype(np.float64), dy.astype(np.float64), far)


def _fmu(whole: Bundle, folder: Path, version: int, kind: str, X: np.ndarray) -> _Answers:
    if find_spec("fmpy") is None:
        raise _NotHereError("needs fmpy: pip install fmpy")
    _compiler()
    import fmpy

    place = folder / f"fmi{version}"
    if not place.exists():
        path = export_fmu(whole.models, folder / f"fmi{version}.fmu", version=version, name=whole.name).main
        fmpy.extract(str(path), unzipdir=str(place))
    fmu = fmpy.instantiate_fmu(str(place), fmpy.read_model_description(str(place)), fmi_type=kind)
    put, get = (fmu.setReal, fmu.getReal) if version == 2 else (fmu.setFloat64, fmu.getFloat64)
    if version == 2:
        fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    n, m = len(whole.inputs), len(whole.models)
    inputs, outputs = list(range(n)), list(range(n, n + m))
    values, partials = np.empty((len(X), m + 1)), np.empty((len(X), m, n))
    seeds = np.eye(n).tolist()
    for k, row in enumerate(X.tolist()):
        put(inputs, row)
        if kind == "CoSimulation":
            fmu.doStep(currentCommunicationPoint=float(k), communicationStepSize=1.0)
        values[k] = get([*outputs, n + m])
        partials[k] = np.transpose([fmu.getDirectionalDerivative(outputs, inputs, seed) for seed in seeds])
    fmu.terminate()
    fmu.freeInstance()
    return _Answers(values[:, :m], partials, values[:, m])


def _onnx(whole: Bundle, real: str, X: np.ndarray) -> _Answers:
    for needed in ("onnx", "onnxruntime"):
        if find_spec(needed) is None:
            raise _NotHereError(f"needs {needed}: pip install {needed}")
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 3  # errors only
    content = to_onnx(whole, real=real).SerializeToString()
    session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    y, far = session.run(["y", "domain"], {"x": X.astype(np.float64 if real == "double" else np.float32)})
    return _Answers(y.astype(np.float64), None, far[:, 0])
