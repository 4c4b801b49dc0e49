"""The command that opens a machine's cockpit."""

from typing import Annotated

import typer

from polydraulic.cli.application import app
from polydraulic.terminal import progress_bar


@app.command()
def cockpit(
    machine: Annotated[str, typer.Option(help="Parameter set by name, or a TOML file.")] = "cat215b",
    flow: Annotated[str, typer.Option(help="Flow model of the machine that is driven.")] = "exact",
    port: Annotated[int, typer.Option(help="Port of this computer; 0 takes any that is free.")] = 8642,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no browser.")] = False,
) -> None:
    """Drive a machine by hand, in a browser on this computer.

    Example: `polydraulic cockpit --machine wheel_loader`
    """
    from polydraulic.cockpit.open_cockpit import run_cockpit

    with progress_bar("cockpit") as progress:
        run_cockpit(machine, flow, port=port, browser=not no_browser, progress=progress)
