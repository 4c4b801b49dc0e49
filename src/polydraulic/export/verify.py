"""The same points through every target that can be built here, and the largest differences from the package."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.display import DEFAULT, as_shown, shown_unit, with_unit
from polydraulic.errors import InputError
from polydraulic.export.c.allowance import model_allowance
from polydraulic.export.c.network import input_limits
from polydraulic.export.c.run import Run, run_of, try_run
from polydraulic.export.c.text import FLOAT
from polydraulic.export.fresh import (
    Answers,
    FailedError,
    NotHereError,
    run_c,
    run_c_rows,
    run_fmu,
    run_fmu_rows,
    run_onnx,
    run_python,
)
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.files import Scratch
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.partition import region_of
from polydraulic.progress import Progress, quiet

ROUNDING = 1e-9  # of an output's size: what double precision may differ by
_ROWS = 500  # of a run that are answered
PROVED = 16  # networks, at most, whose allowance in single precision is proved unless asked for: hundreds take minutes


class Agreement(NamedTuple):
    """How far one target is from the package for one output.

    Attributes
    ----------
    target : str
    output : str
        Name and unit.
    inside, border, outside : float
        Largest difference in the output's unit, by where the points lie; infinite if it gives no number. Of a run, row by row, the first is
        that of its rows, and there are no others.
    slopes : float or None
        Largest difference of a slope, as a share of the largest slope by that input, in single precision away from borders;
        None if the target has none.
    domain : int or None
        Points at which it disagrees on whether the inputs are in the domain; None if it does not say.
    size : float
        Largest magnitude of the output.
    exact : bool
        Whether the target computes in double precision.
    allowance : float or None
        Proved largest difference in the domain, in the output's unit; of C in single precision alone, where it was proved.
    used : float or None
        Largest difference that was found there, as a part of it.
    unit : str
        Of the output.
    rounded : int
        Of the points at which it disagrees on the domain those on its faces, and on borders of regions.
    """

    target: str
    output: str
    inside: float
    border: float | None
    outside: float | None
    slopes: float | None
    domain: int | None
    size: float
    exact: bool
    allowance: float | None = None
    used: float | None = None
    unit: str = ""
    rounded: int = 0

    @property
    def holds(self) -> bool:
        """Whether a target of double precision agrees to rounding, and C in single precision within what is proved of it.

        Other targets of single precision are for the reader to judge.
        """
        if not self.exact:
            return self.used is None or self.used <= 1.0
        largest = max(self.inside, self.border or 0.0, self.outside or 0.0, (self.slopes or 0.0) * self.size)
        return largest <= ROUNDING * self.size and not self.domain


def verify_models(
    models: Sequence[Model],
    *,
    n: int = 3000,
    seed: int = 0,
    prove: bool | None = None,
    progress: Progress = quiet,
) -> tuple[list[Agreement], dict[str, str]]:
    """Run the same points through the package and through every target.

    Each target is written as for a user and runs in a process of its own: Python, FMUs and ONNX in a new interpreter, C in a program
    that includes the header beside those of the C library.

    Parameters
    ----------
    models : sequence of Model
        One per output.
    n : int
        Points: two thirds inside the domain, a sixth on faces and borders of regions, a sixth around the domain.
    seed : int
        Of the points.
    prove : bool, optional
        Whether C in single precision is held to what can be proved of it. If not given, models of up to 16 networks in all are: to
        prove it of hundreds takes minutes.
    progress : Progress, optional
        Told each target as it begins.

    Returns
    -------
    agreements : list of Agreement
        One per target and output.
    not_tried : dict
        Why a target could not be tried here, or fails, by its name. One that fails differs infinitely.

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
    count = sum(len(model.networks) for model in whole.models)
    prove = count <= PROVED if prove is None else prove
    if not prove:
        not_tried["proof of c float"] = f"of {count} networks it takes long: ask for it by --prove (prove=True)"
    run = run_of(whole)
    double, single = (_expected(whole, n, seed, dtype) for dtype in (np.float64, np.float32))
    with Scratch() as scratch:
        rows = [] if run is None else list(_runs(whole, run, scratch.folder))
        targets = list(_targets(whole, run, scratch.folder, prove))
        for done, (target, exact, give) in enumerate(targets):
            progress(target, done, len(targets) + len(rows))
            X, expected = double if exact else single
            answers = _tried(target, partial(give, X), expected.y, not_tried)
            if answers is not None:
                compared = _compared(whole, target, exact, expected, answers)
                found += _judged(whole, X, expected, answers, compared) if target == "c float" and prove else compared
        for done, (target, y, go) in enumerate(rows, len(targets)):
            progress(target, done, len(targets) + len(rows))
            answers = _tried(target, go, y, not_tried)
            if answers is not None:
                found += _rows_compared(whole, target, y, answers.y)
    return found, not_tried


