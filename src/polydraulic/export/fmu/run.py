"""Dynamic models as an FMU for co-simulation that runs row by row: inputs and measured outputs in, answers and strengths of joints out.

The C is that of `export.c.run`; here are its variables, and the functions that ``fmu.h`` asks for.
"""

from html import escape
from pathlib import Path

from polydraulic.export.c.run import Run, run_texts
from polydraulic.export.c.source import to_c
from polydraulic.export.c.text import DOUBLE
from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription, FmuVariable, free_name
from polydraulic.export.fmu.due import steps_due
from polydraulic.export.fmu.package import write_fmu
from polydraulic.export.model_bundle import Bundle
from polydraulic.networks.dynamic.free_run import limits_of
from polydraulic.networks.dynamic.rows import STATES
from polydraulic.networks.model.table import UNBOUNDED
from polydraulic.pages.html import document, table

_ROWS = 600  # of the experiment that is proposed


def write_run_fmu(
    whole: Bundle, run: Run, path: str | Path, *, version: int, compiler: str | None, cross: bool
) -> Exported:
    """Write models that run; parameters as `export_fmu`, errors as `write_fmu`."""
    header, source = to_c(whole)
    what = describe_run(whole, run)
    sources = {f"{whole.name}.h": header, f"{whole.name}.c": source, **run_texts(whole, run, DOUBLE)}
    sources["equations.h"] = _equations(whole, run)
    note = (
        f"dynamic: it runs by itself, a row every {run.raster:g} s, behind {run.warm_up} rows or more that were measured (input "
        f"{_measuring(what, run)!r} is 1)"
    )
    return write_fmu(
        what, sources, path, version=version, page=_page(what, run), compiler=compiler, cross=cross, notes=[note]
    )


def describe_run(whole: Bundle, run: Run) -> FmuDescription:
    """Variables of the FMU: inputs, measured outputs, whether they are measured; answers, strengths, status."""
    boxes = {column: box for box, (column, _) in zip(whole.domain().tolist(), run.reads, strict=True)}
    found: list[FmuVariable] = []

    def add(name: str, *of: object, **more: object) -> None:
        free = free_name(name, [variable.name for variable in found])
        found.append(FmuVariable(free, *of, **more))  # type: ignore[arg-type]

    for i, variable in enumerate(run.inputs):
        low, high = boxes[i]
        nominal = max(abs(low), abs(high)) or 1.0
        about = "Input; its limits are the domain"
        add(variable.name, "input", variable.unit, 0.5 * (low + high), low, high, nominal, about)
    ends = [limits_of(model)[2:] for model in whole.models]
    sizes = [max([abs(end) for end in pair if abs(end) < UNBOUNDED], default=0.0) or 1.0 for pair in ends]
    for variable, size in zip(run.outputs, sizes, strict=True):
        about = "Read where the row was measured"
        add(f"{variable.name}.measured", "input", variable.unit, nominal=size, description=about)
    about = "1: the row was measured; 0: it is answered. A measured row behind one that was answered begins anew"
    add("measuring", "input", "1", 1.0, 0.0, 1.0, 1.0, about)
    for variable, size in zip(run.outputs, sizes, strict=True):  # without limits, as a measured row may hold anything
        about = "Of the last row, measured or answered"
        add(variable.name, "output", variable.unit, nominal=size, description=about)
    for k in run.strong:
        for way in ("upwards", "downwards"):
            about = f"How strong the joint is {way}: a factor of its rate, 1 in the mean"
            add(f"{run.outputs[k].name}.strength_{way}", "output", "1", nominal=1.0, description=about)
    about = f"Of the last row: 0 well, 1 a value read is outside of the domain, 2 it was a gap, 3 fewer than {run.warm_up} rows are known"
    add("status", "output", "1", 0.0, 0.0, 3.0, 1.0, about)
    assert run.raster is not None
    text = f"{', '.join(map(str, run.outputs))}, by rows every {run.raster:g} s"
    return FmuDescription(
        whole.name, tuple(found), text, model_exchange=False, derivatives=False, step=run.raster, memory=_size(run) + 2,
        stop=_ROWS * run.raster,
    )  # fmt: skip


def _size(run: Run) -> int:
    """Numbers of a run in C."""
    n, m = len(run.inputs), len(run.outputs)
    return (run.warm_up + 1) * (n + m) + (STATES + 2) * m + 3


def _measuring(what: FmuDescription, run: Run) -> str:
    return what.variables[len(run.inputs) + len(run.outputs)].name


