"""Circuits of n valves in series against another method in twice the precision; lanes, plain Python and C."""

import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from helpers.kernels_in_c import library
from helpers.series_judge_exactly import SURE, judged_surely
from helpers.series_made import IMPORTS, STATES, listed, made, pump_of, series, solved
from polydraulic.machine.circuits.series.check import PROVED, REPAIRED
from polydraulic.machine.circuits.series.short import series_2
from polydraulic.machine.circuits.series.text import series_text
from polydraulic.machine.valve import Orifices

PLAIN = bool(numba.config.DISABLE_JIT)
# the same with more valves; each takes long to compile
SLOW = [pytest.param(n, marks=pytest.mark.slow) for n in (4, 6)]
SIZES = [3, *SLOW]
WITHIN = {"real": 1e-9, "hard": 1e-9, "edges": 1e-7}  # of pump flow


def off(found, true, pump):
    """Largest error of the flows of each state as a share of pump flow."""
    return np.abs(found[:, : true.shape[1]] - true).max(axis=1) / pump.flow


def check(machine, n, kind, exponent, size, seed):
    """Hold `size` states to the judge; how many were repaired."""
    states, pump = STATES[kind](machine, n, size, np.random.default_rng(seed)), pump_of(machine, exponent)
    found, (true, _, doubt) = solved(series(n).solve_all, states, pump), judged_surely(states, pump)
    status = found[:, n + 4]
    assert np.all(np.isfinite(found))
    assert doubt <= SURE
    assert set(np.unique(status)) <= {PROVED, REPAIRED}
    errors = off(found, true, pump)
    assert errors[status == PROVED].max() <= WITHIN[kind]
    assert errors[status == REPAIRED].max(initial=0.0) <= 1e-12
    flows = found[:, : n + 3]
    balance = flows[:, n + 1] - flows[:, : n + 1].sum(axis=1) - flows[:, n + 2]
    assert np.abs(balance).max() <= 1e-12 * pump.flow
    assert found[:, n + 3].max() <= pump.relief
    return np.count_nonzero(status == REPAIRED)


@pytest.mark.parametrize("exponent", [0.0, 1.0])
@pytest.mark.parametrize("kind", STATES)
@pytest.mark.parametrize("n", SIZES)
def test_flows_are_those_of_the_judge(machine, n, kind, exponent):
    repaired = check(machine, n, kind, exponent, 10 if PLAIN else 4000, 0)
    assert PLAIN or (repaired > 0 if kind != "real" else repaired < 10)


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 2.0])
@pytest.mark.parametrize("kind", STATES)
@pytest.mark.parametrize("n", [3, 4, 5, 6])
def test_flows_are_those_of_the_judge_a_million_times(machine, n, kind, exponent):
    size = int(os.environ.get("SERIES_STATES", "1000000"))
    for seed in range(max(size // 20_000, 1)):
        check(machine, n, kind, exponent, 20_000, 1 + seed)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 2.0])
@pytest.mark.parametrize("n", SIZES)
def test_the_march_alone_is_right_everywhere(machine, n, exponent):
    pump = pump_of(machine, exponent)
    for kind in STATES:
        states = STATES[kind](machine, n, 5 if PLAIN else 1500, np.random.default_rng(2))
        found, (true, _, doubt) = solved(series(n).repair_all, states, pump), judged_surely(states, pump)
        assert np.all(found[:, n + 4] == REPAIRED)
        assert off(found, true, pump).max() <= 1e-12
        assert doubt <= SURE


def test_without_relief_valve_pressures_may_be_any(machine):
    pump = pump_of(machine, 1.0, relief=1e12)
    states = STATES["real"](machine, 3, 5 if PLAIN else 2000, np.random.default_rng(3))
    found, (true, _, doubt) = solved(series(3).solve_all, states, pump), judged_surely(states, pump)
    assert off(found, true, pump).max() <= 1e-9
    assert doubt <= SURE


@pytest.mark.parametrize("exponent", [0.0, 1.0])
def test_pressures_drive_the_flows(machine, exponent):
    n, pump = 4, pump_of(machine, exponent)
    inlets, bypasses, ports = states = STATES["real"](machine, n, 20 if PLAIN else 3000, np.random.default_rng(4))
    found = solved(series(n).solve_all, states, pump)
    q, passed = found[:, :n], found[:, [n]] + np.cumsum(found[:, n - 1 : 0 : -1], axis=1)[:, ::-1]
    passed = np.column_stack((passed, found[:, n]))
    p = np.column_stack((found[:, n + 3], found[:, n + 5 :]))
    behind = np.column_stack((found[:, n + 5 :], np.full(len(p), pump.p_return)))
    for flow, k, drop in ((q, inlets, p - ports), (passed, bypasses, p - behind)):
        # the flow that a pressure a rounding away would drive
        slack = k * np.sqrt(np.maximum(drop, 0.0) + 1e-14 * pump.relief) - k * np.sqrt(np.maximum(drop, 0.0))
        wrong = np.abs(flow - k * np.sqrt(np.maximum(drop, 0.0))) > 1e-10 * pump.flow + slack
        assert not np.any(wrong & (passed.sum(axis=1, keepdims=True) > 0.0) & (flow > 0.0))


