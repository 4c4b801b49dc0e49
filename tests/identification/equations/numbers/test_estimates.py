"""What is said of numbers: which are determined, and against what the others trade."""

import numpy as np
import pytest

from polydraulic.identification.equations.numbers.estimates import correlation_of, estimates_of


def told(information, spreads):
    covariance = np.linalg.inv(information + np.diag(1.0 / spreads**2))
    return estimates_of(
        ["a", "b", "c"], np.array([1.0, 2.0, 3.0]), covariance, spreads, correlation_of(information, spreads)
    )


def test_a_sum_that_is_seen_lets_its_parts_trade():
    spreads = np.array([1.0, 1.0, 1.0])
    found = told(1e6 * np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), spreads)
    assert [number.determined for number in found.numbers] == [False, False, True]
    assert found.trades == ("a trades against b (falls with it)", "b trades against a (falls with it)")
    assert found.of("c").sd == pytest.approx(1e-3, rel=1e-3)


def test_what_nothing_shows_keeps_the_spread_of_its_prior():
    found = told(np.diag([0.0, 1e4, 1e4]), np.array([2.0, 2.0, 2.0]))
    assert found.of("a").sd == pytest.approx(2.0)
    assert found.trades == ("a hardly shows in this log",)


def test_an_interval_holds_nine_tenths_of_a_normal_distribution():
    number = told(np.diag([0.0, 1e4, 1e4]), np.ones(3)).of("a")
    draws = number.value + number.sd * np.random.default_rng(0).normal(size=20_000)
    assert np.mean((number.low < draws) & (draws < number.high)) == pytest.approx(0.9, abs=0.01)
