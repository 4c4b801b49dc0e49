"""One valve, and two in series, whole and in the parts that lanes call; `tests/machine/test_pump.py` holds them to a judge."""

import numpy as np

from polydraulic.machine.circuits.series.short import (
    series_1,
    series_1_at,
    series_1_limited,
    series_2,
    series_2_at,
    series_2_limited,
)
from polydraulic.machine.circuits.series.torque_limit import (
    LIMIT_PASSES,
    limit_begin_1,
    limit_begin_2,
    limit_pass_1,
    limit_pass_2,
)
from polydraulic.machine.pump import Pump
from polydraulic.machine.valve import Orifices

LIMITED = Pump(2.8e-3, 3.1e7, 3e5, 2.2e7, 1.0, -0.35)
FREE = LIMITED._replace(log_least=0.0)


def test_parts_that_lanes_call_have_the_bits_of_whole_circuits():
    rng = np.random.default_rng(3)
    less = 0
    for _ in range(500):
        k = [Orifices(*(10.0 ** rng.uniform(-8.5, -6.0, 2)), 0.0) for _ in range(2)]
        p = rng.uniform(0.0, 3e7, 2)
        for whole, at, begin, step, end, n in (
            (series_1, series_1_at, limit_begin_1, limit_pass_1, series_1_limited, 1),
            (series_2, series_2_at, limit_begin_2, limit_pass_2, series_2_limited, 2),
        ):
            assert at(FREE.flow, *k[:n], *p[:n], FREE) == whole(*k[:n], *p[:n], FREE)
            x = begin(*k[:n], LIMITED)
            for _ in range(LIMIT_PASSES):  # all of them, although single circuits end earlier
                x = step(x, *p[:n], LIMITED, True)
            found = end(x, *k[:n], *p[:n], LIMITED)
            assert found == whole(*k[:n], *p[:n], LIMITED)
            less += found.circuit.q_pump < LIMITED.flow
    assert 100 < less < 950
