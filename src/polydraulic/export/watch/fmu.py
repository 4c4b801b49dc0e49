"""A machine that is watched, as an FMU for co-simulation: what sensors read in; evidence of faults, alarm and what it is named out.

The C is that of `export.watch.source`; here are its variables, and the functions that ``fmu.h`` asks for.
"""

from collections.abc import Iterable
from html import escape
from pathlib import Path

from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription, FmuVariable
from polydraulic.export.fmu.due import steps_due
from polydraulic.export.fmu.package import write_fmu
from polydraulic.export.watch.source import all_names, fault_names, watch_c
from polydraulic.pages.html import document, table
from polydraulic.watch.watch import FaultWatch

_UNITS = {"voltage": "V", "spool": "m", "p_a": "Pa", "p_b": "Pa", "q_in": "m3/s", "q_out": "m3/s", "angle": "rad", "position": "m", "p_pump": "Pa"}  # fmt: skip
_NOMINAL = {"V": 1.0, "m": 0.01, "Pa": 1e7, "m3/s": 1e-3, "rad": 1.0}
_STOP = 600.0


def export_watch_fmu(
    watch: FaultWatch,
    path: str | Path,
    *,
    version: int = 3,
    name: str = "watch",
    compiler: str | None = None,
    cross: bool = False,
) -> Exported:
    """Write a machine that is watched as an FMU for co-simulation, with sources and a binary for this machine.

    Parameters
    ----------
    watch : FaultWatch
        As for `watch_c`.
    path : str or Path
        Ends in .fmu.
    version : int
        FMI 2 or 3.
    name : str
        Model name, a C identifier.
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
        As `watch_c` and `write_fmu`.
    """
    sources = watch_c(watch, name=name)
    what = describe_watch(watch, name)
    sources |= {"equations.h": _equations(name, watch)}
    return write_fmu(what, sources, path, version=version, page=_page(what, watch), compiler=compiler, cross=cross)


def describe_watch(watch: FaultWatch, name: str) -> FmuDescription:
    """Variables of the FMU: sensors in; evidence of each fault, alarm, its name by number, how sure and since when, what networks say, status."""
    of, faults = watch.of, fault_names(watch)
    found = []
    for column in of.columns:
        unit = _UNITS[column.rpartition(".")[2]]
        found.append(FmuVariable(column, "input", unit, nominal=_NOMINAL[unit], description="What the sensor reads"))
    about = "Evidence, as a share of what makes an alarm"
    found += [FmuVariable(f"{fault}.evidence", "output", "1", nominal=1.0, description=about, dependencies=()) for fault in faults]  # fmt: skip
    named = f"What it is: 0 nothing that is known, else by number: {_numbered(all_names(watch))}"
    for output, unit, text in (
        ("alarm", "1", "0 none, 1 there is one, 2 of unusual work that is no fault"),
        ("named", "1", named),
        ("chance", "1", "Probability of what it is named, among all faults, one of them alone"),
        ("since", "s", "When the last alarm began, by what was seen"),
        *_of_networks(watch),
        ("status", "1", "0, or of the last row: 2 a value is not finite, 3 or 4 rows come at another raster"),
    ):
        found.append(FmuVariable(output, "output", unit, nominal=1.0, description=text, dependencies=()))
    memory = _state_size(watch) + 5
    about = f"{of.machine.title} watched for faults by rows every {of.shape.raster:g} s"
    return FmuDescription(
        name, tuple(found), about, model_exchange=False, derivatives=False, step=of.shape.raster, memory=memory, stop=_STOP
    )  # fmt: skip


def _of_networks(watch: FaultWatch) -> list[tuple[str, str, str]]:
    """Outputs that networks fill, if there are some: name, unit, meaning."""
    if watch.networks is None:
        return []
    return [
        ("kind", "1", f"Kind of fault that networks take it for: 0 none, else by number: {_numbered(watch.networks.kinds)}"),
        ("certainty", "1", "How certain networks are of the kind: a probability among those that they were learnt from"),
        ("familiar", "1", "1 if the evidence is like that which networks were learnt from; else their certainty tells little"),
    ]  # fmt: skip


def _numbered(names: Iterable[str]) -> str:
    return ", ".join(f"{k} {name}" for k, name in enumerate(names, 1))


