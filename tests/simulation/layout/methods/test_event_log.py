"""Events as a solver goes, on made states: the words and times of those in rows."""

import numpy as np

from polydraulic.simulation.events import new_log
from polydraulic.simulation.layout.methods.event_log import (
    N_KIND,
    event_limits,
    fill_flags,
    listed_events,
    observe_flags,
)


def watched(machine, states, reliefs, times):
    """Events of states one after the other, quantity by quantity."""
    n = len(machine.names)
    had, flags = np.zeros((2, N_KIND * n + len(machine.circuits)), dtype=np.int64)
    log, limits = new_log(), event_limits(machine)
    fill_flags(states[0], reliefs[0], limits, had)
    for k in range(1, len(times)):
        fill_flags(states[k], reliefs[k], limits, flags)
        observe_flags(log, had, flags, times[k - 1], times[k], states[k - 1], states[k], limits)
    return log


def test_conditions_begin_and_end_when_they_do(crane):
    """A spool passes its edges, a stop is met and left, a line runs empty, a pump's relief valve opens."""
    rest = np.concatenate([np.zeros(3), np.full(6, 2e6), [0.2, 0.5, 0.3], np.zeros(3)])
    moved, back = rest.copy(), rest.copy()
    moved[1], moved[3], moved[10] = -8e-3, 0.0, crane.function("lift").stops.high
    log = watched(
        crane, [rest, moved, moved, back], [np.zeros(2), np.array([1e-5, 0.0]), np.array([1e-5, 0.0]), np.zeros(2)],
        [0.0, 0.4, 0.5, 1.3],
    )  # fmt: skip
    found = listed_events(log, crane, ())
    assert found["events_dropped"] == 0
    times = {tuple(event[1:]): event[0] for event in found["events"]}
    assert len(times) == len(found["events"]) == 10
    assert np.isclose(times["lift", "valve opens"], 0.05)  # 1 mm of 8 mm in 0.4 s
    assert times["lift", "bypass closes"] == 0.4
    assert (
        times["lift", "high stop met"]
        == times["slew", "line A runs empty"]
        == times["main", "pump relief opens"]
        == 0.4
    )
    assert times["lift", "high stop left"] == times["slew", "line A fills"] == 0.5
    assert times["main", "pump relief closes"] == 1.3
    assert np.isclose(times["lift", "valve closes"], 1.2)
    assert [event[0] for event in found["events"]] == sorted(event[0] for event in found["events"])


def test_what_is_locked_has_no_events(crane):
    rest = np.zeros(15)
    rest[3:9], rest[10] = 2e6, 0.5
    moved = rest.copy()
    moved[0] = 8e-3
    log = watched(crane, [rest, moved], [np.zeros(2), np.array([0.0, 1e-5])], [0.0, 0.1])
    assert [event[1] for event in listed_events(log, crane, ("extend",))["events"]] == ["slew", "slew"]
    assert {event[1] for event in listed_events(log, crane, ("slew",))["events"]} == {"second"}
