"""Deadbands that are known are found, within the intervals that are stated."""

import numpy as np
import pytest
from scipy.signal import lfilter

from polydraulic import load_scenario, simulate
from polydraulic.errors import InputError
from polydraulic.measure import conversion, deadband, find_deadbands
from polydraulic.tables import Table
from polydraulic.thesis.excavator import spool_of

LOW, HIGH = -0.2, 0.35


def made(seed, low=LOW, high=HIGH, noise=0.02, lag=0.0, delay=0, n=12_000, curve=0.3):
    """A lever that steps and ramps, and a speed with a deadband that is known."""
    rng = np.random.default_rng(seed)
    u = np.repeat(rng.uniform(-1.0, 1.0, n // 60 + 1), 60)[:n]
    u = lfilter([0.08], [1.0, -0.92], u) + 0.3 * np.sin(0.02 * np.arange(n))
    keep = np.exp(-0.01 / lag) if lag else 0.0
    v = np.roll(lfilter([1.0 - keep], [1.0, -keep], u), delay)
    r, s = np.maximum(v - high, 0.0), np.maximum(low - v, 0.0)
    y = 2.0 * r - curve * r**2 - 1.5 * s + rng.normal(0.0, noise, n)
    segment = (np.arange(n) >= n // 2).astype(float)
    return Table({"time": 0.01 * np.arange(n), "segment": segment, "u": u, "y": y}, {"u": "V", "y": "m/s"})


@pytest.mark.parametrize(("lag", "delay"), [(0.0, 0), (0.1, 0), (0.0, 10), (0.1, 6)])
def test_edges_lie_in_their_intervals(lag, delay):
    inside = []
    for seed in range(5):
        found = deadband(made(seed, lag=lag, delay=delay), "u", "y", 0.01)
        assert found.found
        inside.append(found.low_interval[0] <= LOW <= found.low_interval[1])
        inside.append(found.high_interval[0] <= HIGH <= found.high_interval[1])
        assert found.low == pytest.approx(LOW, abs=0.04)
        assert found.high == pytest.approx(HIGH, abs=0.04)
        assert found.low_interval[1] - found.low_interval[0] < 0.15
        assert found.delay + found.lag == pytest.approx(lag + 0.01 * delay, abs=0.05)
        assert "answers u below" in found.statement()
    assert sum(inside) >= 9  # of ten, at a level of 95 %


@pytest.mark.parametrize("seed", range(3))
def test_no_deadband_is_found_where_there_is_none(seed):
    found = deadband(made(seed, 0.0, 0.0, curve=0.0), "u", "y", 0.01)
    assert not found.found
    assert "no significant deadband" in found.statement()


def test_a_log_with_thousands_of_rows_in_the_longest_delay():
    found = deadband(made(0, n=24_000), "u", "y", 1e-4)
    assert found.low == pytest.approx(LOW, abs=0.04)
    assert found.high == pytest.approx(HIGH, abs=0.04)


def test_the_input_that_explains_an_output_is_chosen():
    table = made(0)
    other = np.random.default_rng(9).normal(size=len(table))
    table = Table({**table.columns, "w": other, "p": other, "still": np.ones(len(table))}, {**table.units, "p": "Pa"})
    assert [(d.input, d.output) for d in find_deadbands(table, ["w", "u", "still"], ["y", "p"], 0.01)] == [("u", "y")]
    assert find_deadbands(table, ["w"], ["y"], 0.01) == []


def test_a_position_is_differentiated():
    table = made(1)
    stroke = np.concatenate([0.01 * np.cumsum(table["y"][:6000]), 0.01 * np.cumsum(table["y"][6000:])])
    table = Table({**table.columns, "s": stroke}, {**table.units, "s": "m"})
    (found,) = find_deadbands(table, ["u"], ["s"], 0.01)
    assert found.output == "d(s)/dt"
    assert found.low == pytest.approx(LOW, abs=0.04)
    assert found.high == pytest.approx(HIGH, abs=0.04)


def test_few_rows_say_nothing():
    assert deadband(made(0, n=600), "u", "y", 0.01) is None
    with pytest.raises(InputError, match="raster"):
        deadband(made(0), "u", "y", 0.0)


def test_an_input_explains_two_fifths_of_an_output_or_nothing_of_it():
    found = deadband(made(0, noise=0.7), "u", "y", 0.01)
    assert 0.4 < found.explained < 0.45
    assert deadband(made(0, noise=0.8), "u", "y", 0.01) is None


def test_edges_are_told_in_the_unit_of_the_log():
    found = deadband(made(0), "u", "y", 0.01)
    (a, b), (c, d) = found.low_interval, found.high_interval
    assert found.statement(conversion("mV")).startswith(
        f"y answers u below {1e3 * found.low:.4g} ({1e3 * a:.4g} to {1e3 * b:.4g}) "
        f"and above {1e3 * found.high:.4g} ({1e3 * c:.4g} to {1e3 * d:.4g}) mV, 95% intervals; delay "
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [11, 12, 13])
def test_the_deadband_of_the_machine_is_found(machine, seed):
    run = simulate(machine, "exact", load_scenario(f"random:{seed}:600"), raster=0.01)
    table = Table({**run.columns, "segment": np.zeros(len(run))}, run.units)
    for link in ("swing", "stick", "boom"):
        found = deadband(table, f"{link}.spool", f"{link}.q_in", 0.01)
        assert found.low == pytest.approx(-spool_of(machine).deadband, rel=0.15)
        assert found.high == pytest.approx(spool_of(machine).deadband, rel=0.15)
