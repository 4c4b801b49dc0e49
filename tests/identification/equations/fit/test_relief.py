import numpy as np
import pytest

from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, CircuitRows
from polydraulic.identification.equations.fit.relief import seen_relief
from polydraulic.identification.equations.fit.valve_curves import Curves
from polydraulic.machine.pump import Pump

RELIEF, NOISE = 3e7, 1e5
MODEL = CircuitModel((Curves(np.array([0.0, 14e-3]), np.zeros(2), np.zeros(2)),), Pump(2.8e-3, 3.05e7, 3e5))


def stalled(n, load, seed=1):
    rng = np.random.default_rng(seed)
    p_in = RELIEF + rng.exponential(load, (n, 1, 1)) + rng.normal(0.0, NOISE, (n, 1, 1))
    flowing = np.arange(n) % 10 == 0
    p_in[flowing] = rng.uniform(0.9, 1.0, (flowing.sum(), 1, 1)) * RELIEF
    q = np.where(flowing, 1e-3, 0.0)[:, None] + rng.normal(0.0, 8e-6, (n, 1))
    return CircuitRows(
        np.full((n, 1, 1), 10e-3), p_in, np.zeros((n, 1, 1)), q, np.ones((n, 1), dtype=bool), np.arange(n) * 20 // n,
        np.array([5e-6]), np.array([NOISE]), np.array([8e-6]), np.zeros(1),
    )  # fmt: skip


@pytest.mark.parametrize("load", [1e4, 1e5, 5e5])
def test_loads_above_the_setting_do_not_raise_it(load):
    found = [seen_relief(MODEL, stalled(2000, load, seed), np.array([5e-3]), 1e6) for seed in range(3)]
    assert np.mean([value for value, _ in found]) == pytest.approx(RELIEF, rel=1.5e-3)
    assert all(abs(value - RELIEF) < 4.0 * error for value, error in found)


def test_few_stalled_rows_say_nothing():
    assert seen_relief(MODEL, stalled(150, 1e5), np.array([5e-3]), 1e6) is None
