import numpy as np
import pytest

from polydraulic.identification.equations.fit import relief
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
        np.full((n, 1, 1), 10e-3), p_in, np.zeros((n, 1, 1)), q, np.zeros((n, 1, 2)), np.ones((n, 1), dtype=bool), np.arange(n) * 20 // n,
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
        np.full((n, 1, 1), travel), pressure[:, None, None], np.zeros((n, 1, 1)), flow[:, None], np.zeros((n, 1, 2)), np.ones((n, 1), dtype=bool),
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
        ({"below": 5.6e5}, {"below": 6.4e5}),  # a fiftieth of the setting
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


def test_of_few_blocks_the_noise_of_the_sensor_counts():
    few, many = found_of(stalled=2000, blocks=4), found_of(stalled=2000, blocks=400)
    assert few[1] ** 2 - many[1] ** 2 == pytest.approx(NOISE**2 / 4.0, rel=0.1)


def test_the_setting_may_be_anywhere_between_stall_and_where_oil_still_flows():
    (value, far), (_, near) = found_of(below=5e5), found_of(below=1e5)
    gaps = value - RELIEF + np.array([5e5, 1e5])
    assert far**2 - near**2 == pytest.approx((gaps[0] ** 2 - gaps[1] ** 2) / 12.0)


@pytest.mark.parametrize("shape", [1, 2])
def test_intervals_hold_the_setting_whatever_the_shape_of_loads(shape):
    """Loads that push most rows by about as much would raise the setting, were they taken for those that push most rows by little."""
    off = []
    for seed in range(12):
        rows = stalled(4000, 1.0, seed)
        loads = np.random.default_rng(100 + seed).gamma(shape, 1.5 * NOISE, (4000, 1, 1))
        p_in = np.where(rows.q_in[:, :, None] > 5e-4, rows.p_in, rows.p_in + loads)
        value, error = seen_relief(MODEL, rows._replace(p_in=p_in), np.array([5e-3]), 1e6)
        off.append((value - RELIEF) / error)
        assert error < 0.7 * NOISE
    assert np.mean(np.abs(off) < 1.645) > 0.8


VALVE = Curves(np.array([0.0, 5e-3, 10e-3, 14e-3]), np.array([0.0, 0.0, 1e-6, 2e-6]), np.array([3e-6, 1e-6, 0.0, 0.0]))
SERIES = CircuitModel((VALVE, VALVE), MODEL.pump)


def behind(travel_first, travel_second, passing, lost):
    """Rows whose second valve stalls at a pressure that is lower than the setting by what is lost before it, at a flow that passes it."""
    one = stalled(2000, 1e4)
    travel = np.broadcast_to([travel_first, travel_second], (2000, 1, 2))
    p_in = np.concatenate([np.full((2000, 1, 1), 1e6), one.p_in - lost * (one.q_in[:, :, None] < 5e-4)], axis=2)
    return one._replace(
        travel=np.array(travel), p_in=p_in, p_rate=np.zeros((2000, 1, 2)), q_in=np.column_stack([np.full(2000, passing), one.q_in[:, 0]]),
        known=np.ones((2000, 2), dtype=bool), noise_travel=np.full(2, 5e-6), noise_pressure=np.full(2, NOISE), noise_flow=np.full(2, 8e-6),
        noise_scale=np.zeros(2),
    )  # fmt: skip


def test_a_second_valve_shows_the_setting_where_nothing_passes_it():
    opens = np.full(2, 5e-3)
    value, error = seen_relief(SERIES, behind(0.0, 11e-3, 0.0, 0.0), opens, 1e6)
    assert abs(value - RELIEF) < 4.0 * error
    # its bypass lets a third of the flow pass, which loses a bar at the first one's
    assert seen_relief(SERIES, behind(0.0, 9e-3, 0.0, 1e5), opens, 1e6) is None
    # the first one's bypass is so narrow that what may flow unseen loses as much
    assert seen_relief(SERIES, behind(9.7e-3, 11e-3, 0.0, 1e5), opens, 1e6) is None


def test_stalled_rows_are_those_from_which_nothing_flows_on():
    travel = np.array([[11e-3, 0.0], [11e-3, 11e-3], [6.5e-3, 11e-3], [6.5e-3, 11e-3], [6.5e-3, 8e-3]])[:, None, :]
    q = np.zeros((5, 2))
    q[3, 1] = 1e-3  # what the second one takes passes the first one
    rows = behind(0.0, 0.0, 0.0, 0.0).some(slice(0, 5))._replace(travel=travel, q_in=q)
    found = relief.stalled(SERIES, rows, np.full(2, 5e-3))
    assert found.tolist() == [[True, False], [True, False], [True, True], [False, False], [False, False]]
