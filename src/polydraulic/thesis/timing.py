"""Run times as ratios that hold on a busy machine.

Two calls alternate (A B A B ...), each pair gives one ratio, and the median of these ratios counts, with their quartiles as the
spread. Whatever slows the machine down for longer than a pair slows both calls and leaves their ratio; whatever is shorter
disturbs a few pairs, which a median ignores and the quartiles show. The ratio of two medians has neither property. Only two calls
share the caches at a time, so that a ratio does not depend on what else is measured.

Which clock:

- `thread_time`, the default: processor time of the calling thread. Other programs that take the processor away do not count; what
  they do to shared caches and clock rates is left to the pairs. It sees nothing of work in other threads: limit BLAS to one.
- `process_time`: the same over all threads of this process, for calls that hand their work to a thread.
- `perf_counter`, elapsed time, where what threads gain is the question. Neighbours count: let both calls be equally long.
"""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from statistics import median
from time import perf_counter, thread_time
from typing import Any, NamedTuple, TypeVar

import numpy as np

from polydraulic.flow.dispatch import FlowModel
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.scenario import Scenario
from polydraulic.simulation.layout.runs import prepared_run

CLOCK = thread_time if os.name == "posix" else perf_counter  # Windows counts a thread's time in ticks of 16 ms
PAIRS = 31
PAIRED = f"medians of {PAIRS} pairs, ratios with quartiles"  # what tables say of their times
T = TypeVar("T")


class Ratio(NamedTuple):
    """Median and quartiles of the ratios of all pairs."""

    median: float
    low: float
    high: float

    def times(self, factor: float) -> "Ratio":
        """Scale by a positive factor."""
        return Ratio(*(factor * value for value in self))

    def __str__(self) -> str:
        if self == (1.0, 1.0, 1.0):
            return "1"  # the base
        middle, low, high = (f"{value:.0f}" if value >= 1000.0 else f"{value:#.3g}".rstrip(".") for value in self)
        return f"{middle} ({low} to {high})"


class Time(NamedTuple):
    """Median seconds of a call, or of one unit of its work, and how many times as long as the base it takes."""

    seconds: float
    ratio: Ratio


def ratio_of(seconds: Sequence[float], base: Sequence[float]) -> Ratio:
    """Ratio of what was measured in pairs; entries of one place are of one pair."""
    low, middle, high = np.quantile(np.divide(seconds, base), (0.25, 0.5, 0.75)).tolist()
    return Ratio(middle, low, high)


def paired_times(
    calls: Mapping[str, Callable[[], object]],
    *,
    base: str | None = None,
    pairs: int = PAIRS,
    clock: Callable[[], float] = CLOCK,
    work: Mapping[str, float] | None = None,
) -> dict[str, Time]:
    """Time each call in pairs with one of them.

    Parameters
    ----------
    calls : dict from name to function
        Called without arguments. What they compute must come out of them, or a compiler may leave it undone.
    base : str, optional
        What the others are compared with, by default the first.
    pairs : int
        Of each call with the base, after one that compiles, fills the caches and does not count.
    clock : function
        Gives seconds; see the module's text for which one.
    work : dict from name to float, optional
        Units of work of each call, such as steps: seconds and ratios are then of one unit.

    Returns
    -------
    dict from name to Time
        In the order of `calls`; the base's ratio is 1.
    """
    base = base or next(iter(calls))
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    found: dict[str, Time] = {}
    for name in calls:
        if name == base:
            continue
        first: list[float] = []
        for _ in range(pairs + 1):
            for one, kept in ((base, first), (name, seconds[name])):
                kept.append(timed(calls[one], clock)[1] / (work[one] if work else 1.0))
        del first[0], seconds[name][0]
        seconds[base] += first
        found[name] = Time(median(seconds[name]), ratio_of(seconds[name], first))
    found[base] = Time(median(seconds[base]), Ratio(1.0, 1.0, 1.0))
    return {name: found[name] for name in calls}


def paired_ratio(
    call: Callable[[], object],
    base: Callable[[], object],
    *,
    pairs: int = PAIRS,
    clock: Callable[[], float] = CLOCK,
) -> Ratio:
    """How many times as long `call` takes as `base`; parameters as for `paired_times`."""
    return paired_times({"base": base, "call": call}, pairs=pairs, clock=clock)["call"].ratio


def timed(call: Callable[[], T], clock: Callable[[], float] = CLOCK) -> tuple[T, float]:
    """Result and seconds of one call, for calls that are too long to be made again and again."""
    start = clock()
    result = call()
    return result, clock() - start


def time_runs(
    machine: LayoutMachine,
    models: Mapping[str, FlowModel],
    scenario: Scenario,
    *,
    base: str | None = None,
    pairs: int = PAIRS,
    dt: float = 5e-3,
) -> dict[str, Time]:
    """Time the loop over a whole scenario with each flow model, in pairs with that of `base`, by default the first."""
    runs = {name: prepared_run(machine, model, scenario, dt=dt) for name, model in models.items()}
    return paired_times(runs, base=base, pairs=pairs)


def restored(found: Mapping[str, Iterable[Any]]) -> dict[str, Time]:
    """Times that went through JSON."""
    return {name: Time(seconds, Ratio(*ratio)) for name, (seconds, ratio) in found.items()}
