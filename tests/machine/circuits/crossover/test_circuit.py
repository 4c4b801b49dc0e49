"""The crossover valve against brackets within brackets in twice the precision; what it is without flow, wide open, in C."""

import os

import numba
import numpy as np
import pytest

from helpers.crossover_made import (
    BEHIND_TAKING,
    STATUS,
    judged,
    off,
    put,
    random_states,
    solve_three,
    solved,
)
from helpers.kernels_in_c import library
from helpers.series_made import STATES, pump_of
from polydraulic.machine.circuits.crossover.circuit import crossover_3, crossover_4
from polydraulic.machine.circuits.crossover.nodes import CrossoverOrifice
from polydraulic.machine.circuits.series.check import UNPROVED
from polydraulic.machine.circuits.series.short import series_1, series_2
from polydraulic.machine.pump import NEVER, Pump
from polydraulic.machine.valve import Orifices

PLAIN = bool(numba.config.DISABLE_JIT)
WITHIN, SURE = 1e-12, 1e-14  # of pump flow: of what is found, and of the judge


def check(machine, kind, exponent, size, seed):
    """Hold `size` states to the judge."""
    states = random_states(machine, kind, exponent, size, seed)
    found = solved(states)
    true = judged(states, found)
    assert np.all(np.isfinite(found))
    assert true[:, -1].max() <= SURE
    assert np.all(found[:, STATUS] < UNPROVED)
    assert off(found, true, states).max() <= WITHIN
    q, flow = found.T, states.gives.flow
    assert np.abs(q[5] - q[0] - q[1] - q[4] - q[6] - q[7]).max() <= 1e-13 * flow
    assert np.abs(q[9] + q[4] - q[2] - q[3] - q[10] - q[11]).max() <= 1e-13 * flow
    for pump, p in ((states.gives, q[8]), (states.takes, q[12])):
        assert p.max() <= pump.relief * (1.0 + 1e-15)
    assert size < 100 or 0.2 < np.mean(q[4] > 0.0) < 0.9


@pytest.mark.parametrize("exponent", [0.0, 1.0])
@pytest.mark.parametrize("kind", STATES)
def test_flows_are_those_of_the_judge(machine, kind, exponent):
    check(machine, kind, exponent, 5 if PLAIN else 500, 1)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("kind", STATES)
def test_flows_are_those_of_the_judge_a_million_times(machine, kind, exponent):
    for seed in range(max(int(os.environ.get("SERIES_STATES", "1000000")) // 80_000, 1)):
        check(machine, kind, exponent, 20_000, 2 + seed)


@pytest.mark.parametrize("kind", STATES)
def test_three_valves_are_four_of_which_one_is_not_there(machine, kind):
    states = random_states(machine, kind, 1.0, 5 if PLAIN else 300, 3)
    states.inlets[:, 1], states.bypasses[:, 1] = 0.0, 1e3
    found = solved(states, solve_three)
    true = judged(states, found)
    assert true[:, -1].max() <= SURE
    assert off(found, true, states).max() <= WITHIN


@pytest.mark.parametrize("exponent", [0.0, 1.0])
def test_a_check_valve_that_stays_shut_leaves_two_circuits(machine, exponent):
    states = random_states(machine, "real", exponent, 30 if PLAIN else 500, 4)
    crosses, inlets, bypasses, ports, gives, takes = states
    found = solved(states)
    shut = np.flatnonzero(found[:, 4] == 0.0)
    assert len(shut) > 5
    for i in shut:
        k = [Orifices(a, b, 0.0) for a, b in zip(inlets[i], bypasses[i], strict=True)]
        left = series_2(k[0], k[1], ports[i, 0], ports[i, 1], gives)
        right = series_2(k[2], k[3], ports[i, 2], ports[i, 3], takes)
        alone = [left.q_in_1, left.q_in_2, right.q_in_1, right.q_in_2]
        assert np.abs(found[i, :4] - alone).max() <= 1e-9 * gives.flow
        nothing_behind = right.q_in_2 + right.circuit.q_bypass == 0.0
        assert crosses[i, 0] == 0.0 or nothing_behind or found[i, 8] <= found[i, BEHIND_TAKING] + crosses[i, 1] + 1e-6


def test_a_wide_crossover_brings_both_nodes_to_one_pressure(machine):
    gives = pump_of(machine, 0.0, relief=NEVER)
    valve, takes = Orifices(1e-6, 1e-6, 0.0), gives._replace(flow=0.5 * gives.flow)
    s = crossover_3(CrossoverOrifice(1e-2, 0.0), valve, Orifices(0.0, 1e-5, 0.0), valve, 5e6, 5e6, 5e6, gives, takes)
    joined = series_1(Orifices(2e-6, 2e-6, 0.0), 5e6, gives._replace(flow=1.5 * gives.flow))
    assert s.giving.circuit.p_pump == pytest.approx(joined.circuit.p_pump, rel=1e-6)
    assert s.giving.q_in_1 == pytest.approx(0.5 * joined.q_in_1, rel=1e-6)
    assert s.taking.q_in_2 == pytest.approx(0.5 * joined.q_in_1, rel=1e-6)


def test_the_check_valve_opens_at_its_pressure(machine):
    """Nothing reaches the second valve's open port but through the crossover, which takes its opening pressure of the drop."""
    gives = pump_of(machine, 0.0)
    blocked, open_, port = Orifices(0.0, 0.0, 0.0), Orifices(0.0, 1e-6, 0.0), Orifices(1e-3, 0.0, 0.0)
    p = series_1(open_, 0.0, gives).circuit.p_pump
    for opening, opens in ((p - 2e6 - 1.0, True), (p - 2e6 + 1.0, False)):
        s = crossover_3(CrossoverOrifice(1e-6, opening), open_, blocked, port, 0.0, 0.0, 2e6, gives, gives)
        assert (s.q_cross > 0.0) == opens
        assert s.giving.status < UNPROVED


@pytest.mark.parametrize("broken", [np.nan, 1e35])
def test_what_is_no_pressure_is_never_trusted(machine, broken):
    states = random_states(machine, "real", 1.0, 4, 5)
    for i in range(4):
        states.ports[i, i] = broken
    with np.errstate(all="ignore"):
        assert np.all(solved(states)[:, STATUS] == UNPROVED)


def into(v: np.ndarray, out: np.ndarray) -> float:
    """One state from an array, as C is called."""
    k_1, k_2 = Orifices(v[2], v[3], 0.0), Orifices(v[4], v[5], 0.0)
    k_3, k_4 = Orifices(v[6], v[7], 0.0), Orifices(v[8], v[9], 0.0)
    gives = Pump(v[14], v[15], v[16], v[17], v[18], v[19])
    takes = Pump(v[20], v[21], v[22], v[23], v[24], v[25])
    s = crossover_4(CrossoverOrifice(v[0], v[1]), k_1, k_2, k_3, k_4, v[10], v[11], v[12], v[13], gives, takes)
    put(s, out)
    return s.q_cross


def test_c_has_the_same_bits(machine, tmp_path):
    c, _ = library(tmp_path, (into, [np.zeros(26), np.zeros(16)]))
    for kind in STATES:
        states = random_states(machine, kind, 1.0, 5 if PLAIN else 300, 6)
        crosses, inlets, bypasses, ports, gives, takes = states
        valves = np.stack((inlets, bypasses), axis=2).reshape(len(crosses), 8)
        for row, *given in zip(solved(states), crosses, valves, ports, strict=True):
            out, given = np.empty(16), np.concatenate((*given, gives, takes))
            c.into(given.ctypes.data, out.ctypes.data)
            assert np.array_equal(out, row)
