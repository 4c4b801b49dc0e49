"""Events of a run of any layout as a solver goes: the conditions of `simulation.layout.events`, in plain arrays.

Conditions are numbered kind by kind, function by function, then one for each circuit and one for each crossover; a flag says whether one holds.
"""

from typing import Any, NamedTuple

import numpy as np

from polydraulic._kernel import driver
from polydraulic.machine.valve import spool_edges
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import CROSSOVER_CONDITION, FUNCTION_CONDITIONS, MAX_EVENTS, PUMP_CONDITION, EventLog
from polydraulic.simulation.layout.columns import fed_functions

N_KIND = len(FUNCTION_CONDITIONS)
_N_SPOOL = 2  # kinds that look at spools


class EventLimits(NamedTuple):
    """What conditions compare a state with, one of each function."""

    valve: np.ndarray  # m
    bypass: np.ndarray
    low: np.ndarray  # rad or m
    high: np.ndarray
    relief: np.ndarray  # Pa
    floor: np.ndarray


def event_limits(machine: LayoutMachine) -> EventLimits:
    """Limits of a machine's functions."""
    edges = [spool_edges(f.valve) for f in machine.functions]
    rows = [
        (*edge, f.stops.low, f.stops.high, f.line.relief, machine.tank.floor)
        for edge, f in zip(edges, machine.functions, strict=True)
    ]
    return EventLimits(*(np.array(column) for column in zip(*rows, strict=True)))


@driver
def fill_flags(x: np.ndarray, opened: np.ndarray, limits: EventLimits, flags: np.ndarray) -> None:
    """Flags of the conditions that hold at a state, a row of spools, pressures A and B, positions and rates.

    Parameters
    ----------
    x : (5 n_function,) array
    opened : (n_circuit + n_crossover,) array, m3/s
        Flows over the pumps' relief valves, then through crossovers.
    limits : EventLimits
    flags : (N_KIND n_function + n_circuit + n_crossover,) array of int
        Filled.
    """
    n = limits.valve.shape[0]
    for j in range(n):
        travel, p_a, p_b, angle = abs(x[j]), x[n + j], x[2 * n + j], x[3 * n + j]
        flags[j] = 1 if travel > limits.valve[j] else 0
        flags[n + j] = 1 if travel >= limits.bypass[j] else 0
        flags[2 * n + j] = 1 if angle <= limits.low[j] else 0
        flags[3 * n + j] = 1 if angle >= limits.high[j] else 0
        flags[4 * n + j] = 1 if p_a >= limits.relief[j] else 0
        flags[5 * n + j] = 1 if p_b >= limits.relief[j] else 0
        flags[6 * n + j] = 1 if p_a <= limits.floor[j] else 0
        flags[7 * n + j] = 1 if p_b <= limits.floor[j] else 0
    for c in range(opened.shape[0]):
        flags[N_KIND * n + c] = 1 if opened[c] > 1e-12 else 0  # below is rounding


@driver
def observe_flags(
    log: EventLog,
    had: np.ndarray,
    flags: np.ndarray,
    t0: float,
    t1: float,
    before: np.ndarray,
    after: np.ndarray,
    limits: EventLimits,
) -> None:
    """Events of a step of a solver that ends its steps at events; `had` become the flags at its end.

    Only spool edges may lie within a step: on either side of its ends, by rounding. A bound or stop that is left was left as the step
    began.
    """
    n = limits.valve.shape[0]
    for order in range(3):
        for number in range(flags.shape[0]):
            if flags[number] == had[number]:
                continue
            kind, j = number // n, number % n
            ends = flags[number] == 0 and kind < N_KIND
            if (0 if kind < _N_SPOOL else 1 if ends else 2) != order:
                continue
            t = t1
            if order == 0:
                edge = limits.valve[j] if kind == 0 else limits.bypass[j]
                x0, x1 = abs(before[j]), abs(after[j])
                share = min(max((edge - x0) / (x1 - x0), 0.0), 1.0) if x0 != x1 else 1.0
                t = t0 + (t1 - t0) * share
            elif order == 1:
                t = t0
            k = log.number[0]
            if k < MAX_EVENTS:
                log.time[k] = t
                log.code[k] = number + 1 if flags[number] == 1 else -(number + 1)
            log.number[0] = k + 1
    for number in range(flags.shape[0]):
        had[number] = flags[number]


def listed_events(log: EventLog, machine: LayoutMachine, locked: tuple[str, ...]) -> dict[str, object]:
    """Entries for a trajectory's `info`: ``events``, rows of [time in s, function or circuit, what], and ``events_dropped``."""
    found, kept = int(log.number[0]), min(int(log.number[0]), MAX_EVENTS)
    words: list[tuple[str, tuple[str, str], set[str]]] = [
        (name, words, {name}) for words in FUNCTION_CONDITIONS for name in machine.names
    ]
    words += [(c.name, PUMP_CONDITION, fed_functions(machine, c.name)) for c in machine.circuits]
    words += [(x.name, CROSSOVER_CONDITION, fed_functions(machine, x.giving)) for x in machine.crossovers]
    rows: list[list[Any]] = []
    for k in np.argsort(log.time[:kept], kind="stable"):
        code = int(log.code[k])
        where, (begins, ends), functions = words[abs(code) - 1]
        if not functions <= set(locked):
            rows.append([float(log.time[k]), where, begins if code > 0 else ends])
    return {"events": rows, "events_dropped": found - kept}
