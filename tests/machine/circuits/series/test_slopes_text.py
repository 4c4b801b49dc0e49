"""Slopes of circuits of n valves in series against central differences, and against those written by hand for two."""

import numba
import numpy as np
import pytest

from helpers.series_made import IMPORTS, listed, made, pump_of
from helpers.valves import orifice_slopes, orifices
from polydraulic.machine.circuit_slopes import series_slopes
from polydraulic.machine.circuits.series.short import series_2
from polydraulic.machine.circuits.series.slopes_text import SERIES_SLOPES_IMPORTS, series_slopes_text
from polydraulic.machine.circuits.series.text import series_text
from polydraulic.machine.valve import Orifices
from polydraulic.thesis.excavator import spool_of

PLAIN = bool(numba.config.DISABLE_JIT)
SPOOL, PRESSURE = 1e-9, 30.0  # m, Pa; steps of differences


def _drivers(n):
    k, d = (listed(f"Orifices({c}[{{i}}, 0], {c}[{{i}}, 1], 0.0)", n) for c in "kd")
    names = [f"by_{what}_{i + 1}_{j + 1}" for what in "px" for i in range(n) for j in range(n)]
    stores = "\n".join(f"    out[{place}] = f.{name}" for place, name in enumerate(names))
    flows = "\n".join(f"    out[{i}] = s.q_in_{i + 1}" for i in range(n))
    return f"""

@driver
def flows_of(k, p, pump, out):
    s = series_{n}({k}, {listed("p[{i}]", n)}, pump)
{flows}
    out[{n}] = s.circuit.q_relief


@driver
def slopes_of(k, d, p, pump, out):
    s = series_{n}({k}, {listed("p[{i}]", n)}, pump)
    f = series_{n}_slopes({k}, {d}, s, pump)
{stores}
"""


def circuit(n):
    imports = "\n".join((IMPORTS, *SERIES_SLOPES_IMPORTS))
    return made(f"made_slopes_{n}", f"{imports}\n\n\n{series_text(n)}\n\n{series_slopes_text(n)}{_drivers(n)}")


@pytest.mark.parametrize("limited", [0.0, 1.0])
@pytest.mark.parametrize("n", [3, *(pytest.param(n, marks=pytest.mark.slow) for n in (2, 5))])
def test_slopes_are_differences(machine, n, limited):
    module, pump, rng = circuit(n), pump_of(machine, limited), np.random.default_rng(0)
    knots = np.array(machine.functions[0].valve.knots)
    tables = [machine.functions[j % 3].valve for j in range(n)]

    def conductances(x):
        return np.array([orifices(one, table)[:2] for one, table in zip(x, tables, strict=True)])

    def flows(x, p):
        out = np.empty(n + 1)
        module.flows_of(conductances(x), p, pump, out)
        return out

    def differences(x, p):
        """Slopes of flow i over port pressure, then spool, of valve j."""
        by_p = [flows(x, p + step) - flows(x, p - step) for step in PRESSURE * np.eye(n)]
        by_x = [flows(x + step, p) - flows(x - step, p) for step in SPOOL * np.eye(n)]
        return np.array(by_p).T[:n] / (2.0 * PRESSURE), np.array(by_x).T[:n] / (2.0 * SPOOL)

    compared = 0
    for _ in range(30 if PLAIN else 400):
        x = rng.uniform(spool_of(machine).deadband, spool_of(machine).bypass_closed, n)
        p = rng.uniform(0.0, 0.3 * machine.circuit("boom").pump.relief, n)
        found = flows(x, p)
        # away from kinks: of tables, of check valves, of the relief valve
        near = np.abs(knots[:, None] - x).min() < 1e-6 or found[n] > 0.0
        if near or np.any((found[:n] > 0.0) & (found[:n] < 1e-3 * pump.flow)):
            continue
        compared += 1
        out, k = np.empty(2 * n * n), conductances(x)
        slopes = np.array([orifice_slopes(one, table)[:2] for one, table in zip(x, tables, strict=True)])
        module.slopes_of(k, slopes, p, pump, out)
        by_p, by_x = out.reshape(2, n, n)
        true_p, true_x = differences(x, p)
        assert np.allclose(by_p, true_p, rtol=1e-4, atol=1e-6 * pump.flow / machine.circuit("boom").pump.relief)
        assert np.allclose(by_x, true_x, rtol=1e-4, atol=1e-6 * pump.flow / knots[-1])
        assert np.allclose(by_p, by_p.T, rtol=1e-12, atol=0.0)
    assert compared > (2 if PLAIN else 60)


@pytest.mark.parametrize("limited", [0.0, 1.0])
def test_two_valves_have_the_slopes_written_by_hand(machine, limited):
    module, pump, rng, kinds = circuit(2), pump_of(machine, limited), np.random.default_rng(1), set()
    for _ in range(20 if PLAIN else 300):
        k, d, p = 10.0 ** rng.uniform(-7.5, -5.0, (2, 2)), rng.normal(size=(2, 2)), rng.uniform(0.0, 2e7, 2)
        out = np.empty(8)
        module.slopes_of(k, d, p, pump, out)
        first, second, by_first, by_second = (Orifices(*row, 0.0) for row in (*k, *d))
        found = series_2(first, second, *p, pump)
        s = series_slopes(first, second, by_first, by_second, found.q_in_1, found.q_in_2, found.circuit, pump)
        hand = [s.first_by_p, s.other_by_p, s.other_by_p, s.second_by_p]
        hand += [s.first_by_first, s.first_by_second, s.second_by_first, s.second_by_second]
        flows = found.q_in_1, found.q_in_2, found.circuit.q_relief
        kinds.add(tuple(flow > 1e-9 * pump.flow for flow in flows))
        if all(flow == 0.0 or flow > 1e-6 * pump.flow for flow in flows):
            assert np.allclose(out[:4], hand[:4], rtol=1e-7, atol=1e-20)
            assert np.allclose(out[4:], hand[4:], rtol=1e-7, atol=1e-9 * np.abs(d).max() * pump.flow / k.min())
    assert PLAIN or len(kinds) > 3
