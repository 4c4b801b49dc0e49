"""What the page wants of the simulating thread, and what that shows: one immutable tuple each way, swapped whole.

Nobody waits for the other, and nothing is queued: the latest wish counts. So wishes are states and numbers that go up, never orders, and what
must not be lost is shown long enough for whoever looks late.
"""

from math import inf
from typing import Any, NamedTuple

from polydraulic.cockpit.protocol import N_AXES
from polydraulic.cockpit.recorded.drives import Drive


class ReplayWish(NamedTuple):
    """A drive that is to be seen again.

    Attributes
    ----------
    number : int
        Of the wish to begin.
    drive : Drive
    playing : bool
    seeks, step : int
        How often another place was asked for, and the last one.
    """

    number: int
    drive: Drive
    playing: bool = True
    seeks: int = 0
    step: int = 0


class TrialWish(NamedTuple):
    """An exercise that is to be tried: number of the wish, name of the exercise, code of the subject."""

    number: int
    name: str
    subject: str


class Wanted(NamedTuple):
    """What the driver wants.

    Attributes
    ----------
    seq, axes, heard
        The last sticks, -1 to 1, and when they were heard, in s of the clock.
    locked : bool
    mode, pattern : str
    guarded : bool
        Whether coordinated control keeps the machine from tipping.
    resets : int
        How often a new beginning was asked for.
    payload : float, kg
    faults : tuple of str
    recording : int
        Number of the drive that is to be recorded; 0 for none.
    trial : TrialWish or None
    replay : ReplayWish or None
    taken_over : int
        How often a replay was left to go on by hand from where it was.
    """

    seq: int = 0
    axes: tuple[float, ...] = (0.0,) * N_AXES
    heard: float = -inf
    locked: bool = True
    mode: str = "joint"
    pattern: str = "iso"
    guarded: bool = False
    resets: int = 0
    payload: float = 0.0
    faults: tuple[str, ...] = ()
    recording: int = 0
    trial: TrialWish | None = None
    replay: ReplayWish | None = None
    taken_over: int = 0


class Taped(NamedTuple):
    """What of a drive waits to be written: number of the drive, and of its first block; the blocks; whether they are the last ones."""

    number: int
    first: int
    blocks: tuple[str, ...]
    ended: bool


class TrialShown(NamedTuple):
    """How a trial goes: number of the wish; its exercise, subject, mode and pattern, whether tips were guarded against; its score."""

    number: int
    exercise: str
    subject: str
    mode: str
    pattern: str
    guarded: bool
    running: bool
    finished: bool
    score: dict[str, tuple[float, str]]


class ReplayShown(NamedTuple):
    """Where a replay is."""

    number: int
    name: str
    time: float  # s
    end: float
    playing: bool


class CabShown(NamedTuple):
    """What the machine does.

    Attributes
    ----------
    steps : int
        Since the thread began, whatever simulated time is.
    seq, time, overruns, flags
        As in a frame.
    values : bytes
        Columns as float32.
    rate : float
        Simulated seconds for each second, of late.
    events : tuple of (number, [time, where, what])
        The last ones.
    payload : float, kg
    faults : tuple of str
    error : tuple of (number, text)
        The last thing that could not be done.
    shadow : str
        Why there is no shadow, if one was asked for.
    taped : Taped or None
    trial : TrialShown or None
    replay : ReplayShown or None
    """

    steps: int = 0
    seq: int = 0
    time: float = 0.0
    overruns: int = 0
    flags: int = 0
    values: bytes = b""
    rate: float = 0.0
    events: tuple[tuple[int, list[Any]], ...] = ()
    payload: float = 0.0
    faults: tuple[str, ...] = ()
    error: tuple[int, str] = (0, "")
    shadow: str = ""
    taped: Taped | None = None
    trial: TrialShown | None = None
    replay: ReplayShown | None = None
