"""Bounds of single operations in `float`, held to rational numbers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.errors import InputError
from polydraulic.export.c.rounded import _LOGISTIC, Rounded, constant
from polydraulic.export.c.rounded import given as read

UNIT = 2.0**-24
number = st.floats(-1.0, 1.0, width=32)
power = st.integers(-40, 36)


def single(value):
    """A rational number rounded to the nearest float; what rounding to double before does is far less than the bounds allow."""
    return Fraction(float(np.float32(float(value))))


def holds(bound, computed, exact):
    inside = Fraction(float(bound.low[0])) <= computed <= Fraction(float(bound.high[0]))
    return inside and abs(computed - exact) <= Fraction(float(bound.error[0]))


@given(st.lists(st.tuples(number, power, number), min_size=4, max_size=4), st.booleans())
def test_sums_and_products_are_as_close_as_said_fused_or_not_flushed_or_not(numbers, flushed):
    values, bounds, exact = [], [], []
    for mantissa, exponent, off in numbers:
        value = float(np.float32(mantissa * 10.0**exponent))
        values.append(Fraction(value))
        bounds.append(Rounded(*(np.array([part]) for part in (value, value, abs(value) * 1e-7))))
        exact.append(Fraction(value) + Fraction(abs(value) * 1e-7) * Fraction(off))
    a, b, c, d = bounds
    bound = a * b + c * d

    def stored(value):
        near = single(value)
        return Fraction(0) if flushed and abs(near) < Fraction(2) ** -126 else near

    truth = exact[0] * exact[1] + exact[2] * exact[3]
    products = values[0] * values[1], values[2] * values[3]
    if np.isinf(bound.error[0]):
        size = max(abs(float(part)) for part in (*products, sum(products)))
        assert size > 3e38
        return
    for first, second in (
        (stored(products[0]), stored(products[1])), (products[0], stored(products[1])), (stored(products[0]), products[1])
    ):  # fmt: skip
        assert holds(bound, stored(first + second), truth)


def test_numbers_in_the_code_are_off_by_what_rounding_them_takes():
    tenth = constant(0.1)
    assert tenth.low[0] == tenth.high[0] == float(np.float32(0.1))
    assert tenth.error[0] == abs(0.1 - float(np.float32(0.1)))
    assert constant(0.5).error[0] == 0.0
    with pytest.raises(InputError, match="does not fit into a float"):
        constant(1e39)


def test_zeros_take_no_rounding_and_hide_no_overflow():
    one = Rounded(np.array([1.0]), np.array([1.0]), np.array([0.0]))
    assert (one + 0.0).error[0] == 0.0
    assert (one * 0.0).error[0] == 0.0
    assert (one * 1.5).error[0] == 0.0  # one of them is a power of two
    assert (one * 1.5 * 1.5).error[0] > 0.0
    large = Rounded(np.array([1e30]), np.array([1e30]), np.array([0.0]))
    with np.errstate(invalid="ignore"):  # as in the search that calls it
        assert np.isinf((large * 1e10).error[0])
        assert np.isinf((large * 1e10 * 0.0 + one).error[0])


def test_inputs_that_are_not_normal_may_count_as_zero():
    tiny = read(np.array([1e-39]), np.array([2e-39]))
    assert tiny.low[0] <= 0.0
    assert tiny.error[0] >= 2e-39
    assert read(np.array([1.0]), np.array([2.0])).error[0] == 0.0


def test_the_exponential_of_the_code_is_as_close_as_its_bound_assumes():
    # Literals of `export.c.network`, in double precision: what the rational function alone is off by.
    r = np.linspace(-0.347, 0.347, 200001)
    z = r * r
    c = r - z * (float(np.float32(1.66666254e-01)) + z * float(np.float32(-2.76673329e-03)))
    assert np.abs((1.0 + r + r * c / (2.0 - c)) / np.exp(r) - 1.0).max() < 0.2 * UNIT
    high, low = (float(np.float32(v)) for v in (0.693145752, 1.42860677e-06))
    assert abs(high + low - np.log(2.0)) < 1e-12
    assert (high * 2.0**15) % 1.0 == 0.0  # so that its product with a whole number below 512 is exact
    assert _LOGISTIC > 3.0 * UNIT
