"""What is said of numbers: which are determined, and against what the others trade."""

import numpy as np
import pytest

from polydraulic.identification.equations.numbers.estimates import correlation_of, estimates_of, left_out, unhidden


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


@pytest.mark.parametrize(
    ("sd", "determined", "hidden"),
    [(0.999, True, False), (1.0, False, False), (1.8, False, False), (1.801, False, True)],
)
def test_half_of_the_prior_is_determined_and_nine_tenths_are_hidden(sd, determined, hidden):
    spread = 2.0
    (number,) = estimates_of(["a"], np.zeros(1), np.array([[sd * sd]]), np.array([spread]), np.eye(1)).numbers
    assert number.sd == pytest.approx(sd, rel=1e-12)
    assert (number.determined, number._replace(sd=sd).hidden) == (determined, hidden)


def test_a_number_trades_against_three_others_that_go_with_it_by_nine_tenths():
    correlation = np.eye(6)
    correlation[0] = [1.0, 0.9, -0.901, 0.95, 0.93, -0.99]
    found = estimates_of(list("abcdef"), np.zeros(6), np.eye(6), np.ones(6), correlation)
    assert found.trades[0] == "a trades against f (falls with it), d (rises with it), e (rises with it)"
    correlation[0, 3:] = 0.5
    few = estimates_of(list("abcdef"), np.zeros(6), np.eye(6), np.ones(6), correlation)
    assert few.trades[:2] == ("a trades against c (falls with it)", "b hardly shows in this log")


@pytest.mark.parametrize(("numbers", "factor"), [(0.0, 1.0), (10.0, 2.0), (18.0, 10.0), (19.0, 10.0), (40.0, 10.0)])
def test_pulls_on_a_solution_hide_their_share_and_a_tenth_is_always_seen(numbers, factor):
    assert unhidden(20, numbers) == pytest.approx(factor)


def test_parts_that_are_left_out_say_how_far_a_solution_moves():
    rng = np.random.default_rng(1)
    rows, prior = rng.normal(size=(8, 5, 2)), np.diag([0.1, 0.2])
    right = np.einsum("pmn,n->pm", rows, [1.0, -2.0]) + rng.normal(size=(8, 5))

    def solved(parts):
        a, b = rows[parts].reshape(-1, 2), right[parts].reshape(-1)
        return np.linalg.solve(a.T @ a + prior, a.T @ b)

    everything = solved(np.arange(8))
    without = np.array([solved(np.delete(np.arange(8), k)) for k in range(8)])
    gram = np.swapaxes(rows, 1, 2) @ rows
    gradient = np.einsum("pmn,pm->pn", rows, rows @ everything - right)
    assert np.allclose(left_out(gram, gradient, prior), np.cov(without.T, ddof=0) * 7.0, rtol=1e-9)


def test_a_number_that_few_parts_show_is_less_sure_than_pulls_as_they_are_say():
    rng, found = np.random.default_rng(2), []
    gram = np.geomspace(1.0, 300.0, 6)[:, None, None]  # the last part shows most of it
    for _ in range(4000):
        right = gram[:, :, 0] * 3.0 + np.sqrt(gram[:, :, 0]) * rng.normal(size=(6, 1))
        value = right.sum() / gram.sum()
        gradient = gram[:, :, 0] * value - right
        found.append(
            [value - 3.0, left_out(gram, gradient, np.zeros((1, 1)))[0, 0], (gradient**2).sum() / gram.sum() ** 2]
        )
    error, ours, plain = (
        np.mean(np.square(found), axis=0)[0],
        np.mean(np.transpose(found)[1]),
        np.mean(np.transpose(found)[2]),
    )
    assert plain * unhidden(6, 1.0) < 0.7 * error
    assert ours > 0.9 * error
