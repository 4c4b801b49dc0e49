"""The whole machine as an FMU for co-simulation: joystick voltages in; spools, pressures, flows, motion out.

The C is that of `export.machine`; here are its variables, and the functions that ``fmu.h`` asks for.
"""

from collections.abc import Collection, Iterator
from html import escape
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from polydraulic.errors import InputError
from polydraulic.export.exported import Exported
from polydraulic.export.fmu.description import FmuDescription, FmuVariable
from polydraulic.export.fmu.package import write_fmu
from polydraulic.export.machine import machine_c, machine_size, outputs, prepared
from polydraulic.export.translate.names import field_name
from polydraulic.flow.dispatch import build_flow
from polydraulic.pages.html import document, table
from polydraulic.parameters.load import as_excavator
from polydraulic.parameters.quantity import Quantity
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.parameters.values import leaves_of

_NOMINAL = {"m": 0.01, "Pa": 1e7, "rad": 1.0, "rad/s": 1.0, "m3/s": 1e-3, "V": 1.0}
_STOP = 13.0


class MachineParameter(NamedTuple):
    """A number of a machine that a step reads as it is.

    Attributes
    ----------
    name : str
        Its path in the machine, such as ``boom.line.relief``.
    value : float
    quantity : Quantity
    places : list of tuple of str
        Its paths in `Prepared`.
    """

    name: str
    value: float
    quantity: Quantity
    places: list[tuple[str, ...]]


