"""Events of a run: valves that open, end stops that are met, relief valves that work, lines that run empty.

Each is a condition that begins or ends. A list holds `MAX_EVENTS` at most; what is beyond is counted.
"""

from typing import NamedTuple

import numpy as np

MAX_EVENTS = 10_000
# what begins and what ends, of every function
FUNCTION_CONDITIONS = (
    ("valve opens", "valve closes"),
    ("bypass closes", "bypass opens"),
    ("low stop met", "low stop left"),
    ("high stop met", "high stop left"),
    ("line A relief opens", "line A relief closes"),
    ("line B relief opens", "line B relief closes"),
    ("line A runs empty", "line A fills"),
    ("line B runs empty", "line B fills"),
)
PUMP_CONDITION = ("pump relief opens", "pump relief closes")
CROSSOVER_CONDITION = ("crossover opens", "crossover closes")


class EventLog(NamedTuple):
    """Events as they are found; arrays that the caller owns."""

    time: np.ndarray  # (MAX_EVENTS,) s
    code: np.ndarray  # (MAX_EVENTS,) number + 1 where a condition begins, -(number + 1) where it ends
    number: np.ndarray  # (1,), beyond MAX_EVENTS if there were more


def new_log() -> EventLog:
    """Return an empty log."""
    return EventLog(np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, dtype=np.int64), np.zeros(1, dtype=np.int64))