def agreement_table(found: Sequence[Agreement], not_tried: dict[str, str], units: str = DEFAULT) -> str:
    """`verify_models` as text; its last line says whether all targets hold.

    Parameters
    ----------
    found : sequence of Agreement
    not_tried : dict
    units : str
        Of what is said: ``"metric"``, ``"field"`` or ``"si"``; what is in units of its own stays.

    Raises
    ------
    InputError
        An unknown system of units.
    """
    names = [f"{a.target}: {with_unit(_name(a), shown_unit(a.unit, units))}" for a in found]
    width = max((len(name) for name in names), default=0)
    titles = ("inside", "on borders", "outside", "slopes", "domain")
    lines = ["largest differences from the package, in units of the output; slopes as a share of the largest one"]
    lines.append(f"{'':{width}s}" + "".join(f"{title:>12s}" for title in titles))
    for name, a in zip(names, found, strict=True):
        slopes = "-" if a.slopes is None else f"{a.slopes:.2g}"
        values = (a.inside, a.border, a.outside)
        numbers = "".join(f"{'-' if v is None else f'{_difference(v, a, units):.2g}':>12s}" for v in values)
        lines.append(f"{name:{width}s}{numbers}{slopes:>12s}{_domain(a):>12s}{'' if a.holds else '  DIFFERS'}")
    lines += [
        f"{name}: {a.used:.2g} of the proved allowance of {_difference(a.allowance, a, units):.2g} used, borders included"
        for name, a in zip(names, found, strict=True)
        if a.used is not None and a.allowance is not None
    ]
    rounded = [a for a in found if a.target == "onnx float"]
    if rounded:
        only_borders = rounded[0].domain and rounded[0].domain == rounded[0].rounded  # the same for all outputs
        lines.append(
            "onnx float rounds borders too: next to one it may answer for the other side"
            + (
                f", as at {rounded[0].rounded} of the points, which all lie on borders: no fault of it"
                if only_borders
                else ""
            )
        )
    lines += [f"not tried: {target}: {why}" for target, why in not_tried.items()]
    return "\n".join([*lines, _verdict(found)])


def _difference(value: float, of: Agreement, units: str) -> float:
    return (
        float(as_shown(value, of.unit, units)) - float(as_shown(0.0, of.unit, units)) if np.isfinite(value) else value
    )


def _name(of: Agreement) -> str:
    return of.output.removesuffix(f" [{of.unit}]")


def _domain(of: Agreement) -> str:
    """Whether a target says of the same points that they are in the domain."""
    if of.domain is None:
        return "-"
    if of.domain == 0:
        return "agrees"
    return f"{of.domain} rounded" if not of.exact and of.domain == of.rounded else f"{of.domain} differ"


def _verdict(found: Sequence[Agreement]) -> str:
    """One line on all targets."""
    wrong = list(dict.fromkeys(a.target for a in found if not a.holds))
    if wrong:
        return f"verified: no: {', '.join(wrong)} {'does' if len(wrong) == 1 else 'do'} not give what the package gives"
    proved = any(a.used is not None for a in found)
    judged = list(dict.fromkeys(a.target for a in found if a.exact or a.used is not None))
    return (
        f"verified: {', '.join(judged)} {'gives' if len(judged) == 1 else 'give'} what the package gives"
        + (", c float within what is proved of it" if proved else "")
        if judged
        else "verified: nothing could be judged here"
    )


class _Expected(NamedTuple):
    """The same from the package."""

    y: np.ndarray
    slopes: np.ndarray
    outside: np.ndarray


def _expected(whole: Bundle, n: int, seed: int, dtype: Any) -> tuple[np.ndarray, _Expected]:
    X = whole.points(n, seed).astype(dtype).astype(np.float64)
    return X, _Expected(whole.predict(X), whole.slopes(X), whole.outside(X))


def _tried(target: str, give: Callable[[], Answers], expected: np.ndarray, not_tried: dict[str, str]) -> Answers | None:
    """What a target answers; nothing where it cannot be tried here, and no number where it fails, with the reason in `not_tried`."""
    try:
        return give()
    except NotHereError as reason:
        not_tried[target] = str(reason)
        return None
    except FailedError as reason:  # written, but it does not run
        not_tried[target] = f"fails: {reason}"
        return Answers(np.full_like(expected, np.nan))


