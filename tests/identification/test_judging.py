"""Errors on rows held out, and intervals: which half sets them, which half says whether they hold, at what rank."""

import re
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from polydraulic.identification.judging import HeldOut, errors_by_region, errors_of, judged
from polydraulic.networks import Model, Network, Split, Variable
from polydraulic.networks.model.table import Node

FLAT = Network((), (0.0,), (1.0,), (-1.0,), (1.0,), 0.0, 1.0)


def model(regions=1):
    partition = Split(0, 0.0, 0, 1) if regions == 2 else 0
    return Model((Variable("a", "m"),), Variable("y", "V"), (FLAT,) * regions, partition)


def fit_of(errors, *, by_time=False, a=0.0, regions=1):
    """The fit of a model that errs by so much on rows held out, at `a`."""
    errors = np.asarray(errors, dtype=float)
    X = (a + np.zeros(len(errors)))[:, None]
    y = 8.0 * np.arange(len(errors))  # so that differences are exact
    return judged(model(regions), HeldOut(X, y, y + errors, by_time), 500)


def test_errors_are_measured_by_their_squares_next_to_the_spread():
    assert errors_of(np.array([0.0, 2.0, 4.0, 6.0]), np.array([1.0, 1.0, 5.0, 5.0])) == (0.8, 1.0, 1.0)
    assert errors_of(np.array([0.0, 2.0]), np.array([-3.0, 3.0])) == (-4.0, 5.0**0.5, 3.0)
    assert errors_of(np.ones(2), np.array([1.0, 2.0])) == (0.0, 0.5**0.5, 1.0)  # nothing to explain
    assert errors_of(np.ones(2), np.ones(2)) == (0.0, 0.0, 0.0)
    for size in (1e-300, 1e-160, 1e150):  # squares of the first two are no numbers
        scaled = errors_of(size * np.array([0.0, 2.0, 4.0, 6.0]), size * np.array([1.0, 1.0, 5.0, 5.0]))
        assert scaled == pytest.approx((0.8, size, size), rel=1e-12, abs=0.0)


def test_a_region_without_rows_has_no_errors():
    found = errors_by_region(model(2), np.full((2, 1), -0.5), np.array([3.0, -4.0]))
    assert [tuple(r.values()) for r in found] == [("a in (-inf, 0]", 2, 12.5**0.5, 4.0), ("a in (0, inf)", 0, 0.0, 0.0)]
    assert list(found[0]) == ["region", "rows", "rms", "largest"]


@pytest.mark.parametrize(("n", "rank"), [(9, 9), (10, 10), (19, 18), (29, 27)])
def test_intervals_hold_nine_of_ten(n, rank):
    """Every second row sets them by its rank among one more than there are; the others say whether they hold."""
    sizes = np.zeros(2 * n)
    sizes[::2] = -np.random.default_rng(0).permutation(n) - 1.0
    sizes[1::2] = np.where(np.arange(n) % 3 > 0, rank, rank + 0.5)  # the ends belong to the interval
    fit = fit_of(sizes)
    assert fit.half_widths == [rank]
    assert fit.covered == np.mean(np.arange(n) % 3 > 0)
    said = fit.model.training
    assert (said["interval_level"], said["interval_half_widths"], said["interval_covered"]) == (
        0.9,
        [rank],
        fit.covered,
    )
    assert (said["rows"], said["held_out"]) == (500, "every fifth row")
    assert (said["held_out_rms"], said["held_out_largest"]) == (fit.rms, fit.largest)


def test_of_blocks_of_time_the_first_and_third_quarter_set_intervals():
    sizes = np.repeat([1.0, 3.0, 2.0, 1.5], 20)
    fit = fit_of(sizes, by_time=True)
    assert (fit.half_widths, fit.covered, fit.model.training["held_out"]) == ([2.0], 0.5, "blocks of time")


@pytest.mark.parametrize(("own", "width"), [(9, 1.0), (8, 5.0)])
def test_a_region_with_too_few_rows_has_the_interval_of_all(own, width):
    low = np.arange(100) < 2 * own
    fit = fit_of(np.where(low, 1.0, 5.0), a=np.where(low, -0.5, 0.5), regions=2)
    assert fit.half_widths == [width, 5.0]
    assert [r["rows"] for r in fit.model.training["held_out_by_region"]] == [2 * own, 100 - 2 * own]


def test_too_few_rows_state_no_interval():
    assert (fit_of(np.ones(17)).half_widths, fit_of(np.ones(16)).half_widths) == ([1.0], [inf])
    assert fit_of(np.ones(16)).model.training["interval_half_widths"] == []


@pytest.mark.parametrize(
    ("r2", "y", "doubt"),
    [
        (0.01, [0.0, 1.0], ""),
        (
            0.0,
            [0.0, 1.0],
            "y: nothing was learnt from 500 rows that helps on others: .* held out \\(R2 0\\); give more rows",
        ),
        (-2.5, [0.0, 1.0], "held out \\(R2 -2.5\\); give more rows"),
        (-2.5, [1.0, 1.0], ""),  # rows held out that tell nothing
    ],
)
def test_a_model_that_errs_no_less_than_the_mean_is_doubted(r2, y, doubt):
    fit = fit_of(np.ones(20))
    assert "of 500 rows no network explains more" in fit.doubt  # a constant
    grown = replace(fit.model, networks=(replace(FLAT, nodes=(Node(0, (0,), (0.0, 1.0)),)),))
    found = fit._replace(model=grown, r2=r2, held=fit.held._replace(y=np.array(y))).doubt
    assert re.search(doubt, found) if doubt else found == ""
