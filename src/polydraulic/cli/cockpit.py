"""The command that opens a machine's cockpit, and what comes of recorded drives."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import MachineOption, app, say_written
from polydraulic.terminal import progress_bar


@app.command()
def cockpit(
    machine: MachineOption = "cat215b",
    flow: Annotated[str, typer.Option(help="Flow model of the machine that is driven.")] = "exact",
    shadow: Annotated[
        str | None,
        typer.Option(help="A second flow model that does the same beside it: how far its tip is away is shown."),
    ] = None,
    model: Annotated[
        list[Path] | None,
        typer.Option(
            help="Model file of networks for the flow model or the shadow, whichever is polynomial or neural; repeat for more."
        ),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(
            help="Study file, .toml: who tries which exercises in which modes, in which order; results become one table."
        ),
    ] = None,
    port: Annotated[int, typer.Option(help="Port, on this computer alone; 0 takes any that is free.")] = 8642,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the URL, and open no browser.")] = False,
    record: Annotated[Path, typer.Option(help="Folder for recordings and results, made when there are some.")] = Path(
        "cockpit"
    ),
) -> None:
    """Drive a machine by hand, in a browser on this computer: levers, views, instruments, exercises, recordings.

    Example: `polydraulic cockpit --machine wheel_loader`

    - The networks beside the exact circuits: `polydraulic cockpit --machine cat215b --shadow polynomial`

    - Networks of your own, which `train` or `fit-machine` has learnt: `polydraulic cockpit --machine wheel_loader --shadow polynomial --model
    loader.json`

    - A study with people: `polydraulic cockpit --machine wheel_loader --study modes.toml --record study`

    - Without a browser of its own, on another port: `polydraulic cockpit --no-browser --port 8700`

    The machine is locked until the driver unlocks it, and stands still when levers are let go. The page is for this computer alone, and needs no
    network. What comes next: record a drive, and `polydraulic cockpit-export` makes a scenario and a log of it.
    """
    from polydraulic.cockpit.open_cockpit import ready_cockpit, serve

    def say(line: str) -> None:
        print(line, flush=True)

    with progress_bar("cockpit") as progress:
        ready = ready_cockpit(
            machine,
            flow,
            shadow=shadow,
            models=model or (),
            study=study,
            port=port,
            folder=record,
            say=say,
            progress=progress,
        )
    serve(ready, browser=not no_browser, say=say)


@app.command("cockpit-export")
def cockpit_export(
    drive: Annotated[Path, typer.Argument(help="Recorded drive, .drive.jsonl, from the cockpit's folder.")],
    scenario: Annotated[
        Path | None, typer.Option(help="Scenario to write, .toml; its levers are written beside it, .csv.")
    ] = None,
    log: Annotated[Path | None, typer.Option(help="Log to write, .csv or .parquet (SI).")] = None,
    raster: Annotated[float, typer.Option(help="Of the log, in s; a whole number of steps of 5 ms.")] = 0.01,
    model: Annotated[
        list[Path] | None,
        typer.Option(help="Model file of networks with which the drive was recorded; repeat for more."),
    ] = None,
) -> None:
    """Make a scenario and a log of a drive that was recorded in the cockpit.

    The drive is driven once more, bit for bit. A scenario begins at the drive's last reset; drives with faults, or without a reset, give logs alone.

    Example: `polydraulic cockpit-export cockpit/20261129-101500-cat215b.drive.jsonl --scenario drive.toml --log drive.csv`

    What comes next: `polydraulic simulate drive.toml` does the same with any flow model; `polydraulic import --suggest drive.csv --out map.toml`
    begins what leads to `polydraulic identify`.
    """
    from polydraulic.cockpit.recorded.drives import read_drive
    from polydraulic.cockpit.recorded.export import export_drive

    found = read_drive(drive)
    with progress_bar("cockpit-export") as progress:
        export_drive(found, scenario=scenario, log=log, raster=raster, models=model or (), progress=progress)
    seconds = found.end * found.head["dt"]
    print(f"{drive}: {seconds:.2f} s" + ("" if found.whole else "; it was not ended: up to what was written"))
    say_written(scenario, log)
