from dataclasses import replace

import numpy as np
import pytest

from polydraulic.errors import InputError
from polydraulic.networks import Dynamics, Lag, Model, Network, Node, Split, Variable, free_run
from polydraulic.networks.model.nodes import LINEAR
from polydraulic.networks.model.table import UNBOUNDED

U = np.sin(np.arange(30.0))


def linear(output, lags, coef, *, low=-100.0, high=100.0, partition=0, more=()):
    n = len(lags)
    network = Network((Node(LINEAR, tuple(range(n)), tuple(coef)),), (0.0,) * n, (1.0,) * n, (-50.0,) * n, (50.0,) * n, 0.0, 1.0, low, high)  # fmt: skip
    networks = (network, *(replace(network, nodes=(Node(LINEAR, tuple(range(n)), tuple(c)),)) for c in more))
    inputs = tuple(Variable(str(lag)) for lag in lags)
    return Model(inputs, Variable(output), networks, partition, dynamics=Dynamics(tuple(lags)))


def test_two_outputs_that_read_each_other():
    models = [
        linear("a", [Lag("u", 1), Lag("b", 2)], [0.5, 0.4]),
        linear("b", [Lag("a", 1), Lag("b", 1), Lag("u", 0)], [0.3, -0.2, 1.0]),
    ]
    measured = np.full(30, np.nan)
    measured[:2] = [1.0, 2.0]
    found = free_run(models, {"u": U, "b": measured, "a": measured})
    a, b = [1.0, 2.0], [1.0, 2.0]
    for t in range(2, 30):
        a.append(0.5 * U[t - 1] + 0.4 * b[t - 2])
        b.append(0.3 * a[t - 1] - 0.2 * b[t - 1] + U[t])
    assert np.allclose(found["a"], a, rtol=0, atol=1e-14)
    assert np.allclose(found["b"], b, rtol=0, atol=1e-14)


def test_every_model_keeps_its_own_regions():
    where = Split(0, 0.0, 1, 0)
    models = [
        linear("a", [Lag("u", 0)], [1.0], partition=where, more=([2.0],)),
        linear("b", [Lag("u", 0)], [3.0], partition=Split(0, 0.5, 0, Split(0, 0.9, 1, 2)), more=([4.0], [5.0])),
    ]
    found = free_run(models, {"u": U, "a": U, "b": U})
    assert np.allclose(found["a"][1:], np.where(U > 0, U, 2 * U)[1:])
    assert np.allclose(found["b"][1:], (U * np.select([U > 0.9, U > 0.5], [5.0, 4.0], 3.0))[1:])


def test_windows_begin_from_what_was_measured():
    model = linear("y", [Lag("y", 1)], [0.5])
    y = np.arange(1.0, 11.0)
    assert np.allclose(free_run([model], {"y": y}, horizon=1)["y"][1:], 0.5 * y[:-1])
    assert np.allclose(free_run([model], {"y": y}, horizon=2)["y"][1:5], [0.5, 0.25, 1.5, 0.75])
    parts = free_run([model], {"y": y}, segments=[0] * 4 + [1] * 6)["y"]
    assert np.allclose(parts, [1.0, 0.5, 0.25, 0.125, 5.0, 2.5, 1.25, 0.625, 0.3125, 0.15625])


def test_clamps_hold_an_unstable_model():
    model = linear("y", [Lag("y", 1)], [2.0], low=-3.0, high=3.0)
    y = np.zeros(12)
    y[0] = 0.1
    found = free_run([model], {"y": y})["y"]
    assert found[-1] == 3.0
    slow = replace(model, dynamics=Dynamics(model.dynamics.lags, step=(-0.25, 0.25)))
    steps = np.diff(free_run([slow], {"y": y})["y"])
    assert steps.max() == pytest.approx(0.25)
    free = linear("y", [Lag("y", 1)], [2.0], low=-UNBOUNDED, high=UNBOUNDED)
    assert free_run([free], {"y": np.append(1.0, np.zeros(2000))})["y"].max() == 100.0  # twice its domain


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"models": [linear("y", [Lag("y", 0)], [1.0])]}, r"read y\[t\], which is being predicted"),
        ({"models": [replace(linear("y", [Lag("y", 1)], [1.0]), dynamics=None)]}, "static"),
        ({"signals": {"v": U, "y": U}}, r"signals lack \['u'\]"),
        ({"signals": {"u": U[:5], "y": U}}, "shapes"),
        ({"signals": {"u": np.where(U > 0.9, np.nan, U), "y": U}}, "u = nan in row 2"),
        ({"segments": [0] * 29 + [1]}, "a segment has 1 rows; a run needs more than 1"),
        ({"horizon": 0}, "horizon = 0"),
        ({"horizon": 5, "signals": {"u": U, "y": np.where(U > 0.9, np.inf, U)}}, "y = inf in row 2"),
    ],
)
def test_bad_input_is_one_clear_error(change, message):
    given = {"models": [linear("y", [Lag("u", 0), Lag("y", 1)], [1.0, 0.5])], "signals": {"u": U, "y": U}} | change
    with pytest.raises(InputError, match=message):
        free_run(**given)
