"""The command line: thin, and importing what a command needs only when it runs."""

import sys

from polydraulic.cli import dynamic, logs, machine, machines, networks, report  # noqa: F401  # their commands join the application
from polydraulic.cli.application import app
from polydraulic.errors import InputError, SimulationError

__all__ = ["app", "main"]


def main() -> None:
    """Run the command line; what a user can fix is one line and exit code 2."""
    try:
        app()
    except (InputError, SimulationError) as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2)
    except MemoryError:
        print("error: not enough memory: ask for fewer rows or a larger time step", file=sys.stderr)
        sys.exit(2)
