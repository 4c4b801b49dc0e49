"""Steps at the pace of a clock: absolute deadlines, and an honest count of what could not be kept."""

import time
from collections.abc import Callable

from polydraulic.simulation.stepping.tip_load import finite_number

PATIENCE = 0.05  # s by which steps may be late and still catch up
_MOST_SLEEPS = 1000  # until a deadline: a clock that stands still ends no wait


class Pace:
    """When steps are due, and how many came too late.

    A deadline is a moment of the clock, not a pause, so that small delays are made up for. Who is later than `PATIENCE` gives up the time
    that is lost: the schedule moves on by it, it is counted as an overrun, and simulated time knows nothing of it.

    Parameters
    ----------
    speed : float
        Simulated seconds for each second of the clock; 1 is real time.
    clock : function () -> float, s
        That never goes back; by default `time.perf_counter`.
    sleep : function (seconds)

    Attributes
    ----------
    overruns : int
        How often time was given up.
    lost : float, s
        How much, in all.
    latest : float, s
        By how much a deadline was missed at worst.
    """

    def __init__(
        self,
        speed: float = 1.0,
        *,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.speed = finite_number(speed, "realtime", low=1e-6, unit="1")
        self._clock, self._sleep = clock, sleep
        self.overruns, self.lost, self.latest = 0, 0.0, 0.0
        self._origin: float | None = None  # of the clock, at simulated time 0

    @property
    def running(self) -> bool:
        """Whether there is a schedule."""
        return self._origin is not None

    def stop(self) -> None:
        """Forget the schedule, as when simulated time is set back; what was counted stays."""
        self._origin = None

    def start(self, simulated: float) -> None:
        """Begin the schedule: the simulated time `simulated`, in s, is now."""
        self._origin = self._clock() - simulated / self.speed

    def wait(self, simulated: float) -> None:
        """Sleep until a simulated time is due; note it if that is past."""
        deadline = self._deadline(simulated)
        for _ in range(_MOST_SLEEPS):
            left = deadline - self._clock()
            if left <= 0.0:
                break
            self._sleep(left)
        late = max(self._clock() - deadline, 0.0)
        self.latest = max(self.latest, late)
        if late > PATIENCE:
            assert self._origin is not None
            self.overruns, self.lost = self.overruns + 1, self.lost + late
            self._origin += late

    def report(self) -> str:
        """What could not be kept, in a line."""
        if not self.overruns:
            return f"kept pace at {self.speed:g} times real time; late by {1e3 * self.latest:.1f} ms at most"
        return f"{self.overruns} overruns: {self.lost:.3f} s given up, late by {1e3 * self.latest:.1f} ms at most"

    def _deadline(self, simulated: float) -> float:
        if self._origin is None:
            self.start(simulated)
        assert self._origin is not None
        return self._origin + simulated / self.speed
