"""Ratios of run times on a clock of our own, with load on the machine whenever a test wants it."""

import json

import pytest

from polydraulic import build_flow, load_scenario
from polydraulic.thesis import timing
from polydraulic.thesis.timing import (
    Ratio,
    Time,
    paired_ratio,
    paired_times,
    ratio_of,
    restored,
    time_runs,
    timed,
)


class Clock:
    """Seconds that pass only while something works: `load(n, name)` times as many in the n-th call of `name`."""

    def __init__(self, load=lambda n, name: 1.0):
        self.now, self.load, self.made = 0.0, load, []

    def __call__(self):
        return self.now

    def call(self, name, seconds):
        def work():
            n = self.made.count(name)  # pair 0 is the one that does not count
            self.made.append(name)
            self.now += seconds * self.load(n, name)
            return name

        return work


def ratio_under(load, pairs=31):
    """Of a call b that takes 1.7 s to a call a that takes 1 s."""
    clock = Clock(load)
    return paired_ratio(clock.call("b", 1.7), clock.call("a", 1.0), pairs=pairs, clock=clock)


def test_calls_alternate_with_the_base_and_the_first_pair_does_not_count():
    # slow: b and c when they are first called, and a each time that it meets a new partner
    clock = Clock(lambda n, name: 1000.0 if (name, n) in (("a", 0), ("a", 3), ("b", 0), ("c", 0)) else 1.0)
    calls = {"a": clock.call("a", 1.0), "b": clock.call("b", 1.7), "c": clock.call("c", 0.5)}
    found = paired_times(calls, pairs=2, clock=clock)
    assert "".join(clock.made) == "ababab" + "acacac"
    assert list(found) == ["a", "b", "c"]
    assert [time.seconds for time in found.values()] == pytest.approx([1.0, 1.7, 0.5])
    assert [time.ratio.median for time in found.values()] == pytest.approx([1.0, 1.7, 0.5])


def test_any_call_may_be_the_base():
    clock = Clock()
    calls = {"a": clock.call("a", 1.0), "b": clock.call("b", 1.7)}
    found = paired_times(calls, base="b", pairs=3, clock=clock)
    assert "".join(clock.made) == "babababa"
    assert found["a"].ratio == pytest.approx((1.0 / 1.7,) * 3)
    assert found["b"].ratio == Ratio(1.0, 1.0, 1.0)


def test_the_ratio_of_an_idle_machine():
    assert ratio_under(lambda n, name: 1.0) == pytest.approx((1.7, 1.7, 1.7))


def test_a_burst_that_splits_pairs_leaves_the_ratio():
    seen = []

    def burst(n, name):  # from between a and b of pair 8 to between a and b of pair 15
        seen.append(3.0 if (8, "b") <= (n, name) <= (15, "a") else 1.0)
        return seen[-1]

    assert ratio_under(burst) == pytest.approx((1.7, 1.7, 1.7))
    split = [(a, b) for a, b in zip(seen[::2], seen[1::2], strict=True) if a != b]
    assert split == [(1.0, 3.0), (3.0, 1.0)]


def test_load_that_comes_halfway_does_not_triple_the_ratio():
    # medians of a and of b by themselves would be 1 s and 5.1 s
    assert ratio_under(lambda n, name: 3.0 if (n, name) >= (16, "b") else 1.0) == pytest.approx((1.7, 1.7, 1.7))


def test_a_machine_that_slows_down_all_the_time_leaves_the_ratio():
    assert ratio_under(lambda n, name: 1.1**n) == pytest.approx((1.7, 1.7, 1.7))


def test_quartiles_show_that_pairs_are_disturbed():
    found = ratio_under(lambda n, name: 2.0 if (name, n % 3) in (("b", 0), ("a", 1)) else 1.0, pairs=30)
    assert found == pytest.approx((1.7, 0.85, 3.4))


def test_times_and_ratios_of_a_unit_of_work():
    clock = Clock()
    calls = {"a": clock.call("a", 10.0), "b": clock.call("b", 34.0)}
    found = paired_times(calls, pairs=3, clock=clock, work={"a": 5.0, "b": 10.0})
    assert [time.seconds for time in found.values()] == pytest.approx([2.0, 3.4])
    assert found["b"].ratio.median == pytest.approx(1.7)


def test_ratios_of_what_was_measured_elsewhere():
    assert ratio_of([2.0, 9.0, 4.0], [1.0, 3.0, 1.0]) == pytest.approx((3.0, 2.5, 3.5))


def test_one_long_call_gives_its_result_and_its_seconds():
    clock = Clock()
    assert timed(clock.call("a", 1.7), clock) == ("a", 1.7)


@pytest.mark.parametrize(
    ("ratio", "text"),
    [
        (Ratio(1.694, 1.66, 1.7449), "1.69 (1.66 to 1.74)"),
        (Ratio(0.0153, 0.01, 0.02), "0.0153 (0.0100 to 0.0200)"),
        (Ratio(990.0, 101.4, 1234.5), "990 (101 to 1234)"),
        (Ratio(5.0, 4.0, 6.0).times(0.1), "0.500 (0.400 to 0.600)"),
        (Ratio(1.0, 1.0, 1.0), "1"),
    ],
)
def test_ratios_are_printed_with_three_digits_and_their_quartiles(ratio, text):
    assert str(ratio) == text


def test_times_go_through_json():
    times = {"a": Time(0.25, Ratio(1.0, 1.0, 1.0)), "b": Time(0.5, Ratio(2.0, 1.9, 2.1))}
    again = restored(json.loads(json.dumps(times)))
    assert again == times
    assert str(again["b"].ratio) == "2.00 (1.90 to 2.10)"


def test_runs_of_a_scenario_alternate(machine, monkeypatch):
    made = []
    monkeypatch.setattr(
        timing,
        "prepared_run",
        lambda machine, model, scenario, dt: lambda: made.append((model.name, scenario.name, dt)),
    )
    models = {name: build_flow(name, machine) for name in ("iterative", "exact")}
    found = time_runs(machine, models, load_scenario("sine"), base="exact", pairs=2)
    assert made == [("exact", "sine", 5e-3), ("iterative", "sine", 5e-3)] * 3
    assert list(found) == ["iterative", "exact"]
