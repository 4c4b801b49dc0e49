"""The whole machine as an FMU for co-simulation: joystick voltages in; spools, pressures, flows, motion out.

The C is that of `export.machine`; here are its variables, and the functions that ``fmu.h`` asks for.
"""

from collections.abc import Collection
from html import escape
from pathlib import Path

import numpy as np

from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription, FmuVariable
from polydraulic.export.fmu.due import steps_due
from polydraulic.export.fmu.machine_parameters import MachineParameter, direct_parameters
from polydraulic.export.fmu.package import write_fmu
from polydraulic.export.layout import FORCE
from polydraulic.export.machine import export_name, machine_c, machine_parts
from polydraulic.export.machine_parts import MachineParts
from polydraulic.export.translate.names import field_name
from polydraulic.flow.layout.model import LayoutFlow
from polydraulic.pages.html import document, table
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import as_machine
from polydraulic.simulation.layout.stability.text import SLOPE

_NOMINAL = {"m": 0.01, "m/s": 0.1, "Pa": 1e7, "rad": 1.0, "rad/s": 1.0, "m3/s": 1e-3, "V": 1.0}
_MARGIN = {"m": 1.0, "N m": 1e5, "J": 1e5, "1": 1.0, "s": 1.0}  # of what is said of tipping
_STOP = 13.0


def export_machine_fmu(
    machine: LayoutMachine | str | Path,
    flow: str | LayoutFlow,
    path: str | Path,
    *,
    version: int = 3,
    name: str | None = None,
    dt: float = 5e-3,
    locked: Collection[str] = (),
    force: bool = False,
    stability: bool = False,
    compiler: str | None = None,
    cross: bool = False,
) -> Exported:
    """Write a machine as an FMU for co-simulation, with sources and a binary for this machine.

    Parameters
    ----------
    machine : LayoutMachine, or name or path of a parameter set
    flow : str or LayoutFlow
        Name of a flow model, see `machine_c`, or a flow model.
    path : str or Path
        Ends in .fmu.
    version : int
        FMI 2 or 3.
    name : str, optional
        Model name, a C identifier; see `machine_c`.
    dt : float, s
        Internal step. A communication step may be of any length: a whole number of internal steps, up to rounding, makes
        that number, at any time; of other lengths the machine makes the steps that have become due and carries the rest
        over.
    locked : collection of str
        Functions whose joints are held.
    force : bool
        Whether three more inputs are a force at the tip; see `machine_c`.
    stability : bool
        Whether margins against tipping are outputs, and the slope of the ground, which starts as that of the machine's file, two more inputs.
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
        As `machine_c` and `write_fmu`.
    """
    name = export_name(machine) if name is None else name
    machine = as_machine(machine)
    parts = machine_parts(machine, flow, dt=dt, locked=locked, force=force, stability=stability)
    sources = machine_c(machine, flow, name=name, dt=dt, locked=locked, force=force, stability=stability)
    parameters = direct_parameters(machine, flow, dt=dt, locked=locked)
    what = describe_machine(name, parts, parameters, dt=dt)
    sources |= {"equations.h": _equations(name, parameters, parts)}
    return write_fmu(what, sources, path, version=version, page=_page(what), compiler=compiler, cross=cross)


def describe_machine(
    name: str, parts: MachineParts, parameters: list[MachineParameter], *, dt: float
) -> FmuDescription:
    """Variables of the FMU: inputs, outputs, status, parameters.

    Parameters
    ----------
    name, dt
        As for `export_machine_fmu`.
    parts : MachineParts
    parameters : list of MachineParameter
    """
    found = [
        FmuVariable(f"{function}.voltage", "input", "V", nominal=1.0, description=f"Joystick of the {function}")
        for function in parts.functions
    ]
    found += [
        FmuVariable(force, "input", "N", nominal=1e3, description="Force at the tip, along an axis of the ground")
        for force in parts.inputs[len(parts.functions) :]
        if force in FORCE
    ]
    found += (
        [
            FmuVariable(
                slope, "input", "rad", start, nominal=0.1, description=f"How the ground rises {way}, for margins"
            )
            for slope, way, start in zip(
                SLOPE, ("forward", "to the left"), (parts.numbers.body.pitch, parts.numbers.body.roll), strict=True
            )
        ]
        if SLOPE[0] in parts.inputs
        else []
    )
    for output, unit in parts.outputs:
        nominal = (
            1.0
            if output.startswith("effector")
            else _MARGIN[unit]
            if output.startswith("stability")
            else _NOMINAL[unit]
        )
        found.append(FmuVariable(output, "output", unit, nominal=nominal, description="Output", dependencies=()))
    about = (
        "0, or of the steps since the last communication: 1 a step did not converge, 2 one left the flow model's domain"
    )
    found.append(FmuVariable("status", "output", "1", 0.0, 0.0, 2.0, 1.0, about, ()))
    for parameter in parameters:
        quantity, start_only = parameter.quantity, all(place[0] == "start" for place in parameter.places)
        low = quantity.above if np.isfinite(quantity.above) else quantity.low
        found.append(
            FmuVariable(
                parameter.name,
                "fixed parameter" if start_only else "parameter",
                quantity.unit,
                parameter.value,
                low if np.isfinite(low) else None,
                quantity.high if np.isfinite(quantity.high) else None,
                abs(parameter.value) or 1.0,
                "Parameter of the machine",
            )
        )
    about = f"Hydraulic machine from joystick voltages to motion, flow model {parts.flow!r}, steps of {dt:g} s"
    return FmuDescription(
        name, tuple(found), about, model_exchange=False, derivatives=False, step=dt, memory=parts.size + 2, stop=_STOP
    )


