"""Errors that a user can mend.

Every message names the thing, the value, what is allowed, and what to do. The command line shows these messages
without a traceback; any other exception is a defect of the package.
"""


class InputError(ValueError):
    """A file, table, name or number given by the user cannot be used."""


class SimulationError(RuntimeError):
    """A simulation cannot go on: a state left the range in which the model means anything."""
