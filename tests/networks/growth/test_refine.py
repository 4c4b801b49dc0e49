from itertools import pairwise

import numpy as np
import pytest

from helpers.small_network import FREE, NODES, X, output
from polydraulic import AbductiveRegressor
from polydraulic.networks.growth.derivatives import free_terms
from polydraulic.networks.growth.refine import _normal, refine
from polydraulic.networks.growth.training_rows import rows_in_memory
from polydraulic.networks.model.table import Node

RNG = np.random.default_rng(0)


def test_weights_are_repetitions():
    times = RNG.integers(1, 4, 300)
    again = np.repeat(np.arange(300), times)
    y, coef = np.exp(X[:, 0]), np.concatenate([np.array(n.coef)[keep] for n, keep in zip(NODES, FREE, strict=True)])
    weighted = rows_in_memory(X, y, times.astype(float))
    repeated = rows_in_memory(X[again], y[again], None)
    for one, two in zip(
        *(_normal(free_terms(NODES, FREE), coef, r, (-1.0, 1.0), np.inf) for r in (weighted, repeated)), strict=True
    ):
        assert one == pytest.approx(two, rel=1e-10, abs=1e-10)


def test_a_point_above_the_limit_is_given_up():
    rows = rows_in_memory(X, np.exp(X[:, 0]), None)
    coef = np.concatenate([np.array(n.coef)[keep] for n, keep in zip(NODES, FREE, strict=True)])
    loss = _normal(free_terms(NODES, FREE), coef, rows, (-9.0, 9.0), np.inf).loss
    assert _normal(free_terms(NODES, FREE), coef, rows, (-9.0, 9.0), loss) is None
    assert _normal(free_terms(NODES, FREE), coef, rows, (-9.0, 9.0), loss * (1 + 1e-9)).loss == loss
    assert _normal(free_terms(NODES, FREE), coef * 1e200, rows, (-9.0, 9.0), np.inf) is None


def test_a_known_network_is_found_again():
    """Noise-free data of a network, and a start some percent off."""
    y = output(NODES[:3])
    rows = rows_in_memory(X, y, None)
    s = rows.scaling
    assert s.x_scale == pytest.approx([1.0, 1.0])
    last = np.array(NODES[2].coef)
    last[0] -= s.y_mean
    true = [*NODES[:2], Node(2, NODES[2].inputs, tuple(last / s.y_scale))]
    start = [Node(n.kind, n.inputs, tuple(np.array(n.coef) * (1 + 0.03 * RNG.normal(size=len(n.coef))))) for n in true]
    losses = []
    _, fse = refine(start, rows, (-1e9, 1e9), max_iterations=200, watch=lambda i, loss: losses.append(loss))
    assert fse < 1e-6 * losses[0]
    assert all(later <= earlier for earlier, later in pairwise(losses))


def test_terms_left_out_stay_out():
    rows = rows_in_memory(X, np.exp(X[:, 0]), None)
    nodes, _ = refine([Node(0, (0,), (0.1, 0.5, 0.0, 0.1))], rows, (-9.0, 9.0), max_iterations=20)
    assert nodes[0].coef[2] == 0.0
    assert nodes[0].coef[1] != 0.5


def test_the_bound_on_passes_holds():
    counted = []
    rows = rows_in_memory(X, np.exp(X[:, 0]), None)
    refine(NODES, rows, (-9.0, 9.0), max_iterations=3, watch=lambda i, loss: counted.append(i))
    assert len(counted) <= 3


def test_rows_on_a_bound_are_met_by_anything_beyond():
    """A ramp that saturates: with the bounds known, a straight line is exact."""
    x = np.linspace(-1.0, 1.0, 200)[:, None]
    y = np.clip(2.0 * x[:, 0], -1.0, 1.0)
    plain = AbductiveRegressor(max_layers=2, output_bounds=None).fit(x, y)
    aware = AbductiveRegressor(max_layers=2, output_bounds=(-1.0, 1.0)).fit(x, y)
    assert np.abs(aware.predict(x) - y).max() < 0.3 * np.abs(plain.predict(x) - y).max()


def test_refinement_lowers_the_error():
    y = np.exp(X[:, 0]) * np.sin(3.0 * X[:, 1])
    errors = [AbductiveRegressor(refine=on, carve=False, max_layers=3).fit(X, y).fse_ for on in (False, True)]
    assert errors[1] < 0.5 * errors[0]
