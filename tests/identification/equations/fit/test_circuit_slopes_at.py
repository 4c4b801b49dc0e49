import numpy as np
import pytest

from polydraulic.identification.equations.fit.circuit_slopes_at import circuit_slopes_at
from polydraulic.machine.pump import Pump

PUMP = Pump(2.8e-3, 2.5e7, 3e5)
LIMITED = Pump(2.8e-3, 2.5e7, 3e5, 1e7, 1.0, -np.log(2.5))


@pytest.mark.parametrize("pump", [PUMP, LIMITED], ids=["free", "limited"])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_slopes_are_those_of_differences(n, pump):
    rng = np.random.default_rng(n)
    k, b = 10.0 ** rng.uniform(-6.5, -5.0, (60, n)), 10.0 ** rng.uniform(-7.0, -5.0, (60, n))
    p = rng.uniform(0.0, 2e7, (60, n))
    at = circuit_slopes_at(k, b, p, pump)
    assert at.solved.all()
    for place, slopes in enumerate((at.by_inlet, at.by_bypass, at.by_pressure)):
        for j in range(n):
            ends = []
            step = 1e-6 * (k, b, p)[place][:, j]
            for sign in (1.0, -1.0):
                points = [k.copy(), b.copy(), p.copy()]
                points[place][:, j] += sign * step
                ends.append(circuit_slopes_at(*points, pump).q_in)
            off = np.abs((ends[0] - ends[1]) / (2.0 * step[:, None]) - slopes[:, :, j]) * (k, b, p)[place][:, j, None]
            assert np.quantile(off, 0.95) < 1e-7 * pump.flow  # a few points lie at kinks
