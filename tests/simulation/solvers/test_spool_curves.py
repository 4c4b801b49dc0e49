"""The curve of a spool: its rate is its derivative."""

import numpy as np
import pytest

from polydraulic.simulation.solvers.spool_curves import spool_curve


@pytest.mark.parametrize("omega", [0.0, 7.0])
def test_the_rate_is_the_derivative(omega):
    c = np.array([[[1e-3, 2e-2, -3e-3, 4e-3, 1e-3, omega, 0.1, 12.0]]])
    for t in (0.3, 0.31, 1.7):
        before, here, after = (spool_curve(c[0], 0, 0.3, t + step) for step in (-1e-6, 0.0, 1e-6))
        assert here.v == pytest.approx((after.x - before.x) / 2e-6, rel=1e-6)
    assert spool_curve(c[0], 0, 0.3, 0.3).x == pytest.approx(
        -2e-3 + (4e-3 * np.sin(1.4) + 1e-3 * np.cos(1.4) if omega else 0.0), rel=1e-12
    )
