"""Proofs and judgements of models in one call."""

import numpy as np
import pytest

from helpers.logs_with_memory import memory_log
from polydraulic import AbductiveRegressor, save_models
from polydraulic.errors import InputError
from polydraulic.identification import check_models, fit_table
from polydraulic.networks import Dynamics, Lag, Model, Network, Variable, check_range, model_bounds
from polydraulic.tables import Table


def table(seed=0, scale=1.0):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(-1.0, 1.0, size=(2, 300))
    return Table(
        {"a": a, "b": b, "y": scale * (np.where(a > 0.0, a * b, 0.1 * b) + 0.01 * rng.normal(size=300))}, {"y": "Pa"}
    )


@pytest.fixture(scope="module")
def models():
    return fit_table(table(), ["a", "b"], ["y"], edges={"a": [0.0]}, estimator=AbductiveRegressor(max_layers=1)).models


def test_bounds_are_those_that_are_proved_of_outputs_and_slopes(models, tmp_path):
    save_models(models, tmp_path / "m.json")
    found = check_models(tmp_path / "m.json")
    bounds = model_bounds(models[0])
    assert found.holds
    assert (found.found[0].low, found.found[0].high) == (bounds.low, bounds.high)
    lines = str(found).splitlines()
    assert lines[0] == f"y [Pa]: proved range {bounds.low:.6g} to {bounds.high:.6g}"
    assert sum(line.startswith("    by a") for line in lines) == 2


def test_a_box_is_the_domain_but_for_the_inputs_it_names(models):
    domain = models[0].domain()
    found = check_models(models, box={"a": (-0.5, -0.2)}).found[0]
    bounds = model_bounds(models[0], np.array([[-0.5, -0.2], domain[1]]))
    assert (found.low, found.high, found.regions[1]) == (bounds.low, bounds.high, None)
    assert "a in (0, inf)" not in str(check_models(models, box={"a": (-0.5, -0.2)}))
    with pytest.raises(InputError, match=r"box names the input 'c'; the model of 'y' reads \['a', 'b'\]"):
        check_models(models, box={"c": (0.0, 1.0)})


def test_whether_a_range_is_left(models):
    inside, outside = (check_models(models, limits=limits) for limits in ((-3.0, 3.0), (-0.5, 3.0)))
    assert (inside.holds, outside.holds) == (True, False)
    assert str(outside) == str(check_range(models[0], -0.5, 3.0))
    assert check_models(models, limits=(-0.5, 3.0), box={"a": (-1.0, -0.1)}).holds


def test_whether_models_hold_on_data(models):
    same, other = (check_models(models, data=table(1, scale)) for scale in (1.0, 0.7))
    assert (same.holds, other.holds) == (True, False)
    assert str(same).splitlines()[0] == "y [Pa]: holds"
    assert str(other).splitlines()[0] == "y [Pa]: does not hold any more"
    assert "    a in (0, inf): " in str(same)
    with pytest.raises(InputError, match="limits and a box go with a proof"):
        check_models(models, data=table(1), limits=(0.0, 1.0))


def test_static_and_dynamic_models_are_judged_each_in_their_way():
    one = Network((), (0.0,), (1.0,), (-9.0,), (9.0,), 0.5, 1.0)
    dynamic = Model((Variable("y[t-1]"),), Variable("y"), (one,), dynamics=Dynamics((Lag("y", 1),)))
    static = Model((Variable("u"),), Variable("z"), (one,))
    found = check_models([dynamic, static], data=memory_log(n=100))
    assert [model.output.name for model in found.models] == ["z", "y"]
    assert found.found[1].statements[0].startswith("2 free run(s) of up to 49 rows: rms error")
    assert found.found[0].statements[0].startswith("rms error")
    proof = check_models([dynamic, static])
    assert proof.notes[0].startswith("dynamic, a function of lagged values: y 1 rows ago. Whoever calls it")
    assert str(proof).startswith("note: dynamic")
