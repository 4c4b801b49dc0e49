"""What the page wants of the simulating thread, and what that shows: one immutable tuple each way, swapped whole.

Nobody waits for the other, and nothing is queued: the latest wish counts, so that wishes are states and numbers that go up, never orders.
"""

from math import inf
from typing import Any, NamedTuple

from polydraulic.cockpit.protocol import N_AXES


class Wanted(NamedTuple):
    """What the driver wants.

    Attributes
    ----------
    seq, axes, heard
        The last sticks, -1 to 1, and when they were heard, in s of the clock.
    locked : bool
    mode, pattern : str
    resets : int
        How often a new beginning was asked for.
    payload : float, kg
    """

    seq: int = 0
    axes: tuple[float, ...] = (0.0,) * N_AXES
    heard: float = -inf
    locked: bool = True
    mode: str = "joint"
    pattern: str = "iso"
    resets: int = 0
    payload: float = 0.0


class Snapshot(NamedTuple):
    """What the machine does.

    Attributes
    ----------
    steps : int
        Since the thread began, whatever simulated time is.
    seq, time, overruns, flags
        As in a frame.
    values : bytes
        Columns as float32.
    events : tuple of (number, [time, where, what])
        The last ones.
    rate : float
        Simulated seconds for each second, of late.
    error : str
        Why the machine stands still, if it does.
    """

    steps: int = 0
    seq: int = 0
    time: float = 0.0
    overruns: int = 0
    flags: int = 0
    values: bytes = b""
    events: tuple[tuple[int, list[Any]], ...] = ()
    rate: float = 0.0
    error: str = ""
