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


def found_of(stalled=200, blocks=4, above=0, beyond=0.0, flowing=10, below=1e5, q=0.06, travel=10e-3, still=0.0):
    """What is found of rows that stall at the setting, some of them so far above it, and of rows in which oil flows below it.

    `q` and `still` are shares of the pump's flow, in rows that flow and that stall.
    """
    noise = NOISE * np.random.default_rng(2).normal(size=stalled)
    noise[:above] = beyond
    pressure = RELIEF + np.concatenate([noise, np.full(flowing, -below)])
    n = len(pressure)
    flow = MODEL.pump.flow * np.where(np.arange(n) < stalled, still, q)
    rows = CircuitRows(
        np.full((n, 1, 1), travel), pressure[:, None, None], np.zeros((n, 1, 1)), flow[:, None], np.ones((n, 1), dtype=bool),
        np.arange(n) % blocks, np.array([5e-6]), np.array([NOISE]), np.array([8e-6]), np.zeros(1),
    )  # fmt: skip
    return seen_relief(MODEL, rows, np.array([5e-3]), 1e6)


@pytest.mark.parametrize(
    ("enough", "short"),
    [
        ({"stalled": 200}, {"stalled": 199}),
        ({"blocks": 3}, {"blocks": 2}),
        ({"flowing": 10}, {"flowing": 9}),  # nobody knows how far below the setting oil still flows
        ({"q": 0.051}, {"q": 0.049}),
        ({"below": 5.8e5}, {"below": 6.2e5}),  # half of it is a hundredth of the setting
        ({"travel": 6.1e-3}, {"travel": 5.9e-3}),  # a fifth more than opens the valve
        ({"still": 0.0199}, {"still": 0.0201}),
        ({"above": 10, "beyond": 9 * NOISE}, {"above": 10, "beyond": 11 * NOISE}),  # too far from where most stall
    ],
)
def test_what_shows_a_setting_is_enough_by_little(enough, short):
    value, error = found_of(**enough)
    assert value == pytest.approx(RELIEF, abs=NOISE)
    assert error < 0.01 * value
    assert found_of(**short) is None


def test_the_error_holds_what_lies_between_the_setting_and_where_oil_still_flows():
    value, error = found_of(blocks=200, below=5e5)
    assert error == pytest.approx(0.5 * (value - RELIEF + 5e5), rel=0.01)
    _, near = found_of(blocks=4, below=-5e5)  # of few blocks the noise of the sensor counts
    assert near == pytest.approx(NOISE / 2.0, rel=0.05)
