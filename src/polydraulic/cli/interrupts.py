"""Ctrl-C ends a command at once: one line, exit code 130, files whole or absent."""

import os
import signal
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from threading import Thread, current_thread, main_thread
from types import FrameType

CODE = 128 + signal.SIGINT
_PATIENCE = 1.0  # s that Python has to notice an interrupt, and to clear up


@contextmanager
def interruptible() -> Iterator[None]:
    """Let an interrupt raise SystemExit, and end the program by force where Python does not notice it in time.

    Compiled loops run for as long as they take, and Python looks at signals between them. A thread that waits for the signal itself
    ends the program; a temporary file that is left is removed by whoever writes in its place next.
    """
    if current_thread() is not main_thread():
        yield
        return
    waking, woken = socket.socketpair()
    waking.setblocking(False)
    Thread(target=_watch, args=(woken,), daemon=True).start()
    handler, before = signal.getsignal(signal.SIGINT), signal.set_wakeup_fd(waking.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, _stop)
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        signal.signal(signal.SIGINT, handler)
        waking.close()


def _stop(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a second one is not waited for
    _say()
    raise SystemExit(CODE)


def _say() -> None:
    with suppress(OSError):
        os.write(2, b"\r\x1b[2Kinterrupted\n" if os.isatty(2) else b"interrupted\n")  # in place of a progress bar


def _watch(woken: socket.socket) -> None:
    with woken:
        while found := woken.recv(1):
            if found[0] == signal.SIGINT:
                break
        else:
            return
        time.sleep(_PATIENCE)
    if signal.getsignal(signal.SIGINT) is _stop:  # it was not called
        _say()
    if sys.stderr is not None and sys.stderr.isatty():
        os.write(2, b"\x1b[?25h")  # a progress bar hides the cursor
    os._exit(CODE)