def _equations(whole: Bundle, run: Run) -> str:
    name, n, m, size = f"{whole.name}_run", len(run.inputs), len(run.outputs), _size(run)
    upper, first = name.upper(), n + m + 1
    inputs = "fmu_v, " if n else ""
    strengths = "\n".join(
        f"    fmu_v[{first + m + 2 * i + down}] = {name}_strength(fmu_r, {k}, {down});"
        for i, k in enumerate(run.strong)
        for down in (0, 1)
    )
    return f"""/* A run in terms of fmu.h; memory holds it, rows that are due, and what became of the last one. Names begin with fmu where
   functions of the run are called, which may have any other name. */
#include "{name}.h"

#include <math.h>

#define REST {size} /* in rows */
#define STATUS {size + 1}
#define MOST_ROWS 1e9
#define FMU_STUCK "there is no answer: {run.warm_up} rows must have been measured before, inputs be finite, and a step take no more than 1e9 rows"

typedef char run_fits_into_memory[(sizeof({name}) == {size} * sizeof(double)) ? 1 : -1];

static void fmu_start(const double *v, double *memory)
{{
    (void)v;
    {name}_begin(({name} *)memory);
    memory[REST] = 0.0;
    memory[STATUS] = {upper}_TOO_FEW;
}}

static void fmu_outputs(double *fmu_v, const double *fmu_memory)
{{
    const {name} *fmu_r = (const {name} *)fmu_memory;
    const int64_t fmu_last = (fmu_r->at > 0) ? fmu_r->at - 1 : {upper}_WARM_UP;
    int fmu_k;
    for (fmu_k = 0; fmu_k < {m}; ++fmu_k) {{ /* before the first row what would be measured */
        fmu_v[{first} + fmu_k] = (fmu_r->known > 0) ? fmu_r->rows[fmu_last][{n} + fmu_k] : fmu_v[{n} + fmu_k];
    }}
{strengths}
    fmu_v[{first + m + 2 * len(run.strong)}] = fmu_memory[STATUS];
}}

{steps_due(name)}
static int fmu_advance(double *fmu_v, double *fmu_memory, double fmu_from, double fmu_to)
{{
    {name} *fmu_r = ({name} *)fmu_memory;
    double fmu_rest = fmu_memory[REST];
    double fmu_answers[{m}];
    const double fmu_due = steps_due(&fmu_rest, fmu_from, fmu_to);
    if (!(fmu_due <= MOST_ROWS)) {{
        return 0;
    }}
    for (int64_t fmu_k = 0; fmu_k < (int64_t)fmu_due; fmu_k++) {{
        int fmu_became;
        if (fmu_v[{n + m}] > 0.5) {{
            fmu_became = {name}_measured(fmu_r, {inputs}fmu_v + {n});
            if (fmu_became == {upper}_INSIDE && fmu_r->known < {upper}_WARM_UP) {{
                fmu_became = {upper}_TOO_FEW;
            }}
        }} else {{
            fmu_became = {name}_next(fmu_r, {inputs}fmu_answers);
            if (fmu_became > {upper}_OUTSIDE) {{
                return 0; /* there is no answer */
            }}
        }}
        fmu_memory[STATUS] = fmu_became;
    }}
    fmu_memory[REST] = fmu_rest;
    return 1;
}}

static void fmu_partials(const double *v, const double *memory, double *partials)
{{
    (void)v;
    (void)memory;
    memset(partials, 0, sizeof(double) * FMU_N_OUTPUTS * FMU_N_INPUTS); /* there are none to give */
}}
"""


def _page(what: FmuDescription, run: Run) -> str:
    """Documentation: how rows are taken, and the variables."""
    rows = [
        [v.name, v.kind, v.unit, *("" if end is None else f"{end:.6g}" for end in (v.low, v.high)), v.description]
        for v in what.variables
    ]
    switch = escape(_measuring(what, run))
    body = f"""<p>{escape(what.description)}. A communication step of any length takes the rows that have become due, by a raster that begins
with the first step; inputs are held in between. A step of one row each is what it is made for: its inputs are set, it is made, and the
outputs are those of this row.</p>
<p>While {switch} is 1, rows are measured: lagged values are kept, and how strong joints are is followed. When it turns 0, the model goes on by
itself. It needs {run.warm_up} rows before; with fewer, or where an input is not a number, a step without an answer fails. A measured row behind one
that was answered begins the run anew, and so does a measured row with a value that is not finite: to look ahead again and again, store the state
before, and restore it.</p>
{table("", ["variable", "kind", "unit", "lowest", "highest", "meaning"], rows)}
<p>Where values lie outside of the domain, they are moved to its border, and the status is 1.</p>"""
    return document(what.name, body)
