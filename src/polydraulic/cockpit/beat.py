"""The thread that moves the machine at the pace of the clock: absolute deadlines, and a count of what could not be kept."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Event, Thread

from polydraulic.cockpit.cab import DT, Cab
from polydraulic.cockpit.protocol import N_AXES, SILENCE
from polydraulic.cockpit.wanted import Wanted

MOST_AT_ONCE = 10  # steps; those that are later are given up
_WINDOW = 1.0  # s over which the rate is told


@dataclass
class Beat:
    """A cab that is moved, and what is wanted of it.

    Attributes
    ----------
    cab : Cab
        Moved by the thread alone; others read `cab.shown`.
    wanted : Wanted
        Replaced whole by whoever serves the page.
    made, overruns : int
        Steps that were made, and that were given up.
    failed : exception or None
        What ended the thread.
    """

    cab: Cab
    clock: Callable[[], float] = time.perf_counter
    sleep: Callable[[float], None] = time.sleep
    wanted: Wanted = field(default_factory=Wanted)
    made: int = 0
    overruns: int = 0
    failed: BaseException | None = None
    _done: int = 0
    _origin: float = 0.0
    _rate: float = 0.0
    _window: tuple[float, int] = (0.0, 0)
    _ended: Event = field(default_factory=Event)
    _thread: Thread | None = None

    def start(self) -> None:
        """Begin to move."""
        self._thread = Thread(target=self._run, name="machine", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread, and wait for it."""
        self._ended.set()
        if self._thread is not None:
            self._thread.join()

    def begin(self) -> None:
        """Let the schedule begin now."""
        self._origin, self._done, self.made = self.clock(), 0, 0
        self._window = (self._origin, 0)

    def beat(self) -> float:
        """Make all steps that are due; how long until the next one, in s."""
        now = self.clock()
        due = int((now - self._origin) / DT)
        n = min(due - self._done, MOST_AT_ONCE)
        if n > 0:
            self.overruns += due - self._done - n
            self._done = due
            self.made += n
            if now - self._window[0] >= _WINDOW:
                self._rate = (self.made - self._window[1]) * DT / (now - self._window[0])
                self._window = (now, self.made)
            wanted = self.wanted
            if now - wanted.heard > SILENCE:
                wanted = wanted._replace(axes=(0.0,) * N_AXES)
            self.cab.move(wanted, n, overruns=self.overruns, rate=self._rate)
        return self._origin + (self._done + 1) * DT - self.clock()

    def _run(self) -> None:
        try:
            self.begin()
            while not self._ended.is_set():
                left = self.beat()
                if left > 0.0:
                    self.sleep(left)
        except BaseException as error:  # the thread's end must be seen
            self.failed = error
