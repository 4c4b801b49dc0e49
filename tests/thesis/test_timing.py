"""Ratios of run times on a clock of our own, with load on the machine whenever a test wants it."""

import pytest

from polydraulic import build_flow, load_scenario
from polydraulic.thesis import timing
from polydraulic.thesis.timing import Ratio, Turns, in_turn, time_runs, timed


class Clock:
    """Seconds that pass only while something works, slower under load: `load(turn, name)` says how much."""

    def __init__(self, load=lambda turn, name: 1.0):
        self.now, self.load, self.made = 0.0, load, []

    def __call__(self):
        return self.now

    def call(self, name, seconds):
        def work():
            turn = self.made.count(name)
            self.made.append(name)
            self.now += seconds * self.load(turn, name)  # the turn that does not count is turn 0
            return name

        return work


def timed_pair(load, turns=31):
    clock = Clock(load)
    return in_turn({"a": clock.call("a", 1.0), "b": clock.call("b", 1.7)}, turns=turns, clock=clock)


def test_calls_take_turns_and_the_first_does_not_count():
    clock = Clock(lambda turn, name: 1000.0 if turn == 0 else 1.0)
    found = in_turn({"a": clock.call("a", 1.0), "b": clock.call("b", 1.7)}, turns=3, clock=clock)
    assert clock.made == ["a", "b"] * 4
    assert found.seconds == {"a": pytest.approx([1.0] * 3), "b": pytest.approx([1.7] * 3)}
    assert found.ratio("b", "a") == pytest.approx((1.7, 1.7, 1.7))
    assert found.ratio("a", "b").median == pytest.approx(1.0 / 1.7)


def test_a_burst_disturbs_pairs_and_leaves_the_ratio():
    def burst(turn, name):  # begins between a and b of turn 8, ends between a and b of turn 15
        return 3.0 if (8, "b") <= (turn, name) <= (15, "a") else 1.0

    found = timed_pair(burst)
    assert sorted(b / a for a, b in zip(*found.seconds.values(), strict=True))[::30] == pytest.approx([1.7 / 3, 5.1])
    assert found.ratio("b", "a") == pytest.approx((1.7, 1.7, 1.7))


def test_load_that_comes_halfway_does_not_triple_the_ratio():
    found = timed_pair(lambda turn, name: 3.0 if (turn, name) >= (16, "b") else 1.0)
    assert found.median("b") / found.median("a") == pytest.approx(5.1)  # what medians by themselves make of it
    assert found.ratio("b", "a").median == pytest.approx(1.7)


def test_a_machine_that_slows_down_all_the_time_leaves_the_ratio():
    found = timed_pair(lambda turn, name: 1.1**turn)
    assert found.median("a") == pytest.approx(1.1**16)
    assert found.ratio("b", "a") == pytest.approx((1.7, 1.7, 1.7))


def test_quartiles_show_that_pairs_are_disturbed():
    found = timed_pair(lambda turn, name: 2.0 if (name, turn % 3) in (("b", 0), ("a", 1)) else 1.0, turns=30)
    assert found.ratio("b", "a") == pytest.approx((1.7, 0.85, 3.4))


def test_times_of_a_unit_of_work():
    found = Turns({"a": [2.0, 4.0, 6.0], "b": [30.0, 10.0, 20.0]})
    assert found.per(2.0).seconds == {"a": [1.0, 2.0, 3.0], "b": [15.0, 5.0, 10.0]}
    each = found.per({"a": 2.0, "b": 10.0})
    assert (each.median("a"), each.median("b")) == (2.0, 2.0)
    assert each.ratio("b", "a").median == pytest.approx(2.0 / 3.0)


def test_one_long_call_gives_its_result_and_its_seconds():
    clock = Clock()
    assert timed(clock.call("a", 1.7), clock) == ("a", 1.7)


@pytest.mark.parametrize(
    ("ratio", "text"),
    [
        (Ratio(1.694, 1.66, 1.7449), "1.69 (1.66 to 1.74)"),
        (Ratio(0.0153, 0.01, 0.02), "0.0153 (0.0100 to 0.0200)"),
        (Ratio(990.0, 101.4, 1234.5), "990 (101 to 1234)"),
    ],
)
def test_ratios_are_printed_with_three_digits_and_their_quartiles(ratio, text):
    assert str(ratio) == text


def test_runs_of_a_scenario_take_turns(machine, monkeypatch):
    made = []
    monkeypatch.setattr(
        timing, "run", lambda model, memory, plant, x0, voltage, *others: made.append((model, len(voltage)))
    )
    models = {"exact": build_flow("exact", machine), "iterative": build_flow("iterative", machine)}
    found = time_runs(machine, models, load_scenario("sine"), turns=2)
    assert made == [(model, 2600) for model in models.values()] * 3
    assert {name: len(values) for name, values in found.seconds.items()} == {"exact": 2, "iterative": 2}
