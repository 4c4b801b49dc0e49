import numpy as np
import pytest

from polydraulic.identification.equations.fit.outlet_fit import OutletRows, fit_outlet, predicted_out

KNOTS = np.array([0.0, 4.8e-3, 9.5e-3, 14e-3])
TRUE = np.array([0.0, 0.0, 1.8e-6, 1.6e-5])


@pytest.mark.parametrize("long", [1, 11])
def test_a_curve_is_found_where_the_flow_needs_a_drop(long):
    rng, n = np.random.default_rng(3), 4000
    travel = np.repeat(rng.uniform(0.0, 13e-3, (n, 1)), long, axis=1)
    drop = np.repeat(rng.uniform(4e5, 1.2e7, (n, 1)), long, axis=1)
    rows = OutletRows(travel, drop, np.zeros(n), np.arange(n) * 20 // n, 5e-6, 1e5, 8e-6)
    q = predicted_out(rows, KNOTS, TRUE, 3e5)
    drop = drop + rng.normal(0.0, 1e5, drop.shape)
    rows = rows._replace(q_out=np.minimum(q, 3e-3) + rng.normal(0.0, 8e-6, n), drop=drop)
    rows = OutletRows(*(v[q < 3e-3] if isinstance(v, np.ndarray) else v for v in rows))
    found = fit_outlet(rows, KNOTS, 3e5, np.array([0.0, 0.0, 2.4e-6, 1.1e-5]), 1.0)
    assert found.values[:2] == pytest.approx(0.0, abs=2e-9)
    assert found.values[2] == pytest.approx(TRUE[2], rel=0.01)
    assert found.values[3] == pytest.approx(TRUE[3], rel=0.1)
    assert abs(found.values[2] - TRUE[2]) < 8.0 * found.errors[2]
    assert np.all(np.diff(found.values) >= 0.0)
