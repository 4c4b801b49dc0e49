"""How many steps there are until a time, an event or a condition."""

from collections.abc import Callable
from math import ceil
from typing import Any

from polydraulic.errors import InputError
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.stepping.noted import event_words
from polydraulic.simulation.stepping.tip_load import finite_number
from polydraulic.simulation.steps import MOST_STEPS


def steps_until(
    until: float | str | Callable[[Any], bool], limit: float, machine: LayoutMachine, now: float, dt: float
) -> tuple[int, str | None, bool]:
    """Steps that are made at most, the event that is waited for, and whether the end is a time.

    Parameters
    ----------
    until, limit
        As for `Simulator.run_until`.
    machine : LayoutMachine
    now, dt : float, s

    Raises
    ------
    InputError
        A time that has passed, or is too far, an event that cannot be, a limit that is no time.
    """
    event = until if isinstance(until, str) else None
    if event is not None and event not in (words := event_words(machine)):
        raise InputError(f"until = {event!r}: no such event; there are {sorted(words)}")
    timed = not (event or callable(until))
    span = (
        finite_number(until, "until", low=None, unit="s") - now
        if timed
        else finite_number(limit, "limit", low=0.0, unit="s")
    )
    if span < -1e-9 * max(now, 1.0):
        raise InputError(f"until = {until} s: has passed, it is {now:g} s; `reset` begins anew")
    left = ceil(span / dt - 1e-9)
    if left > MOST_STEPS:
        raise InputError(
            f"{span:g} s are {left:.3g} steps of {dt} s; at most {MOST_STEPS:g} are made: run a shorter time"
        )
    return left, event, timed
