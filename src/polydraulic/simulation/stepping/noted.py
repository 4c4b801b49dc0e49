"""Events of a machine that is moved step by step: the words of them, and those in the pairs of rows that a call leaves."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.simulation.events import CROSSOVER_CONDITION, FUNCTION_CONDITIONS, PUMP_CONDITION
from polydraulic.simulation.layout.columns import Columns
from polydraulic.simulation.layout.events import layout_events


def event_words(machine: LayoutMachine) -> set[str]:
    """What can happen: ``"high stop met"``, and ``"boom high stop met"`` of a single function or circuit."""
    kinds: list[tuple[Sequence[str], Sequence[tuple[str, str]]]] = [
        (machine.names, FUNCTION_CONDITIONS),
        ([c.name for c in machine.circuits], (PUMP_CONDITION,)),
        ([x.name for x in machine.crossovers], (CROSSOVER_CONDITION,)),
    ]
    pairs = [(name, word) for names, words in kinds for name in names for both in words for word in both]
    return {word for _, word in pairs} | {f"{name} {word}" for name, word in pairs}


def events_between(
    machine: LayoutMachine, columns: Columns, locked: tuple[str, ...], dt: float, change: np.ndarray
) -> list[list[Any]]:
    """Events of one step, [time in s, function or circuit, what], from its number and the recorded rows before and after it."""
    rows, times = change[1:].reshape(2, -1), np.array([change[0] * dt, (change[0] + 1.0) * dt])
    found = layout_events(machine, locked, times, lambda name: rows[:, columns.place[name]])["events"]
    assert isinstance(found, list)
    return found
