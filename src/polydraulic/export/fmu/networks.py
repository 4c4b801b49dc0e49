"""Models as an FMU: inputs in, outputs and how far the inputs lie outside the domain out, with exact derivatives."""

import csv
import io
from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from polydraulic.export.c.run import run_of
from polydraulic.export.c.source import to_c
from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription, FmuVariable, free_name
from polydraulic.export.fmu.package import write_fmu
from polydraulic.export.fmu.run import write_run_fmu
from polydraulic.export.model_bundle import Bundle, bundle
from polydraulic.networks.model.lag_words import dynamic_notes
from polydraulic.networks.model.model import Model
from polydraulic.networks.model.table import UNBOUNDED
from polydraulic.pages.html import bullets, document, table

_STOP, _ROWS = 1.0, 101


def export_fmu(
    models: Sequence[Model],
    path: str | Path,
    *,
    version: int = 3,
    name: str | None = None,
    compiler: str | None = None,
    cross: bool = False,
) -> Exported:
    """Write models as an FMU for model exchange and co-simulation, with sources and a binary for this machine.

    Dynamic models whose raster is known run row by row, for co-simulation alone (`fmu.run`); without a raster the FMU is their function of
    lagged values.

    Parameters
    ----------
    models : sequence of Model
        One per output.
    path : str or Path
        Ends in .fmu.
    version : int
        FMI 2 or 3.
    name : str, optional
        Model name, made a C identifier; the output's if there is one model, else "model".
    compiler : str, optional
        Command; one that is installed if not given, and none if it is empty.
    cross : bool
        Whether to add binaries for Windows, macOS and Linux on both processors; needs the package ziglang.

    Returns
    -------
    Exported
        As `write_fmu`.

    Raises
    ------
    InputError
        If the models do not go together, a compiler is missing, or the file cannot be written.
    """
    whole = bundle(models, name=name)
    run = run_of(whole)
    if run is not None and run.raster is not None:
        return write_run_fmu(whole, run, path, version=version, compiler=compiler, cross=cross)
    header, source = to_c(whole)
    what = describe_networks(whole)
    sources = {f"{whole.name}.h": header, f"{whole.name}.c": source, "equations.h": _equations(whole)}
    inputs, results = _reference(whole, what)
    folder = f"extra/org.polydraulic/{whole.name}" if version == 3 else "documentation/reference"
    extra = {f"{folder}_in.csv": inputs, f"{folder}_ref.csv": results}
    return write_fmu(
        what, sources, path, version=version, page=_page(whole, what), extra=extra, compiler=compiler, cross=cross,
        notes=_notes(models),
    )  # fmt: skip


def _notes(models: Sequence[Model]) -> list[str]:
    """What is to be known of dynamic models; they get here without a raster."""
    notes = dynamic_notes(models)
    return (
        [*notes, "an FMU of models whose raster is known runs by itself: DynamicRegressor(raster=...)"] if notes else []
    )


def describe_networks(whole: Bundle) -> FmuDescription:
    """Variables of the FMU of models: inputs, outputs, and the domain."""
    domain = whole.domain()
    X = whole.points(500)
    size = np.abs(whole.predict(X)).max(axis=0)
    found = []
    for variable, (low, high) in zip(whole.inputs, domain.tolist(), strict=True):
        nominal = max(abs(low), abs(high)) or 1.0
        found.append(
            FmuVariable(variable.name, "input", variable.unit, 0.5 * (low + high), low, high, nominal, "Input; its limits are the domain")
        )  # fmt: skip
    for k, (model, place) in enumerate(zip(whole.models, whole.places, strict=True)):
        low = min(network.y_low for network in model.networks)
        high = max(network.y_high for network in model.networks)
        limits = (None if low == -UNBOUNDED else low, None if high == UNBOUNDED else high)
        names = tuple(whole.inputs[i].name for i in place)
        found.append(
            FmuVariable(model.output.name, "output", model.output.unit, 0.0, *limits, float(size[k]) or 1.0, "Output", names)
        )  # fmt: skip
    about = (
        "0 if the inputs are in the domain of the training data, else how far outside, as a share of its width; "
        "outputs are then those of its border"
    )
    name = free_name("domain", [variable.name for variable in found])
    found.append(FmuVariable(name, "output", "1", 0.0, 0.0, None, 1.0, about))
    outputs = ", ".join(map(str, whole.outputs))
    return FmuDescription(whole.name, tuple(found), f"{outputs} from {', '.join(map(str, whole.inputs))}", stop=_STOP)


def _equations(whole: Bundle) -> str:
    name, n, m = whole.name, len(whole.inputs), len(whole.models)
    return f"""/* {m} output(s) and the domain of {n} input(s); there is no memory. Names begin with fmu where
   the function of the models is called, which may have any other name. */
#include "{name}.h"

static void fmu_start(const double *v, double *memory)
{{
    (void)v;
    (void)memory;
}}

static void fmu_outputs(double *fmu_v, const double *fmu_memory)
{{
    double fmu_slopes[{n}];
    (void)fmu_memory;
    (void){name}(fmu_v, fmu_v + {n});
    fmu_v[{n + m}] = {name}_outside(fmu_v, fmu_slopes);
}}

static int fmu_advance(double *v, double *memory, double from, double to)
{{
    (void)v;
    (void)memory;
    (void)from;
    (void)to;
    return 1;
}}

static void fmu_partials(const double *v, const double *memory, double *partials)
{{
    double y[{m}];
    (void)memory;
    (void){name}_slopes(v, y, partials);
    (void){name}_outside(v, partials + {n * m});
}}
"""


def _reference(whole: Bundle, what: FmuDescription) -> tuple[str, str]:
    """Inputs through the domain and a little beyond it, at different pace, and the outputs, as CSV by time."""
    low, high = whole.domain().T
    time = np.linspace(0.0, _STOP, _ROWS)
    phase = np.outer(time, 1.0 + 0.37 * np.arange(len(low))) * 2.0 * np.pi
    X = 0.5 * (low + high) + 0.55 * (high - low) * np.sin(phase)
    names = [variable.name for variable in what.variables]
    n, clock = len(whole.inputs), free_name("time", names)
    Y = np.column_stack([whole.predict(X), whole.outside(X)])
    return _csv([clock, *names[:n]], np.column_stack([time, X])), _csv([clock, *names[n:]], np.column_stack([time, Y]))


def _csv(names: Sequence[str], rows: np.ndarray) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([[repr(value) for value in row] for row in rows.tolist()])
    return out.getvalue()


def _page(whole: Bundle, what: FmuDescription) -> str:
    """Documentation: variables with units and limits, networks by region."""
    rows = [
        [v.name, v.kind, v.unit, *("" if end is None else f"{end:.6g}" for end in (v.low, v.high)), v.description]
        for v in what.variables
    ]
    models = (
        f"{model.output}: {len(model.networks)} network(s), {model.n_coefficients} coefficients"
        for model in whole.models
    )
    notes = "".join(f"<p>{escape(note)}.</p>\n" for note in dynamic_notes(whole.models))
    body = f"""<p>{escape(what.description)}. Outputs follow from the inputs at the same time; there are no states and no events.</p>
{notes}{table("", ["variable", "kind", "unit", "lowest", "highest", "meaning"], rows)}
<h2>Networks</h2>
{bullets(models)}
<p>Derivatives are exact. They are 0 where an input lies outside of the domain or an output at its bounds. If an input is not
a number, the outputs are not numbers either and the domain is {np.finfo(np.float64).max:.3g}.</p>"""
    return document(what.name, body)
