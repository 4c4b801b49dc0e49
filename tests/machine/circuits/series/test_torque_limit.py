"""Passes at the torque limit settle soon, where the pump delivers its flow; whole circuits are held to a judge in `tests/machine/test_pump.py`."""

import numba
import numpy as np
import pytest

from polydraulic._kernel import driver
from polydraulic.elementary import log
from polydraulic.machine.circuits.series.torque_limit import (
    LIMIT_PASSES,
    limit_begin_1,
    limit_begin_2,
    limit_pass_1,
    limit_pass_2,
)
from polydraulic.machine.pump import Pump, delivered, series_from, single_at
from polydraulic.machine.valve import Orifices

FLOW, RELIEF, P_RETURN = 2.8e-3, 3.1e7, 3e5


@driver
def settle(k, p, laws, out):
    """Passes that one valve and two need, and how far their flow is from what the pump delivers at its pressure."""
    for i in range(k.shape[0]):
        first, second = Orifices(k[i, 0], k[i, 1], 0.0), Orifices(k[i, 2], k[i, 3], 0.0)
        pump, power = (
            Pump(FLOW, RELIEF, P_RETURN, laws[i, 0], laws[i, 1], -laws[i, 1] * log(RELIEF / laws[i, 0])),
            laws[i, 1] == 1.0,
        )
        x, passes = limit_begin_1(first, pump), 0
        while passes < LIMIT_PASSES and not x.still:
            x = limit_pass_1(x, p[i, 0], pump, power)
            passes += 1
        out[i, 0] = passes if x.still else np.inf
        out[i, 1] = x.q - delivered(single_at(x.q, first, p[i, 0], pump).circuit.p_pump, pump)
        x, passes = limit_begin_2(first, second, pump), 0
        while passes < LIMIT_PASSES and not x.still:
            x = limit_pass_2(x, p[i, 0], p[i, 1], pump, power)
            passes += 1
        found = series_from(x.q, x.w, first, second, p[i, 0], p[i, 1], pump)
        out[i, 2] = passes if x.still else np.inf
        out[i, 3] = x.q - delivered(found.circuit.p_pump, pump)


def states(n, rng, decades):
    """Valves with conductances over so many decades, of which some are shut; ports anywhere, at return and at relief; any pump law."""
    k = 10.0 ** rng.uniform(-6.0 - decades, -6.0, (n, 4))
    k[rng.random((n, 4)) < 0.1] = 0.0
    p = rng.uniform(0.0, RELIEF, (n, 2))
    special = rng.choice([0.0, P_RETURN, 0.999999 * RELIEF, RELIEF], (n, 2))
    p = np.where(rng.random((n, 2)) < 0.1, special, p)
    p[:, 1] = np.where(rng.random(n) < 0.05, p[:, 0], p[:, 1])
    laws = np.column_stack([rng.uniform(5e6, 2.8e7, n), rng.choice([0.5, 1.0, 2.0], n)])
    return k, p, laws


@pytest.mark.parametrize(("decades", "most"), [(1.5, 12), (6.0, 25)])
def test_passes_settle_where_the_pump_delivers_its_flow(decades, most):
    n = 300 if numba.config.DISABLE_JIT else 50_000
    out = np.zeros((n, 4))
    settle(*states(n, np.random.default_rng(4), decades), out)
    for passes, off in (out[:, :2].T, out[:, 2:].T):
        assert passes.max() <= most
        assert passes.mean() < 6.0
        assert np.abs(off).max() < 1e-10 * FLOW


def test_what_has_settled_stays():
    first, second = Orifices(2e-7, 3e-7, 0.0), Orifices(1e-7, 2e-7, 0.0)
    pump = Pump(FLOW, RELIEF, P_RETURN, 1e7, 1.0, -1.1)
    x = limit_begin_2(first, second, pump)
    for _ in range(LIMIT_PASSES):
        x = limit_pass_2(x, 5e6, 4e6, pump, True)
    again = limit_pass_2(x, 5e6, 4e6, pump, True)
    assert x.still
    assert (again.q, again.w) == (x.q, x.w)
