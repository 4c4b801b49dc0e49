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
    assert lines[0] == f"y [bar]: proved range {bounds.low / 1e5:.6g} to {bounds.high / 1e5:.6g}"
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
    si = check_models(models, limits=(-0.5, 3.0), units="si")
    assert str(si) == str(check_range(models[0], -0.5, 3.0))
    assert str(outside).startswith("y leaves [-5e-06, 3e-05] bar: ")
    assert check_models(models, limits=(-0.5, 3.0), box={"a": (-1.0, -0.1)}).holds


def test_whether_models_hold_on_data(models):
    same, other = (check_models(models, data=table(1, scale)) for scale in (1.0, 0.7))
    assert (same.holds, other.holds) == (True, False)
    assert str(same).splitlines()[0] == "y [bar]: holds"
    assert str(other).splitlines()[0] == "y [bar]: does not hold any more"
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


def test_proofs_are_of_the_models_and_told_in_other_units():
    rng = np.random.default_rng(0)
    x, p = rng.uniform(0.0, 0.01, 400), rng.uniform(0.0, 2e7, 400)
    rows = Table({"x": x, "p": p, "q": 0.2 * x * (1.0 + 1e-8 * p)}, {"x": "m", "p": "Pa", "q": "m3/s"})
    models = fit_table(rows, ["x", "p"], ["q"], edges={"x": [0.005]}, estimator=AbductiveRegressor(max_layers=1)).models
    told = []
    bounds = check_models(models, max_boxes=50, progress=lambda *piece: told.append(piece))
    assert told == [("proof of q", 0, 1)]
    proved = bounds.found[0]
    assert (proved.low, proved.high) == (
        model_bounds(models[0], max_boxes=50).low,
        model_bounds(models[0], max_boxes=50).high,
    )
    first, *lines = str(bounds).splitlines()
    assert first == f"q [l/min]: proved range {6e4 * proved.low:.6g} to {6e4 * proved.high:.6g}"
    assert lines[0].startswith("  x [mm] in (-inf, 5]: ")
    by_x = next(line for line in lines if "by x [mm]" in line).split()
    assert float(by_x[-1]) == pytest.approx(60.0 * proved.regions[0].slopes[0, 1], rel=1e-4)  # l/min per mm
    wide = check_models(models, limits=(-1.0, 1.0), max_boxes=50)
    assert str(wide).startswith("q cannot leave [-60000, 60000] l/min: it is proved to stay in [")
    assert str(wide).endswith("l/min for all inputs of the box, and may use less of it")
    narrow = check_models(models, limits=(0.0, 1e-4), max_boxes=50)
    assert str(narrow).startswith("q leaves [0, 6] l/min: ")
    assert f"p = {narrow.found[0].leaving[0].point[1] / 1e5:.6g} bar" in str(narrow)
    assert "(x [mm] in (" in str(narrow)


def test_judgements_are_told_in_other_units_and_numbers_stay(models):
    metric, si = (check_models(models, data=table(1), units=units) for units in ("metric", "si"))
    assert metric.found[0].rms == si.found[0].rms
    assert metric.found[0].statements[0].startswith(f"rms error {metric.found[0].rms / 1e5:.4g} bar, ")
    assert si.found[0].statements[0].startswith(f"rms error {si.found[0].rms:.4g} Pa, ")
