"""Slopes of one valve and of two are those of their circuits, each in its place."""

import numpy as np
import pytest

from helpers.valves import circuit_pump
from polydraulic.machine.circuits.series.short import series_1, series_2
from polydraulic.machine.circuits.series.short_slopes import series_1_slopes, series_2_slopes
from polydraulic.machine.valve import Orifices


def orifices_of(k, d, x):
    """Conductances whose spool has gone further by `x`."""
    return Orifices(k[0] + d[0] * x, k[1] + d[1] * x, 0.0)


def test_slopes_are_differences(machine):
    pump = circuit_pump(machine, "series")
    k = np.array([[2e-6, 1.2e-6], [1.5e-6, 0.9e-6]])
    d, p = np.array([[1e-4, -6e-5], [8e-5, -5e-5]]), np.array([2e6, 1e6])
    none = (0.0, 0.0)

    def one(p, x=none):
        return [series_1(orifices_of(k[0], d[0], x[0]), p[0], pump).q_in_1]

    def two(p, x=none):
        found = series_2(orifices_of(k[0], d[0], x[0]), orifices_of(k[1], d[1], x[1]), *p, pump)
        return [found.q_in_1, found.q_in_2]

    valves, slopes = [Orifices(*row, 0.0) for row in k], [Orifices(*row, 0.0) for row in d]
    alone = series_1_slopes(valves[0], slopes[0], series_1(valves[0], p[0], pump), pump)
    both = series_2_slopes(*valves, *slopes, series_2(*valves, *p, pump), pump)
    for flows, found, n in ((one, alone, 1), (two, both, 2)):
        assert min(flows(p)) > 1e-4
        for j in range(n):
            by_p = np.subtract(flows(p + 100.0 * np.eye(2)[j]), flows(p - 100.0 * np.eye(2)[j])) / 200.0
            by_x = np.subtract(flows(p, 1e-8 * np.eye(2)[j]), flows(p, -1e-8 * np.eye(2)[j])) / 2e-8
            for i in range(n):
                assert getattr(found, f"by_p_{i + 1}_{j + 1}") == pytest.approx(by_p[i], rel=1e-5)
                assert getattr(found, f"by_x_{i + 1}_{j + 1}") == pytest.approx(by_x[i], rel=1e-5)