def _state_size(watch: FaultWatch) -> int:
    """Numbers of a state in C."""
    parts, asked = watch.judge_parts, () if watch.asked is None else watch.asked[1:]
    return sum(map(len, (parts.live, parts.work, parts.marks, *asked)))


def _equations(name: str, watch: FaultWatch) -> str:
    sensors, faults, size = len(watch.of.columns), len(fault_names(watch)), _state_size(watch)
    upper, status = name.upper(), faults + 4
    said = ""
    if watch.networks is not None:
        status += 3
        said = f"""
    out[{faults + 4}] = alarm ? {name}_kind(w) + 1.0 : 0.0;
    out[{faults + 5}] = alarm ? {name}_certainty(w) : 0.0;
    out[{faults + 6}] = alarm ? {name}_familiar(w) : 0.0;"""
    return f"""/* A machine that is watched in terms of fmu.h; memory holds it, steps that are due, and what became of its rows. */
#include "{name}.h"

#include <float.h>
#include <math.h>

#define REST {size} /* in rows */
#define BEGAN {size + 1} /* s, when the first row was taken */
#define ROWS {size + 2}
#define ALARM {size + 3}
#define STATUS {size + 4}
#define MOST_ROWS 1e9

typedef char watch_fits_into_memory[(sizeof({name}_state) == {size} * sizeof(double)) ? 1 : -1];

static void fmu_start(const double *v, double *memory)
{{
    (void)v;
    {name}_init(({name}_state *)memory);
    memory[REST] = memory[BEGAN] = memory[ROWS] = memory[ALARM] = memory[STATUS] = 0.0;
}}

static void fmu_outputs(double *v, const double *memory)
{{
    const {name}_state *w = (const {name}_state *)memory;
    const int alarm = memory[ALARM] > 0.0;
    double *out = v + {sensors};
    for (int k = 0; k < {faults}; k++) {{
        out[k] = {name}_share(w, k);
    }}
    out[{faults}] = alarm ? ({name}_harmless(w) ? 2.0 : 1.0) : 0.0;
    out[{faults + 1}] = alarm ? {name}_named(w) + 1.0 : 0.0;
    out[{faults + 2}] = alarm ? {name}_chance(w) : 0.0;
    out[{faults + 3}] = {name}_since(w);{said}
    out[{status}] = memory[STATUS];
}}

{steps_due(name)}
static int fmu_advance(double *v, double *memory, double from, double to)
{{
    {name}_state *w = ({name}_state *)memory;
    double rest = memory[REST];
    const double due = steps_due(&rest, from, to);
    if (!(due <= MOST_ROWS)) {{
        return 0;
    }}
    memory[BEGAN] = (memory[ROWS] > 0.0) ? memory[BEGAN] : from;
    memory[STATUS] = 0.0;
    for (int64_t k = 0; k < (int64_t)due; k++) {{
        const int became = {name}_update(w, memory[BEGAN] + memory[ROWS] * {upper}_DT, v);
        memory[ROWS] += 1.0;
        if (became >= {upper}_JUDGED) {{
            memory[ALARM] = (became >= {upper}_ALARM) ? 1.0 : 0.0;
        }} else {{
            memory[STATUS] = fmax(memory[STATUS], became);
        }}
    }}
    memory[REST] = rest;
    return 1;
}}

static void fmu_partials(const double *v, const double *memory, double *partials)
{{
    (void)v;
    (void)memory;
    memset(partials, 0, sizeof(double) * FMU_N_OUTPUTS * FMU_N_INPUTS); /* there are none to give */
}}
"""


def _page(what: FmuDescription, watch: FaultWatch) -> str:
    """Documentation: how it takes rows, and its variables."""
    rows = [[v.name, v.kind, v.unit, v.description] for v in what.variables]
    body = f"""<p>{escape(what.description)}. A communication step of any length takes the rows that have become due, at the times
of a raster that begins with the first step; inputs are held in between. A step of one row each is what it is made for. A block of
{watch.of.shape.seconds:g} s is judged at once, {watch.of.shape.after * watch.of.shape.raster:.2g} s after it has ended.</p>
{table("", ["variable", "kind", "unit", "meaning"], rows)}"""
    return document(what.name, body)
