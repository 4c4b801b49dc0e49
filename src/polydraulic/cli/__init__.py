"""The command line: thin, and importing what a command needs only when it runs."""

import atexit
import errno
import gc
import os
import sys
import warnings
from contextlib import suppress

from polydraulic.cli import (  # noqa: F401  # their commands join the application
    cockpit,
    dynamic,
    faults,
    identify,
    lifting,
    logs,
    machine,
    machine_export,
    machines,
    networks,
    report,
    watch,
)
from polydraulic.cli.application import app
from polydraulic.cli.interrupts import interruptible
from polydraulic.errors import InputError, SimulationError

__all__ = ["app", "main"]
# objects until cycles among them are looked for: with Python's 700, that takes a sixth of a short run, which is imports above all
_GARBAGE = 5000
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # files that are written elsewhere have a name


def main() -> None:
    """Run the command line; what a user, or whoever keeps the computer, can fix is one line and exit code 2."""
    warnings.formatwarning = _one_line
    gc.set_threshold(_GARBAGE)
    atexit.register(gc.freeze)  # the system takes all memory back at once; Python would look through all objects, twice
    with interruptible():
        message = ""
        code: int | str | None = 0
        try:
            app()
        except SystemExit as stop:
            code = stop.code
        except (InputError, SimulationError) as error:
            message, code = str(error), 2
        except MemoryError:
            message, code = "not enough memory: ask for fewer rows or a larger time step", 2
        except OSError as error:
            printed = error.filename is None and error.errno in _FULL
            where = "cannot write to the standard output" if printed else error.filename
            message, code = (f"{where}: " if where else "") + (error.strerror or str(error)), 2
        unwritten = _unwritten()
        if isinstance(unwritten, BrokenPipeError):  # whoever read has seen enough
            message, code = "", 1
        elif unwritten is not None:
            message, code = f"cannot write to the standard output: {unwritten.strerror}", 2
        if message:
            with suppress(OSError):
                print(f"error: {message}", file=sys.stderr, flush=True)
        sys.exit(code)


def _one_line(message: Warning | str, *where: object, **more: object) -> str:
    return f"warning: {message}\n"


def _unwritten() -> OSError | None:
    """Why what was printed cannot be written; None if it is."""
    failed = None
    for stream in (sys.stdout, sys.__stdout__):
        try:
            if stream is not None:
                stream.flush()
        except OSError as error:
            failed = error
    if failed is not None and sys.__stdout__ is not None:
        with suppress(OSError, ValueError):  # Python writes it once more at its end, which must not fail again
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())
    return failed