def _equations(name: str, parameters: list[MachineParameter], parts: MachineParts) -> str:
    n_in, n_out, size = len(parts.inputs), len(parts.outputs), parts.size
    first = n_in + n_out + 1
    changes = "\n".join(
        f"    own->{'.'.join(map(field_name, place))} = v[{first + i}];"
        for i, parameter in enumerate(parameters)
        for place in parameter.places
    )
    return f"""/* The machine in terms of fmu.h; memory holds it, the time since its last step, and the status. */
#include "{name}.h"
#include "{name}_kernels.h"

#include <float.h>
#include <math.h>

#define REST {size} /* in steps of the machine */
#define STATUS {size + 1}
#define MOST_STEPS 1e9

typedef char machine_fits_into_memory[(sizeof({name}_machine) == {size} * sizeof(double)) ? 1 : -1];

/* The numbers of the machine: those that were exported unless a parameter has been changed. */
static const Prepared *fmu_numbers(const double *v, Prepared *own)
{{
    int same = 1;
    for (int i = {first}; i < {first + len(parameters)}; i++) {{
        same = same && v[i] == fmu_starts[i];
    }}
    if (same) {{
        return &{name}_parameters;
    }}
    *own = {name}_parameters;
{changes}
    return own;
}}

static void fmu_start(const double *v, double *memory)
{{
    Prepared own;
    {name}_machine m;
    memory[STATUS] = {name}_init_with(fmu_numbers(v, &own), &m);
    memory[REST] = 0.0;
    memcpy(memory, &m, sizeof m);
}}

static void fmu_outputs(double *v, const double *memory)
{{
    memcpy(v + {n_in}, memory, {n_out} * sizeof(double));
    v[{n_in + n_out}] = memory[STATUS];
}}

{steps_due(name)}
static int fmu_advance(double *v, double *memory, double from, double to)
{{
    Prepared own;
    {name}_machine m;
    int worst = 0;
    double rest = memory[REST];
    const double due = steps_due(&rest, from, to);
    if (!(due <= MOST_STEPS)) {{
        return 0;
    }}
    memcpy(&m, memory, sizeof m);
    const Prepared *numbers = fmu_numbers(v, &own);
    for (int64_t k = 0; k < (int64_t)due; k++) {{
        const int status = {name}_step_with(numbers, &m, v);
        if (status >= {name.upper()}_DIVERGED) {{
            return 0;
        }}
        worst = (status > worst) ? status : worst;
    }}
    memcpy(memory, &m, sizeof m);
    memory[REST] = rest;
    memory[STATUS] = worst;
    return 1;
}}

static void fmu_partials(const double *v, const double *memory, double *partials)
{{
    (void)v;
    (void)memory;
    memset(partials, 0, sizeof(double) * FMU_N_OUTPUTS * FMU_N_INPUTS); /* there are none to give */
}}
"""


def _page(what: FmuDescription) -> str:
    """Documentation: how it steps, and its variables."""
    rows = [[v.name, v.kind, v.unit, v.description] for v in what.variables]
    body = f"""<p>{escape(what.description)}. Communication steps may have any length: one that is a whole number of internal steps, up to
rounding, makes that number; of others the internal steps that have become due are made, and the rest is carried over. Each
communication step has to begin where the last one ended. Inputs are held in between. Functions stand in the order of the inputs.
Parameters are those that a step reads as they are; all others are part of the exported numbers.</p>
{table("", ["variable", "kind", "unit", "meaning"], rows)}"""
    return document(what.name, body)