def export_machine_fmu(
    machine: Machine | str | Path,
    flow: str,
    path: str | Path,
    *,
    version: int = 3,
    name: str = "machine",
    dt: float = 5e-3,
    locked: Collection[str] = (),
    compiler: str | None = None,
    cross: bool = False,
) -> Exported:
    """Write a machine as an FMU for co-simulation, with sources and a binary for this machine.

    Parameters
    ----------
    machine : Machine, or name or path of a parameter set
    flow : str
        Name of a flow model; see `machine_c`.
    path : str or Path
        Ends in .fmu.
    version : int
        FMI 2 or 3.
    name : str
        Model name, a C identifier.
    dt : float, s
        Internal step. A communication step may be of any length: a whole number of internal steps, up to rounding, makes
        that number, at any time; of other lengths the machine makes the steps that have become due and carries the rest
        over.
    locked : collection of str
        Links whose joints are held.
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
    machine = as_excavator(machine)
    sources = machine_c(machine, flow, name=name, dt=dt, locked=locked)
    parameters = direct_parameters(machine, flow, dt=dt, locked=locked)
    size = machine_size(machine, flow, dt=dt)
    what = describe_machine(name, flow, parameters, dt=dt, memory=size + 2)
    sources |= {"equations.h": _equations(name, parameters, size)}
    return write_fmu(what, sources, path, version=version, page=_page(what), compiler=compiler, cross=cross)


def describe_machine(
    name: str, flow: str, parameters: list[MachineParameter], *, dt: float, memory: int
) -> FmuDescription:
    """Variables of the FMU: voltages, outputs, status, parameters.

    Parameters
    ----------
    name, flow, dt
        As for `export_machine_fmu`.
    parameters : list of MachineParameter
    memory : int
        Numbers that it keeps.
    """
    found = [
        FmuVariable(f"{link}.voltage", "input", "V", nominal=1.0, description=f"Joystick of the {link}")
        for link in LINKS
    ]
    for output in outputs():
        nominal = 1.0 if output.name.startswith("effector") else _NOMINAL[output.unit]
        found.append(
            FmuVariable(output.name, "output", output.unit, nominal=nominal, description="Output", dependencies=())
        )
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
    about = f"Excavator from joystick voltages to motion, flow model {flow!r}, steps of {dt:g} s"
    return FmuDescription(
        name, tuple(found), about, model_exchange=False, derivatives=False, step=dt, memory=memory, stop=_STOP
    )


def direct_parameters(
    machine: Machine, flow: str, *, dt: float = 5e-3, locked: Collection[str] = ()
) -> list[MachineParameter]:
    """Parameters that a step reads as they are; the others enter precomputed numbers, and stay as exported.

    Found by trying: a parameter is direct if all numbers that change with it are equal to it before and after, and the
    flow model takes other values of it.

    Parameters
    ----------
    machine : Machine
    flow : str
    dt : float, s
    locked : collection of str
    """
    quantities = {
        tuple(path.split(".")): leaf.quantity
        for path, leaf in leaves_of(Machine).items()
        if leaf.quantity is not None and not leaf.size
    }
    base = prepared(machine, flow, dt=dt, locked=locked)
    before, found = dict(_leaves(base)), []

    def after(changed: Machine, rebuild: bool) -> dict[tuple[str, ...], Any]:
        """Numbers of a changed machine; none if the flow model refuses it, being made for the values as they are."""
        try:
            model = build_flow(flow, changed) if rebuild else base.model
        except InputError:
            return {}
        return dict(_leaves(prepared(changed, model, dt=dt, locked=locked)))

    def differing(numbers: dict[tuple[str, ...], Any]) -> list[tuple[str, ...]]:
        return [place for place, number in numbers.items() if not np.array_equal(before[place], number)]

    in_model = set()  # parts of the machine that the flow model reads; it is slow to build
    for part in Machine._fields:
        changed = machine
        for path in quantities:
            changed = _replaced(changed, path, _other(_at(machine, path))) if path[0] == part else changed
        numbers = after(changed, True)
        if not numbers or any(place[0] == "model" for place in differing(numbers)):
            in_model.add(part)
    for path, quantity in quantities.items():
        if path[-1].startswith("torque_limit"):  # without a limit they do nothing, with one they enter `log_least` too
            continue
        value = _at(machine, path)
        numbers = after(_replaced(machine, path, _other(value)), path[0] in in_model)
        places = differing(numbers)
        if places and all(before[place] == value and numbers[place] == _other(value) for place in places):
            found.append(MachineParameter(".".join(path), value, quantity, places))
    return found


def _other(value: float) -> float:
    return value * 1.001 if value else 1e-3


def _at(tree: Any, path: tuple[str, ...]) -> float:
    for name in path:
        tree = getattr(tree, name)
    return float(tree)


def _replaced(tree: Any, path: tuple[str, ...], value: float) -> Any:
    new = value if len(path) == 1 else _replaced(getattr(tree, path[0]), path[1:], value)
    return tree._replace(**{path[0]: new})


def _leaves(tree: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    if isinstance(tree, tuple):
        for name, part in zip(tree._fields, tree, strict=True):  # type: ignore[attr-defined]
            yield from _leaves(part, (*path, name))
    else:
        yield path, tree


def _equations(name: str, parameters: list[MachineParameter], size: int) -> str:
    n_out, first = len(outputs()), len(LINKS) + len(outputs()) + 1
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
    memcpy(v + {len(LINKS)}, memory, {n_out} * sizeof(double));
    v[{len(LINKS) + n_out}] = memory[STATUS];
}}

/* Steps that a communication step makes due. One that is a whole number of them, up to the rounding of its ends, counts
   as that number, however large the times are and however often it comes; of any other the rest is carried over. */
static double steps_due(double *rest, double from, double to)
{{
    const double steps = (to - from) / {name.upper()}_DT;
    const double rounding = 2.0 * DBL_EPSILON * fmax(fabs(from), fabs(to)) / {name.upper()}_DT;
    const double whole = floor(steps + 0.5);
    if (whole >= 1.0 && fabs(steps - whole) <= 1e-9 * whole + rounding) {{
        return whole;
    }}
    const double passed = *rest + steps;
    const double due = floor(passed + 1e-6 + rounding);
    *rest = passed - due;
    return due;
}}

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
communication step has to begin where the last one ended. Inputs are held in between. Links stand in the order {", ".join(LINKS)}.
Parameters are those that a step reads as they are; all others are part of the exported numbers.</p>
{table("", ["variable", "kind", "unit", "meaning"], rows)}"""
    return document(what.name, body)
