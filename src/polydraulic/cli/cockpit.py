"""The command that opens a machine's cockpit, and what comes of recorded drives."""

from pathlib import Path
from typing import Annotated

import typer

from polydraulic.cli.application import MachineOption, app
from polydraulic.terminal import progress_bar


@app.command()
def cockpit(
    machine: MachineOption = "cat215b",
    flow: Annotated[str, typer.Option(help="Flow model of the machine that is driven.")] = "exact",
    shadow: Annotated[
        str | None,
        typer.Option(help="A second flow model that does the same beside it: how far its tip is away is shown."),
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

    - Without a browser of its own, on another port: `polydraulic cockpit --no-browser --port 8700`

    The machine is locked until the driver unlocks it, and stands still when levers are let go. The page is for this computer alone, and needs no
    network. What comes next: record a drive, and `polydraulic cockpit-export` makes a scenario and a log of it.
    """
    from polydraulic.cockpit.open_cockpit import ready_cockpit, serve

    def say(line: str) -> None:
        print(line, flush=True)

    with progress_bar("cockpit") as progress:
        ready = ready_cockpit(machine, flow, shadow=shadow, port=port, folder=record, say=say, progress=progress)
    serve(ready, browser=not no_browser, say=say)
