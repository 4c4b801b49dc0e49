import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from polydraulic.elementary import direction, exp, log, sincos, sincos_of, tanh


@given(st.floats(-1e6, 1e6))
def test_sincos_is_accurate_to_the_last_bits(x):
    both = sincos(x)
    assert both.sin == pytest.approx(math.sin(x), rel=3e-16, abs=2.3e-16)
    assert both.cos == pytest.approx(math.cos(x), rel=3e-16, abs=2.3e-16)


@given(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_direction_is_accurate_to_the_last_bits(y, x):
    if abs(x) + abs(y) > 1e-290:
        assert direction(y, x) == pytest.approx(math.atan2(y, x), rel=5e-16, abs=5e-16)


@pytest.mark.parametrize("share", [0.0, 0.4375, 0.6875, 1.0, 1.5, 3.0])
@pytest.mark.parametrize(("along", "up"), [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
def test_direction_at_its_seams(share, along, up):
    for near in (share, math.nextafter(share, -1.0), math.nextafter(share, 9.0)):
        if near > 0.0 or (near == 0.0 and up > 0.0):  # it knows no negative zero
            assert direction(up * near, along) == pytest.approx(math.atan2(up * near, along), rel=5e-16, abs=0.0)
    assert direction(up, 0.0) == math.copysign(math.pi / 2.0, up)
    assert direction(0.0, 0.0) == 0.0


@given(st.floats(-700.0, 700.0))
def test_exp_is_accurate_to_the_last_bits(x):
    assert exp(x) == pytest.approx(math.exp(x), rel=5e-16)


@pytest.mark.parametrize("x", [-1e5, 1e5, math.inf, -math.inf])
def test_exp_is_limited(x):
    assert exp(x) == exp(math.copysign(700.0, x))


@given(st.floats(1e-300, 1e300))
def test_log_is_accurate_to_the_last_bits(x):
    assert log(x) == pytest.approx(math.log(x), rel=5e-16, abs=1e-300)


@pytest.mark.parametrize("x", [1.0, 1.0 + 2e-16, 1.0 - 1e-16, 2.0, 0.5, math.sqrt(2.0), math.sqrt(0.5), math.e])
def test_log_around_one_and_its_seams(x):
    assert log(x) == pytest.approx(math.log(x), rel=5e-16, abs=0.0)


@given(st.floats(-50.0, 50.0))
def test_tanh(x):
    assert tanh(x) == pytest.approx(math.tanh(x), abs=3.5e-16)


@pytest.mark.parametrize("quarter", range(-8, 9))
def test_sincos_in_every_quadrant(quarter):
    for x in np.linspace(quarter * math.pi / 4 - 0.01, quarter * math.pi / 4 + 0.01, 21):
        both = sincos(x)
        assert abs(both.sin - math.sin(x)) < 2.3e-16
        assert abs(both.cos - math.cos(x)) < 2.3e-16


def test_sincos_of_arrays_has_the_bits_of_sincos():
    x = np.linspace(-9.0, 9.0, 36).reshape(3, 4, 3)[:, ::2]
    sin, cos = sincos_of(x)
    assert sin.shape == cos.shape == x.shape
    for place in np.ndindex(x.shape):
        assert (sin[place], cos[place]) == sincos(x[place])