def _rows_compared(whole: Bundle, target: str, expected: np.ndarray, found: np.ndarray) -> Iterator[Agreement]:
    off = np.abs(found - expected)
    off[np.isnan(off)] = np.inf
    for output, far, size in zip(
        whole.outputs, off.max(axis=0).tolist(), np.abs(expected).max(axis=0).tolist(), strict=True
    ):
        yield Agreement(target, str(output), far, None, None, None, None, size or 1.0, True, unit=output.unit)


def _compared(whole: Bundle, target: str, exact: bool, expected: _Expected, found: Answers) -> Iterator[Agreement]:
    n, size = len(expected.y), np.abs(expected.y).max(axis=0)
    difference = np.abs(found.y - expected.y)
    difference[np.isnan(difference)] = np.inf
    parts = [difference[start:end].max(axis=0) for start, end in (
        (0, 2 * n // 3), (2 * n // 3, 5 * n // 6), (5 * n // 6, n))]  # fmt: skip
    domain, rounded = None, 0
    if found.outside is not None:
        other = (found.outside > 0.0) != (expected.outside > 0.0)
        domain, rounded = int(other.sum()), int(other[2 * n // 3 : 5 * n // 6].sum())
    for k, output in enumerate(whole.outputs):
        slopes = None
        if found.slopes is not None:
            rows = slice(None) if exact else slice(2 * n // 3)  # slopes jump at borders
            scale = np.abs(expected.slopes[:, k]).max(axis=0)
            off = np.abs(found.slopes[rows, k] - expected.slopes[rows, k]) / np.where(scale > 0.0, scale, 1.0)
            slopes = float(np.where(np.isnan(off), np.inf, off).max())
        inside, border, outside = (float(part[k]) for part in parts)
        sizes = (inside, border, outside, slopes, domain, float(size[k]) or 1.0)
        yield Agreement(target, str(output), *sizes, exact, unit=output.unit, rounded=rounded)


def _judged(
    whole: Bundle, X: np.ndarray, expected: _Expected, found: Answers, compared: Iterator[Agreement]
) -> Iterator[Agreement]:
    """The same with what is proved of C in single precision, for inputs in the domain of the network that answers."""
    for k, agreement in enumerate(compared):
        model, place = whole.models[k], list(whole.places[k])
        try:
            allowance = model_allowance(model).error
        except InputError:  # which is why it could not be tried
            allowance = np.inf
        ends = np.array([input_limits(network, FLOAT) for network in model.networks])[
            region_of(model.partition, X[:, place])
        ]
        inside = np.all((ends[..., 0] <= X[:, place]) & (ends[..., 1] >= X[:, place]), axis=1)
        off = np.abs(found.y[inside, k] - expected.y[inside, k])
        if not np.isfinite(allowance) or not off.size:
            yield agreement
            continue
        used = float(np.where(np.isnan(off), np.inf, off).max())
        yield agreement._replace(allowance=allowance, used=used / allowance if allowance else used and np.inf)


def _targets(
    whole: Bundle, run: Run | None, folder: Path, prove: bool
) -> Iterator[tuple[str, bool, Callable[[np.ndarray], Answers]]]:
    """Name, whether it is in double precision, and what answers at points; FMUs of models that run do not."""
    yield "python", True, partial(run_python, whole, folder)
    for real in ("double", "float"):
        yield f"c {real}", real == "double", partial(run_c, whole, folder, real, prove)
    for version in (2, 3) if run is None or run.raster is None else ():
        for kind, short in (("ModelExchange", "me"), ("CoSimulation", "cs")):
            yield f"fmi{version} {short}", True, partial(run_fmu, whole, folder, version, kind)
    for real in ("double", "float"):
        yield f"onnx {real}", real == "double", partial(run_onnx, whole, folder, real)


def _runs(whole: Bundle, run: Run, folder: Path) -> Iterator[tuple[str, np.ndarray, Callable[[], Answers]]]:
    """Name of each target that runs row by row, what the package answers, and what runs it."""
    trial = try_run(whole, run, _ROWS)
    yield "c run", trial.answers, partial(run_c_rows, whole, run, folder, trial)
    if run.raster is not None:
        for version in (2, 3):
            yield f"fmi{version} run", trial.answers, partial(run_fmu_rows, whole, run, folder, version, trial)
