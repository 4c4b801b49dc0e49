import numpy as np
import pytest

from helpers.valves import circuit_pump, orifice_slopes, orifices
from polydraulic.machine.circuit_slopes import series_slopes, single_slopes
from polydraulic.machine.circuits.series.short import series_1, series_2
from polydraulic.machine.pump import Circuit
from polydraulic.machine.valve import Orifices
from polydraulic.thesis.excavator import pump_of, spool_of

SPOOL, PRESSURE = 1e-8, 100.0  # m, Pa; steps of differences


def differences(flows, point, steps):
    """Slopes of several flows over each of several arguments, (argument, flow)."""
    found = []
    for place, step in enumerate(steps):
        moved = np.zeros(len(point))
        moved[place] = step
        found.append((np.array(flows(*(point + moved))) - np.array(flows(*(point - moved)))) / (2.0 * step))
    return np.array(found)


def assert_near(found, slopes, scale):
    """Equal, up to the digits that differences of nearly equal flows have lost."""
    assert np.allclose(found, slopes, rtol=2e-4, atol=1e-6 * scale), (found, slopes)


@pytest.mark.parametrize("limited", [False, True])
def test_slopes_of_one_circuit_are_its_differences(machine, limited):
    pump, valve = circuit_pump(machine, "boom", torque_limit_enabled=limited), machine.function("boom").valve
    rng, knots, kinds = np.random.default_rng(0), np.array(machine.functions[0].valve.knots), set()

    def solved(x, p):
        return series_1(orifices(x, valve), p, pump)

    def kind(found):
        return found.q_in_1 > 0.0, found.circuit.q_relief > 0.0

    for _ in range(200):
        x, p = rng.uniform(0.0, knots[-1]), rng.uniform(0.0, pump_of(machine, "boom").relief)
        found = solved(x, p)
        if np.abs(knots - x).min() < 1e-6 or any(kind(solved(x, end)) != kind(found) for end in (p - 1e3, p + 1e3)):
            continue
        kinds.add(kind(found))
        slopes = single_slopes(orifices(x, valve), orifice_slopes(x, valve), found.q_in_1, found.circuit, pump)
        by_x, by_p = differences(lambda x, p: [solved(x, p).q_in_1], np.array([x, p]), [SPOOL, PRESSURE])
        assert_near(by_p, slopes.by_p, pump.flow / pump_of(machine, "boom").relief)
        assert_near(by_x, slopes.by_spool, pump.flow / knots[-1])
    assert {(True, False), (False, False), (True, True)} <= kinds


@pytest.mark.parametrize("limited", [False, True])
def test_slopes_of_two_valves_in_series_are_their_differences(machine, limited):
    pump = circuit_pump(machine, "series", torque_limit_enabled=limited)
    first, second = (machine.function(name).valve for name in ("swing", "stick"))
    rng, knots, compared = np.random.default_rng(1), np.array(machine.functions[0].valve.knots), 0

    def flows(x1, x2, p1, p2):
        return series_2(orifices(x1, first), orifices(x2, second), p1, p2, pump)[:2]

    for _ in range(200):
        x1, x2 = rng.uniform(spool_of(machine).deadband, spool_of(machine).bypass_closed, 2)
        p1, p2 = rng.uniform(0.0, 0.3 * pump_of(machine, "boom").relief, 2)
        k1, k2 = orifices(x1, first), orifices(x2, second)
        found = series_2(k1, k2, p1, p2, pump)
        kinks = np.abs(knots - x1).min() < 1e-6 or np.abs(knots - x2).min() < 1e-6 or found.circuit.q_relief > 0.0
        if kinks or min(found.q_in_1, found.q_in_2) < 1e-3 * pump.flow:
            continue
        compared += 1
        s1, s2 = orifice_slopes(x1, first), orifice_slopes(x2, second)
        s = series_slopes(k1, k2, s1, s2, found.q_in_1, found.q_in_2, found.circuit, pump)
        by = differences(flows, np.array([x1, x2, p1, p2]), [SPOOL, SPOOL, 3.0 * PRESSURE, 3.0 * PRESSURE])
        spools = [[s.first_by_first, s.second_by_first], [s.first_by_second, s.second_by_second]]
        pressures = [[s.first_by_p, s.other_by_p], [s.other_by_p, s.second_by_p]]
        assert_near(by[:2], spools, pump.flow / knots[-1])
        assert_near(by[2:], pressures, pump.flow / pump_of(machine, "boom").relief)
    assert compared > 50


def test_a_rounding_left_over_at_a_closed_orifice_makes_no_slope(machine):
    """A bypass that has just closed, on a segment on which it would open, while a rounding of the other flows is left for it."""
    pump = circuit_pump(machine, "boom", torque_limit_enabled=False)
    closed = Orifices(inlet=1e-6, bypass=0.0, outlet=0.0)
    opening = Orifices(inlet=1e-4, bypass=1e-3, outlet=0.0)
    q = pump.flow / 2.0
    circuit = Circuit(q_pump=pump.flow, q_bypass=3e-20, q_relief=0.0, p_pump=2e7, q_stored=0.0)
    both = series_slopes(closed._replace(bypass=1e-6), closed, opening, opening, q, q, circuit, pump)
    alone = single_slopes(closed, opening, pump.flow, circuit, pump)
    assert max(abs(slope) for slope in (*both, *alone)) < 1e3
