"""Run times as ratios that hold on a busy machine.

Calls take turns (A B A B ...), each turn gives one ratio, and the median of these ratios counts, with their quartiles as the
spread. Whatever slows the machine down for longer than a turn slows both calls of a pair and leaves their ratio; whatever is
shorter disturbs a few pairs, which a median ignores and the quartiles show. The ratio of two medians has neither property.

Which clock:

- `thread_time`, the default: processor time of the calling thread. Other programs that take the processor away do not count; what
  they do to shared caches and clock rates is left to the pairs. It sees nothing of work in other threads: limit BLAS to one.
- `process_time`: the same over all threads of this process, for calls that hand their work to a thread.
- `perf_counter`, elapsed time, where what threads gain is the question. Neighbours count in full: look at the quartiles.
"""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from statistics import median
from time import perf_counter, thread_time
from typing import Any, NamedTuple, TypeVar

import numpy as np

from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Machine
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange

CLOCK = thread_time if os.name == "posix" else perf_counter  # Windows counts a thread's time in ticks of 16 ms
TURNS = 31
TURNED = f"medians of {TURNS} interleaved repetitions, ratios with quartiles"  # what tables say of their times

T = TypeVar("T")


class Ratio(NamedTuple):
    """Median and quartiles of the ratios of all pairs."""

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        middle, low, high = (f"{value:.0f}" if value >= 1000.0 else f"{value:#.3g}".rstrip(".") for value in self)
        return f"{middle} ({low} to {high})"


@dataclass(frozen=True)
class Turns:
    """What each call took in each turn.

    Attributes
    ----------
    seconds : dict from name to list of float
        Entries of one place are of one turn.
    """

    seconds: dict[str, list[float]]

    def median(self, name: str) -> float:
        """Median time of a call."""
        return median(self.seconds[name])

    def per(self, work: float | Mapping[str, float]) -> "Turns":
        """Times of a unit of work, such as a step: of `work` units in every call, or of its own number in each."""
        counts = work if isinstance(work, Mapping) else dict.fromkeys(self.seconds, work)
        return Turns({name: [value / counts[name] for value in values] for name, values in self.seconds.items()})

    def ratio(self, name: str, base: str) -> Ratio:
        """How many times as long `name` takes as `base`, turn by turn."""
        ratios = np.divide(self.seconds[name], self.seconds[base])
        low, middle, high = np.quantile(ratios, (0.25, 0.5, 0.75)).tolist()
        return Ratio(middle, low, high)


def in_turn(
    calls: Mapping[str, Callable[[], object]],
    *,
    turns: int = TURNS,
    clock: Callable[[], float] = CLOCK,
) -> Turns:
    """Time calls that take turns, after one turn that compiles and does not count.

    Parameters
    ----------
    calls : dict from name to function
        Called without arguments. What they compute must come out of them, or a compiler may leave it undone.
    turns : int
    clock : function
        Gives seconds; see the module's text for which one.
    """
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for call in calls.values():
        call()
    for _ in range(turns):
        for name, call in calls.items():
            seconds[name].append(timed(call, clock)[1])
    return Turns(seconds)


def timed(call: Callable[[], T], clock: Callable[[], float] = CLOCK) -> tuple[T, float]:
    """Result and seconds of one call, for calls that are too long to be made again and again."""
    start = clock()
    result = call()
    return result, clock() - start


def time_runs(
    machine: Machine, models: Mapping[str, Any], scenario: Scenario, *, turns: int = TURNS, dt: float = 5e-3
) -> Turns:
    """Time the loop over a whole scenario with each flow model; s."""
    arranged = {name: arrange(machine, model, scenario, dt=dt) for name, model in models.items()}
    return in_turn({name: partial(run, *a) for name, a in arranged.items()}, turns=turns)
