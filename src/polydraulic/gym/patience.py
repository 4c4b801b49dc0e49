"""What takes long the first time says so: a minute of silence looks like a program that hangs."""

import logging
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 3.0  # s
_log = logging.getLogger("polydraulic")


@contextmanager
def told_if_long(what: str, patience: float = PATIENCE) -> Iterator[None]:
    """Say once what is going on if it takes longer than `patience` s: to the logger ``polydraulic``, and on a terminal in a line of its own."""
    waiting = threading.Timer(patience, _say, (what,))
    waiting.daemon = True
    waiting.start()
    try:
        yield
    finally:
        waiting.cancel()


def _say(what: str) -> None:
    _log.info(what)
    if sys.stderr is not None and sys.stderr.isatty():
        sys.stderr.write(f"polydraulic: {what}\n")
        sys.stderr.flush()
