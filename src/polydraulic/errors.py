"""Errors that a user can fix.

Every message names the thing, the value, what is allowed, and what to do. The command line shows these messages
without a traceback; any other exception is a defect of the package.
"""

from typing import Any

_SHOWN = 60  # letters of a value in a message


class InputError(ValueError):
    """A file, table, name or number given by the user cannot be used."""


class SimulationError(RuntimeError):
    """A simulation cannot go on: a state left the range in which the model is meaningful."""


def briefly(value: Any) -> str:
    """A value as it stands in a message, cut where it is long; Python does not write out integers of thousands of digits."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):
        return f"{type(value).__name__} of more digits or levels than can be shown"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
