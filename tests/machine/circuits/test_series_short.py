"""One valve, and two in series, are those of `machine.pump`, whole and in the parts that lanes call."""

import numpy as np

from polydraulic.elementary import exp
from polydraulic.machine.circuits.series_short import (
    limit_series_1,
    limit_series_2,
    series_1,
    series_1_at,
    series_2,
    series_2_at,
)
from polydraulic.machine.pump import LIMIT_PASSES, Pump, limits, series_circuit, single_circuit, unlimited
from polydraulic.machine.valve import Orifices

PUMP = Pump(2.8e-3, 3.1e7, 3e5, 2.2e7, 1.0, -0.35)


def test_short_circuits_have_the_bits_of_the_pump_kernels():
    rng = np.random.default_rng(3)
    limited = 0
    for _ in range(500):
        k = [Orifices(*(10.0 ** rng.uniform(-8.5, -6.0, 2)), 0.0) for _ in range(2)]
        p = rng.uniform(0.0, 3e7, 2)
        one, two = series_1(k[0], p[0], PUMP), series_2(k[0], k[1], p[0], p[1], PUMP)
        other = single_circuit(k[0], p[0], PUMP)
        assert (one.q_in_1, one.circuit, one.status) == (other.q_in, other.circuit, 0)
        both = series_circuit(k[0], k[1], p[0], p[1], PUMP)
        assert (two.q_in_1, two.q_in_2, two.p_between_1, two.circuit) == tuple(both)
        for at, step, whole, *valves in (
            (series_1_at, limit_series_1, one, k[0], p[0]),
            (series_2_at, limit_series_2, two, *k, *p),
        ):
            found = at(PUMP.flow, *valves, PUMP)
            if limits(found.circuit.p_pump, PUMP):
                limited += 1
                x = unlimited(PUMP)
                for _ in range(LIMIT_PASSES):  # all of them, although single circuits end earlier
                    x = step(x, *valves, PUMP)
                found = at(PUMP.flow * exp(x.y), *valves, PUMP)
            assert found == whole
    assert 100 < limited < 950
