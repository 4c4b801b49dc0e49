import numpy as np
import pytest

from polydraulic.cockpit.exercises.catalogue import Exercise
from polydraulic.cockpit.exercises.trial import DWELL, READY, Observed, Trial

DT = 5e-3


def seen(tip, *, effort=0.0, power=0.0, stop=False):
    return Observed(np.array(tip, dtype=float), effort, power, np.array([stop]))


def trial(kind, path, payload=(), tolerance=0.1):
    return Trial(Exercise("x", "x", kind, np.array(path, dtype=float), payload, tolerance), "S", DT)


def values(t):
    return {name: value for name, (value, _) in t.score().items()}


def test_a_target_waits_then_moves_and_errors_are_those_of_the_tip():
    path = [[0.0, 0.0, 0.01 * k] for k in range(101)]
    t = trial("follow", path)
    for _ in range(round(READY / DT) - 1):
        t.observe(seen([9.0, 9.0, 9.0]))
    assert values(t)["time"] == 0.0
    for k in range(101):
        assert not t.over
        t.observe(seen([0.03, 0.0, 0.01 * k], effort=0.5, power=2e3))
    assert t.done
    found = values(t)
    assert found["time"] == pytest.approx(101 * DT)
    assert (found["error_rms"], found["error_max"]) == (pytest.approx(0.03), pytest.approx(0.03))
    assert found["effort"] == pytest.approx(0.5 * 101 * DT)
    assert found["energy"] == pytest.approx(2e3 * 101 * DT)


def test_a_line_begins_at_its_start_and_ends_at_its_end():
    t = trial("line", [[4.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    t.observe(seen([5.0, 0.0, 0.0]))
    assert values(t)["time"] == 0.0
    np.testing.assert_array_equal(t.target, [4.0, 0.0, 0.0])
    for k in range(41):
        t.observe(seen([4.0 - 0.05 * k, 0.3 if k == 20 else 0.0, 0.4 if k == 20 else 0.0]))
    assert t.done
    assert values(t)["error_max"] == pytest.approx(0.5)
    assert values(t)["error_rms"] == pytest.approx(0.5 / np.sqrt(40))  # the first of them began it


def test_places_are_visited_one_after_the_other_by_staying():
    t = trial("visit", [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], (300.0, 0.0))
    stay = round(DWELL / DT)
    for _ in range(stay - 1):
        t.observe(seen([1.05, 0.0, 0.0]))
    t.observe(seen([2.0, 0.0, 0.0]))  # left too soon
    assert t.payload == 0.0
    for _ in range(stay):
        t.observe(seen([1.05, 0.0, 0.0]))
    assert t.payload == 300.0
    np.testing.assert_array_equal(t.target, [0.0, 0.0, 0.0])
    for _ in range(stay):
        t.observe(seen([0.0, 0.02, 0.0]))
    assert (t.done, t.over, t.payload) == (True, True, 0.0)
    assert values(t)["error_max"] == pytest.approx(0.05)
    assert values(t)["time"] == pytest.approx(3 * stay * DT)
    t.observe(seen([7.0, 7.0, 7.0]))
    assert values(t)["time"] == pytest.approx(3 * stay * DT)


def test_a_stop_counts_each_time_that_it_is_hit():
    t = trial("visit", [[1.0, 0.0, 0.0]], (0.0,))
    for stop in (False, True, True, False, True):
        t.observe(seen([5.0, 0.0, 0.0], stop=stop))
    assert values(t)["stops"] == 2.0


def test_an_attempt_ends_some_day(monkeypatch):
    monkeypatch.setattr("polydraulic.cockpit.exercises.trial.LONGEST", 1.0)
    t = trial("visit", [[1.0, 0.0, 0.0]], (0.0,))
    for _ in range(200):
        assert not t.over
        t.observe(seen([5.0, 0.0, 0.0]))
    assert (t.over, t.done) == (True, False)
