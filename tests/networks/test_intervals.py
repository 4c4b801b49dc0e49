"""Split-conformal intervals: the exact rank, against its definition."""

from fractions import Fraction
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.networks.intervals import half_width, stated_half_width

LEVELS = st.integers(1, 99).map(lambda percent: percent / 100)


def share_covered(sizes, coverage):
    """Each of the errors in turn as that of a new row, the others as held out: the share that lies in the interval."""
    inside = [size <= half_width(np.delete(sizes, place), coverage) for place, size in enumerate(sizes)]
    return Fraction(sum(map(bool, inside)), len(sizes))


@given(st.integers(1, 120), LEVELS, st.integers(0, 9))
def test_a_new_row_is_covered_with_the_stated_probability_and_no_more_than_a_rank(n, coverage, seed):
    sizes = np.random.default_rng(seed).permutation(n + 1).astype(float)  # no two alike
    covered, asked = share_covered(sizes, coverage), Fraction(str(coverage))
    assert asked <= covered < asked + Fraction(1, n + 1)


@given(st.integers(0, 300), LEVELS)
def test_the_width_is_the_smallest_that_reaches_the_coverage(n, coverage):
    reached = [k for k in range(1, n + 1) if Fraction(k, n + 1) >= Fraction(str(coverage))]
    assert half_width(np.arange(n, 0, -1.0), coverage) == (reached[0] if reached else inf)


def test_ranks_are_those_of_the_decimal_number():
    assert 100 * 0.55 > 55.0  # floats would take one rank more
    assert half_width(np.arange(1.0, 100.0), 0.55) == 55.0
    assert half_width(np.arange(1.0, 10.0), 0.9) == 9.0
    assert half_width(np.arange(1.0, 100.0), np.float64(0.9)) == 90.0


@given(st.lists(st.sampled_from([0.0, 0.5, 1.0]), min_size=30, max_size=60), LEVELS)
def test_equal_errors_cover_at_least_as_much(sizes, coverage):
    assert share_covered(np.array(sizes), coverage) >= Fraction(str(coverage))


def test_too_few_rows_cannot_state_it():
    assert half_width(np.arange(8.0), 0.9) == inf
    assert half_width(np.zeros(0), 0.5) == inf
    assert stated_half_width(np.arange(9.0), 0.9) == 8.0
    with pytest.raises(InputError, match=r"coverage 0.9 needs at least 9 held-out rows; this model has 8: raise"):
        stated_half_width(np.arange(8.0), 0.9)
    with pytest.raises(InputError, match=r"coverage 0.95 needs at least 19 held-out rows; this model has 0"):
        stated_half_width(np.zeros(0), 0.95)


@pytest.mark.parametrize("coverage", [0.0, 1.0, -0.5, float("nan")])
def test_a_coverage_is_a_probability(coverage):
    with pytest.raises(InputError, match="must lie between 0 and 1, for example 0.9"):
        half_width(np.arange(5.0), coverage)


def test_the_order_of_the_errors_says_nothing():
    for seed in range(20):
        assert half_width(np.random.default_rng(seed).permutation(499) + 1.0, 0.9) == 450.0
