"""The command that takes a machine out of Python: export-machine."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import MachineOption, app
from polydraulic.errors import InputError
from polydraulic.terminal import progress_bar


@app.command()
def export_machine(
    out: Annotated[Path, typer.Option(help="Folder to write C to, or an .fmu file.")],
    to: Annotated[str, typer.Option(help="c, fmi2 or fmi3.")] = "fmi3",
    flow: Annotated[str, typer.Option(help="exact, polynomial, neural, residual, iterative, stiff or tlm.")] = "exact",
    model: Annotated[
        list[Path] | None,
        typer.Option(help="Model file for polynomial, neural or residual; repeat for more."),
    ] = None,
    name: Annotated[
        str | None, typer.Option(help="Name of the export, a C identifier; that of the machine if not given.")
    ] = None,
    dt: Annotated[float, typer.Option(help="Internal time step in s.")] = 0.005,
    cross: Annotated[
        bool, typer.Option("--cross", help="FMU also for Windows, macOS and arm64, using the package ziglang.")
    ] = False,
    force: Annotated[
        bool,
        typer.Option("--force", help="Three more inputs, a force at the tip."),
    ] = False,
    stability: Annotated[
        bool,
        typer.Option("--stability", help="Margins against tipping as outputs, the ground's slope as two more inputs."),
    ] = False,
    machine: MachineOption = "cat215b",
) -> None:
    """Write the whole machine, joysticks to end-effector, as C99 or as an FMU for co-simulation; no Python in it.

    The kernels themselves are translated: its results are those of `simulate`, bit for bit.

    Example: `polydraulic export-machine --to fmi3 --flow polynomial --out excavator.fmu`

    - C99 for a controller or a test bench: `polydraulic export-machine --to c --out excavator`

    - With networks that `train` has learnt: `polydraulic export-machine --machine wheel_loader --flow polynomial --model loader.json --out
    loader.fmu`

    - With margins against tipping: `polydraulic export-machine --machine wheel_loader --stability --out loader.fmu`

    What comes next: import the FMU into Simulink, Modelica tools or FMPy; `docs/export_machine.md` shows how to call the C code.
    """
    from polydraulic.export.fmu.machine import export_machine_fmu
    from polydraulic.export.machine import export_machine as write_c
    from polydraulic.export.machine import export_name
    from polydraulic.flow.dispatch import FlowModel, build_flow
    from polydraulic.networks.model.model_file import load_models
    from polydraulic.parameters.load import load_machine

    if to not in ("c", "fmi2", "fmi3"):
        raise InputError(f"--to {to!r}: the machine can be written as c, fmi2 or fmi3")
    plant, name = load_machine(machine), export_name(machine) if name is None else name
    chosen: str | FlowModel = flow
    if model:
        if flow not in ("polynomial", "neural", "residual"):
            raise InputError(f"--model goes with --flow polynomial, neural or residual, not with {flow!r}")
        chosen = build_flow(flow, plant, models=[found for path in model for found in load_models(path)])
    with progress_bar("export-machine") as progress:
        progress(f"translate the kernels, write {out}", 0, 1)
        if to == "c":
            written = write_c(plant, chosen, out, name=name, dt=dt, force=force, stability=stability)
        else:
            written = export_machine_fmu(
                plant, chosen, out, version=int(to[-1]), name=name, dt=dt, force=force, stability=stability, cross=cross
            )
    print(written)
