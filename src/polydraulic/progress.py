"""One shape of callback for everything that takes long."""

from typing import Protocol


class Progress(Protocol):
    """A function ``progress(what, done, total)`` that long work calls as its pieces begin or end.

    It is told what is being done, and how many pieces of the whole work are done, and of how many at most. It is called in the caller's
    thread; what it returns is ignored, and what it raises ends the work.

    Examples
    --------
    >>> from polydraulic import simulate_batch
    >>> batch = simulate_batch("cat215b", "exact", "single_08", t_end=0.01, progress=print)
    simulate 1 1
    """

    def __call__(self, what: str, done: int, total: int, /) -> object:
        """Tell that `done` of `total` pieces are done, and `what` is being done."""


def quiet(what: str, done: int, total: int) -> None:
    """Show nothing."""
