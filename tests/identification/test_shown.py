"""Models in units that people read: the same answers, in other units."""

import numpy as np
import pytest

from polydraulic.identification.shown import region_names, said_of_bounds, said_of_range, shown_model
from polydraulic.identification.table_fit import fit_table
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.proof.bounds import check_range, model_bounds
from polydraulic.tables import Table
from polydraulic.units import CUBIC_INCH, INCH, PSI


@pytest.fixture(scope="module")
def fit():
    rng = np.random.default_rng(0)
    x, p, t = rng.uniform(0.0, 0.01, 400), rng.uniform(0.0, 2e7, 400), rng.uniform(20.0, 60.0, 400)
    q = 0.2 * x * (1.0 + 1e-8 * p) + 1e-7 * t * (x > 0.005) + rng.normal(0.0, 1e-6, 400)
    table = Table({"x": x, "p": p, "t": t, "q": q}, {"x": "m", "p": "Pa", "t": "degC", "q": "m3/s"})
    estimator = AbductiveRegressor(max_layers=2)
    return fit_table(table, ["x", "p", "t"], ["q"], estimator=estimator, edges={"x": [0.005]}).outputs[0]


@pytest.mark.parametrize(("units", "scales"), [("metric", (1e-3, 1e5, 1e-3 / 60)), ("field", (INCH, PSI, CUBIC_INCH))])
def test_a_model_answers_the_same_in_other_units(fit, units, scales):
    read = shown_model(fit.model, units)
    X = fit.held.X
    there = read.predict(X / [scales[0], scales[1], 1.0])
    assert there == pytest.approx(fit.model.predict(X) / scales[2], rel=1e-12)
    assert [v.unit for v in read.inputs] == (["mm", "bar", "degC"] if units == "metric" else ["in", "psi", "degC"])
    assert read.domain()[1] == pytest.approx(fit.model.domain()[1] / scales[1])
    stated = read.training
    assert stated["held_out_rms"] == pytest.approx(fit.rms / scales[2])
    assert stated["interval_half_widths"] == pytest.approx(np.array(fit.half_widths) / scales[2])
    assert stated["held_out_r2"] == fit.r2
    assert [r["region"] for r in stated["held_out_by_region"]] == region_names(read)
    assert [r["rms"] for r in stated["held_out_by_region"]] == pytest.approx(
        [r["rms"] / scales[2] for r in fit.model.training["held_out_by_region"]]
    )


def test_borders_of_regions_have_units(fit):
    assert region_names(shown_model(fit.model)) == ["x [mm] in (-inf, 5]", "x [mm] in (5, inf)"]


def test_si_and_units_of_ones_own_change_nothing(fit):
    assert shown_model(fit.model, "si") is fit.model
    assert (
        fit.model.training["held_out_by_region"][0]["region"] == "x in (-inf, 0.005]"
    )  # and nothing was changed in place


def test_errors_and_rows_of_a_fit(fit):
    read = fit.shown()
    assert str(fit).startswith("q [l/min]: 2 network(s)")
    assert f"rms {6e4 * fit.rms:.4g} l/min" in fit.text()
    assert "m3/s" in fit.text("si")
    assert read.rms == pytest.approx(6e4 * fit.rms)
    assert read.held.y == pytest.approx(6e4 * fit.held.y)
    assert read.held.X[:, 1] == pytest.approx(1e-5 * fit.held.X[:, 1])
    assert (read.r2, read.covered) == (fit.r2, fit.covered)


def test_proofs_are_of_the_model_and_told_in_other_units(fit):
    bounds = model_bounds(fit.model, max_boxes=50)
    first, *lines = said_of_bounds(fit.model, bounds)
    assert first == f"q [l/min]: proved range {6e4 * bounds.low:.6g} to {6e4 * bounds.high:.6g}"
    by_x = next(line for line in lines if "by x [mm]" in line).split()
    assert float(by_x[-1]) == pytest.approx(60.0 * bounds.regions[0].slopes[0, 1], rel=1e-4)  # l/min per mm
    wide = check_range(fit.model, -1.0, 1.0, max_boxes=50)
    assert said_of_range(fit.model, wide).startswith(
        "q cannot leave [-60000, 60000] l/min anywhere in the box: proved range"
    )
    narrow = check_range(fit.model, 0.0, 1e-4, max_boxes=50)
    told = said_of_range(fit.model, narrow)
    assert told.startswith("q leaves [0, 6] l/min: ")
    assert f"p = {narrow.leaving[0].point[1] / 1e5:.6g} bar" in told
    assert "(x [mm] in (" in told
