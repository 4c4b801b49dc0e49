"""One valve, and two in series, whole and in the parts that lanes call; `tests/machine/test_pump.py` holds them to a judge."""

import numpy as np

from polydraulic.machine.circuits.series_short import (
    series_1,
    series_1_at,
    series_1_limited,
    series_2,
    series_2_at,
    series_2_limited,
)
from polydraulic.machine.circuits.torque_limit import (
    LIMIT_PASSES,
    limit_begin_1,
    limit_begin_2,
    limit_pass_1,
    limit_pass_2,
)
from polydraulic.machine.pump import Pump, limits
from polydraulic.machine.valve import Orifices

PUMP = Pump(2.8e-3, 3.1e7, 3e5, 2.2e7, 1.0, -0.35)


def test_parts_that_lanes_call_have_the_bits_of_whole_circuits():
    rng = np.random.default_rng(3)
    limited = 0
    for _ in range(500):
        k = [Orifices(*(10.0 ** rng.uniform(-8.5, -6.0, 2)), 0.0) for _ in range(2)]
        p = rng.uniform(0.0, 3e7, 2)
        one, two = series_1(k[0], p[0], PUMP), series_2(k[0], k[1], p[0], p[1], PUMP)
        for at, begin, step, end, whole, valves, ports in (
            (series_1_at, limit_begin_1, limit_pass_1, series_1_limited, one, k[:1], p[:1]),
            (series_2_at, limit_begin_2, limit_pass_2, series_2_limited, two, k, p),
        ):
            found = at(PUMP.flow, *valves, *ports, PUMP)
            if limits(found.circuit.p_pump, PUMP):
                limited += 1
                passed = [PUMP.flow - found.q_in_1] if len(valves) == 2 else []
                x = begin(*passed, *valves, PUMP)
                for _ in range(LIMIT_PASSES):  # all of them, although single circuits end earlier
                    x = step(x, *ports, PUMP, True)
                found = end(x, *valves, *ports, PUMP)
            assert found == whole
    assert 100 < limited < 950
