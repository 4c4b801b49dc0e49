"""One shape of callback for everything that takes long: ``progress(what, done, total)``."""

from collections.abc import Callable

Progress = Callable[[str, int, int], object]
"""What is being done now, and how many pieces of the whole work are done, of how many at most.

It is called in the caller's thread as pieces begin or end. What it returns is ignored; what it raises ends the work.
"""


def quiet(what: str, done: int, total: int) -> None:
    """Show nothing."""
