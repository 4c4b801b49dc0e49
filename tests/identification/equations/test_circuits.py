import numpy as np
import pytest

from polydraulic.identification.equations.circuits import seen_relief, shown_by
from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, CircuitRows
from polydraulic.identification.equations.fit.valve_curves import Curves
from polydraulic.machine.pump import Pump

RELIEF = 3e7
MODEL = CircuitModel((Curves(np.array([0.0, 14e-3]), np.zeros(2), np.zeros(2)),), Pump(2.8e-3, RELIEF, 3e5))


def rows_at(flowing, stalled, n=1000):
    """Rows with an open spool: pressures up to `flowing` with flow, and around `stalled` without."""
    rng = np.random.default_rng(1)
    p = np.concatenate([rng.uniform(0.5 * flowing, flowing, n), np.full(n, stalled)]) + rng.normal(0.0, 1e5, 2 * n)
    q = np.repeat([1e-3, 0.0], n)
    return CircuitRows(
        np.full((2 * n, 1, 1), 8e-3),
        p[:, None, None],
        np.zeros((2 * n, 1, 1)),
        q[:, None],
        np.zeros((2 * n, 1, 2)),
        np.ones((2 * n, 1), dtype=bool),
        np.tile(np.arange(n) * 20 // n, 2),
        *(np.array([x]) for x in (1e-5, 1e5, 1e-5, 0.0)),
    )


def test_a_relief_setting_lies_between_flow_and_stall():
    value, error = seen_relief(MODEL, rows_at(2.98e7, 3.02e7), np.array([5e-3]), 3e6)
    assert value == pytest.approx(3.02e7, rel=2e-3)
    assert abs(value - RELIEF) < 2.0 * error
    assert error < 0.01 * RELIEF


def test_a_load_held_above_the_setting_does_not_show_it():
    assert seen_relief(MODEL, rows_at(2.6e7, 3.2e7), np.array([5e-3]), 3e6) is None
    assert seen_relief(MODEL, rows_at(2.98e7, 3.02e7, 100), np.array([5e-3]), 3e6) is None


@pytest.mark.parametrize(
    ("moved", "above", "limited", "shown"),
    [
        (200, 1.03, True, ["flow", "limit_start"]),
        (199, 1.03, True, []),
        (200, 1.021, True, ["flow", "limit_start"]),
        (200, 1.019, True, ["flow"]),  # a fiftieth above where the limit starts
        (200, 1.03, False, ["flow"]),
    ],
)
def test_two_hundred_rows_with_an_open_valve_show_a_pump(moved, above, limited, shown):
    """Orifices that are shut leave the pump at its relief setting."""
    shut = Curves(np.array([0.0, 14e-3]), np.zeros(2), np.zeros(2))
    pump = MODEL.pump._replace(limit_start=RELIEF / above, log_least=-np.log(above) if limited else 0.0)
    rows = rows_at(2e7, 2e7, 200)
    rows = rows._replace(travel=np.where(np.arange(400) < moved, 5.1e-3, 5e-3)[:, None, None])
    assert shown_by(CircuitModel((shut,), pump), rows, np.array([5e-3])) == shown
