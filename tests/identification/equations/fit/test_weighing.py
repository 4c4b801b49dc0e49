"""Sums over rows, as they are written with matrices."""

import numpy as np
import pytest

from polydraulic.identification.equations.fit.circuit_fit import CircuitModel, CircuitRows, flows_of, weighted
from polydraulic.identification.equations.fit.valve_curves import Curves
from polydraulic.identification.equations.fit.weighing import HUBER, add_squares, over_knots
from polydraulic.identification.equations.observations import mean_weights
from polydraulic.machine.pump import Pump

CURVES = Curves(
    np.array([0.0, 4.8e-3, 7.2e-3, 9.5e-3, 14e-3]),
    np.array([0.0, 0.0, 6e-7, 9e-7, 5e-6]),
    np.array([3e-6, 8e-7, 2e-7, 0.0, 0.0]),
)
PUMPS = {"free": Pump(2.8e-3, 3e7, 3e5), "limited": Pump(2.8e-3, 3e7, 3e5, 1e7, 1.0, -float(np.log(3.0)))}


def rows_of(n, long, windows=40):
    rng = np.random.default_rng(n)
    travel, p_in = rng.uniform(0.0, 14e-3, (windows, long, n)), rng.uniform(1e6, 2.5e7, (windows, long, n))
    # noise of flows alone, so that a weight is one number
    noise = np.zeros(n), np.zeros(n), np.full(n, 8e-6)
    known = rng.random((windows, n)) > 0.2
    rates = rng.normal(0.0, 1e6, p_in.shape)
    of_clocks = rng.normal(0.0, 1e-2, (windows, n, 2))
    return CircuitRows(
        travel,
        p_in,
        rates,
        rng.uniform(0.0, 2e-3, (windows, n)),
        of_clocks,
        known,
        np.arange(windows),
        *noise,
        np.zeros(n),
    )


def mean_flow(model, rows):
    p_in = np.maximum(rows.p_in + model.lead * rows.p_rate, 0.0)
    n = len(model.valves)
    flows = flows_of(model, rows.travel.reshape(-1, n), p_in.reshape(-1, n)).reshape(rows.travel.shape)
    return np.einsum("wln,l->wn", flows, mean_weights(rows.travel.shape[1]))


@pytest.mark.parametrize("pump", PUMPS)
@pytest.mark.parametrize(("n", "long"), [(1, 1), (2, 1), (3, 4)])
def test_what_is_left_and_its_slopes_are_those_of_differences(n, long, pump):
    rows = rows_of(n, long)
    model = CircuitModel((CURVES,) * n, PUMPS[pump], 0.003, -0.006)
    found = weighted(model, rows, ["flow", "lead", "lead_position"])

    def off(of):
        return np.where(
            rows.known, (mean_flow(of, rows) - rows.q_in - rows.q_rates @ (of.lead, of.lead_position)) / 8e-6, 0.0
        )

    def wider(k, step):
        inlet = CURVES.inlet + step * np.eye(5)[k]
        return model._replace(valves=(*model.valves[:-1], CURVES._replace(inlet=inlet)))

    changed = {
        15 * (n - 1) + 2: (1e-12, lambda step: wider(2, step)),
        15 * n: (1e-9, lambda step: model._replace(pump=model.pump._replace(flow=model.pump.flow + step))),
        15 * n + 1: (1e-7, lambda step: model._replace(lead=model.lead + step)),
        15 * n + 2: (1e-7, lambda step: model._replace(lead_position=model.lead_position + step)),
    }
    for i, (own, slopes) in enumerate(found):
        assert own == pytest.approx(off(model)[:, i], rel=1e-12, abs=1e-12)
        assert not slopes[~rows.known[:, i]].any()
        for number, (step, of) in changed.items():
            slope = (off(of(step)) - off(of(-step)))[:, i] / (2.0 * step)
            assert slopes[:, number] == pytest.approx(slope, rel=1e-4, abs=1e-5 * np.abs(slope).max())


def test_squares_are_those_of_matrices_and_count_less_far_off():
    rng = np.random.default_rng(1)
    off, slopes = rng.normal(0.0, 3.0, 200), rng.normal(size=(200, 5)) * (rng.random((200, 5)) > 0.5)
    gradient, curvature = np.ones(5), np.zeros((5, 5))
    loss = add_squares(off, slopes, gradient, curvature, np.empty(5, dtype=np.int64))
    size = np.abs(off)
    robust = np.minimum(1.0, HUBER / size)
    assert loss == pytest.approx(np.sum(np.where(size <= HUBER, 0.5 * size**2, HUBER * (size - 0.5 * HUBER))))
    assert gradient == pytest.approx(1.0 + slopes.T @ (robust * off))  # added to what was there
    assert curvature == pytest.approx(np.tril((slopes * robust[:, None]).T @ slopes))


def test_a_value_at_a_knot_counts_by_how_near_it_is():
    found = np.zeros((1, 3))
    over_knots(np.array([[0, 1]]), np.array([[0.25, 0.5]]), np.array([[4.0, 10.0]]), found)
    assert found[0].tolist() == [3.0, 6.0, 5.0]
