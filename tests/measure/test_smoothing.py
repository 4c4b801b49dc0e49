import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.measure import assumption, differentiate


def test_a_cubic_is_differentiated_exactly():
    t = np.arange(50) * 0.02
    assert differentiate(t**3 - t, 0.02, 0.2) == pytest.approx(3.0 * t**2 - 1.0, abs=1e-9)
    assert differentiate(t[:6] ** 3, 0.02, 0.2) == pytest.approx(3.0 * t[:6] ** 2, abs=1e-9)
    with pytest.raises(InputError, match="4 samples cannot be differentiated"):
        differentiate(t[:4], 0.02, 0.2)


@pytest.mark.parametrize(("raster", "window"), [(0.01, 0.1), (0.01, 0.3), (0.001, 0.05), (0.1, 0.1)])
def test_what_a_derivative_assumes_is_what_it_does(raster, window):
    stated = assumption(raster, window)
    noise = np.random.default_rng(0).normal(0.0, 2.0, 100_000)
    assert np.std(differentiate(noise, raster, window)[100:-100]) == pytest.approx(2.0 * stated.noise_gain, rel=0.02)
    t = np.arange(20_000) * raster
    for factor in (0.98, 1.02):
        w = 2.0 * np.pi * stated.bandwidth * factor
        rate = differentiate(np.sin(w * t), raster, window)[200:-200]
        passed = np.sqrt(2.0) * np.std(rate) / w
        assert (passed > 0.5**0.5) == (factor < 1.0)
    assert "smooth over this time" in str(stated)


def test_ends_are_those_of_the_cubic_of_the_last_whole_window():
    values, t = np.random.default_rng(1).normal(size=40), 0.01 * np.arange(40)
    found = differentiate(values, 0.01, 0.1)  # eleven samples
    for window, rows in ((slice(0, 11), range(6)), (slice(29, 40), range(34, 40))):
        cubic = np.polynomial.Polynomial.fit(t[window], values[window], 3).deriv()
        assert found[rows] == pytest.approx(cubic(t[rows]), rel=1e-9)
