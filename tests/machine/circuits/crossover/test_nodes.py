"""Nodes at given pressures: sums of two numbers keep what a wide orifice needs, closed forms obey their orifices."""

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest

from polydraulic.machine.circuits.crossover.nodes import (
    FinePressure,
    behind_bypass,
    drop,
    first_valve,
    giving_at,
    orifice_passes,
    raised,
)
from polydraulic.machine.circuits.series.short import series_1, series_2
from polydraulic.machine.pump import Pump, delivered
from polydraulic.machine.valve import Orifices

PUMP = Pump(3e-3, 3e7, 3e5)
LIMITED = Pump(3e-3, 3e7, 3e5, 1e7, 1.0, float(np.log(1.0 / 3.0)))


def test_pressures_keep_what_is_far_below_their_roundings():
    rng = np.random.default_rng(0)
    for _ in range(300):
        p = raised(FinePressure(rng.uniform(0.0, 3e7), 0.0), rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-25.0, 7.0))
        true = Fraction(p.coarse) + Fraction(p.fine)
        by = float(rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-25.0, 7.0))
        after = raised(p, by)
        assert abs(Fraction(after.coarse) + Fraction(after.fine) - true - Fraction(by)) <= abs(true) * Fraction(
            1, 2**100
        )
    assert drop(raised(FinePressure(1e7, 0.0), 1e-20), 1e7) == pytest.approx(1e-20, rel=1e-12)
    assert orifice_passes(1e-5, raised(FinePressure(1e7, 0.0), 1e-20), 1e7) == pytest.approx(1e-15, rel=1e-12)
    assert orifice_passes(1e-5, FinePressure(1e6, 0.0), 1e7) == 0.0


def test_what_passes_a_bypass_obeys_all_three_orifices():
    rng = np.random.default_rng(1)
    shared = 0
    for _ in range(500):
        bypass, inlet, tank = 10.0 ** rng.uniform(-11.0, -5.0, 3)
        inlet, tank = (0.0 if rng.random() < 0.2 else k for k in (inlet, tank))
        p, p_in, p_return = rng.uniform(0.0, 3e7, 3)
        found = behind_bypass(FinePressure(p, 0.0), bypass, Orifices(inlet, tank, 0.0), p_in, p_return)
        assert found.passed == pytest.approx(found.q_in + found.q_tank, rel=1e-15)
        shared += found.q_in > 0.0 and found.q_tank > 0.0
        if found.passed > 0.0:
            # the pressure behind that the bypass leaves is, within a rounding, what drives both
            behind = p - (found.passed / bypass) ** 2
            for q, k, port in ((found.q_in, inlet, p_in), (found.q_tank, tank, p_return)):
                low, high = (k * sqrt(max(behind - port + side * 1e-14 * p, 0.0)) for side in (-1.0, 1.0))
                assert low - 1e-14 * found.passed <= q <= high + 1e-14 * found.passed
        else:
            lowest = min(p_in if inlet > 0.0 else 1e30, p_return if tank > 0.0 else 1e30)
            assert p <= lowest
    assert shared > 30


def test_a_giving_circuit_has_nothing_left_at_its_own_pressure():
    k_1, k_2 = Orifices(1e-7, 4e-7, 0.0), Orifices(2e-7, 3e-7, 0.0)
    alone = series_2(k_1, k_2, 5e6, 1e6, PUMP)
    found = giving_at(FinePressure(alone.circuit.p_pump, 0.0), k_1, k_2, 5e6, 1e6, PUMP)
    assert (found.q_in, found.behind.q_in) == pytest.approx((alone.q_in_1, alone.q_in_2), rel=1e-9)
    assert found.behind.p == pytest.approx(alone.p_between_1, rel=1e-9)
    assert abs(found.rest - alone.circuit.q_relief) <= 1e-9 * PUMP.flow


@pytest.mark.parametrize("pump", [PUMP, LIMITED])
def test_a_first_valve_sees_the_pressure_behind_as_a_tank(pump):
    rng = np.random.default_rng(2)
    for _ in range(200):
        k, behind = Orifices(*10.0 ** rng.uniform(-9.0, -6.0, 2), 0.0), float(rng.uniform(0.0, 2.5e7))
        port = float(rng.uniform(0.0, 3e7))
        found = first_valve(k, port, FinePressure(behind, 0.0), pump)
        alone = series_1(k, port, pump._replace(p_return=behind))
        assert found.q_in == pytest.approx(alone.q_in_1, rel=1e-8, abs=1e-10 * pump.flow)
        assert found.circuit.p_pump == pytest.approx(alone.circuit.p_pump, rel=1e-8)
        assert found.circuit.q_pump == pytest.approx(delivered(found.circuit.p_pump, pump), rel=1e-12)
