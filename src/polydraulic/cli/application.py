"""The application that commands join, and what several of them take."""

from typing import Annotated

import typer

app = typer.Typer(
    help="Polynomial abductive networks and real-time simulation of mobile hydraulic machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)

MachineOption = Annotated[str, typer.Option(help="Parameter set by name, or a TOML file.")]