def test_two_valves_are_those_written_by_hand(machine):
    for exponent in (0.0, 1.0):
        pump = pump_of(machine, exponent)
        inlets, bypasses, ports = states = STATES["real"](machine, 2, 20 if PLAIN else 1000, np.random.default_rng(5))
        found = solved(series(2).solve_all, states, pump)
        for k, b, p, row in zip(inlets, bypasses, ports, found, strict=True):
            s = series_2(Orifices(k[0], b[0], 0.0), Orifices(k[1], b[1], 0.0), p[0], p[1], pump)
            hand = [s.q_in_1, s.q_in_2, *s.circuit[:3]]
            assert np.abs(row[[0, 1, 3, 2, 4]] - hand).max() <= 1e-12 * pump.flow
            assert row[5] == pytest.approx(s.circuit.p_pump, rel=1e-9)


@pytest.mark.parametrize("n", SIZES)
def test_lanes_have_the_bits_of_single_circuits(machine, n):
    """Passes that go on after all has settled change nothing."""
    for exponent in (0.0, 1.0):
        states = STATES["real"](machine, n, 10 if PLAIN else 3000, np.random.default_rng(6))
        one, lanes = (
            solved(getattr(series(n), name), states, pump_of(machine, exponent)) for name in ("solve_all", "pass_all")
        )
        settled = one[:, n + 4] == PROVED
        assert np.array_equal(one[settled], lanes[settled])
        assert np.all(lanes[~settled, n + 4] != PROVED)


def states_file(machine, n, path):
    """States and what is found for them, of all kinds, with torque limit."""
    parts = [STATES[kind](machine, n, 8, np.random.default_rng(7)) for kind in STATES]
    states = [np.concatenate(part) for part in zip(*parts, strict=True)]
    np.savez(path, *states, solved(series(n).solve_all, states, pump_of(machine, 1.0)))


_PLAIN = """
import sys
import numpy as np
from helpers.series_made import pump_of, series, solved
from polydraulic import load_machine
*states, compiled = np.load(sys.argv[1]).values()
plain = solved(series({n}).solve_all, states, pump_of(load_machine("cat215b"), 1.0))
sys.exit(0 if np.array_equal(plain, compiled) else 3)
"""


@pytest.mark.skipif(PLAIN, reason="needs the compiler")
@pytest.mark.parametrize("n", [3, SLOW[1]])
def test_plain_python_gives_the_same_bits(machine, n, tmp_path):
    path = tmp_path / "states.npz"
    states_file(machine, n, path)
    folders = [os.path.dirname(os.path.dirname(sys.modules["helpers"].__path__[0] + "/")), *sys.path]
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(folders)}
    done = subprocess.run([sys.executable, "-c", _PLAIN.format(n=n), path], env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def _entry(n):
    """A function of arrays alone, as C is called."""
    valves = (
        f"{listed('Orifices(s[{i}], s[' + str(n) + ' + {i}], 0.0)', n)}, {listed('s[' + str(2 * n) + ' + {i}]', n)}"
    )
    pump = ", ".join(f"s[{3 * n + i}]" for i in range(6))
    stores = "\n".join(f"    out[{i}] = r.q_in_{i + 1}" for i in range(n))
    return f"""

def into(s: np.ndarray, out: np.ndarray) -> float:
    pump = Pump({pump})
    r = series_{n}({valves}, pump)
{stores}
    out[{n}] = r.circuit.q_bypass
    out[{n + 1}] = r.circuit.q_pump
    out[{n + 2}] = r.circuit.q_relief
    out[{n + 3}] = r.circuit.p_pump
    out[{n + 4}] = float(r.status)
    return 0.0
"""


@pytest.mark.parametrize("n", [3, SLOW[1]])
def test_c_has_the_same_bits(machine, n, tmp_path):
    module = made(f"made_series_{n}_in_c", f"{IMPORTS}\n\n\n{series_text(n)}{_entry(n)}")
    c, _ = library(tmp_path, (module.into, [np.zeros(3 * n + 6), np.zeros(n + 5)]))
    pump, statuses = pump_of(machine, 1.0), set()
    for kind in STATES:
        states = STATES[kind](machine, n, 5 if PLAIN else 500, np.random.default_rng(8))
        found = solved(series(n).solve_all, states, pump)
        for k, b, p, row in zip(*states, found, strict=True):
            given, out = np.concatenate((k, b, p, pump)), np.empty(n + 5)
            c.into(given.ctypes.data, out.ctypes.data)
            assert np.array_equal(out, row[: n + 5])
            statuses.add(row[n + 4])
    assert PLAIN or statuses == {PROVED, REPAIRED}


def test_lines_are_short_and_names_are_those_of_the_length():
    for n in (2, 3, 6):
        text = series_text(n)
        assert max(map(len, text.splitlines())) <= 120
        assert f"def series_{n}(k_1, " in text
        assert f"class Series{n}(NamedTuple):" in text
        assert text == series_text(n)
