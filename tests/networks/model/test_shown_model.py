"""Models in units that people read: the same answers, in other units."""

from dataclasses import replace

import numpy as np
import pytest

from polydraulic.identification.table_fit import fit_table
from polydraulic.networks import Dynamics, JointStrength, Lag
from polydraulic.networks.growth.regressor import AbductiveRegressor
from polydraulic.networks.model.shown_model import region_names, shown_model
from polydraulic.tables import Table
from polydraulic.unit_table import CUBIC_INCH, INCH, PSI


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


def test_the_noise_of_a_strength_is_in_the_unit_of_the_output(fit):
    known = JointStrength(32, 0.03, 0.05, 1e3, 1e-4)
    dynamics = Dynamics(tuple(Lag(v.name, 1) for v in fit.model.inputs), (-1e-3, 2e-3), 0.05, known)
    read = shown_model(replace(fit.model, dynamics=dynamics)).dynamics
    assert read.step == pytest.approx((-60.0, 120.0))
    assert read.strength == replace(known, noise=pytest.approx(6.0))


def test_borders_of_regions_have_units(fit):
    assert region_names(shown_model(fit.model)) == ["x [mm] in (-inf, 5]", "x [mm] in (5, inf)"]


def test_si_and_units_of_ones_own_change_nothing(fit):
    assert shown_model(fit.model, "si") is fit.model
    assert (
        fit.model.training["held_out_by_region"][0]["region"] == "x in (-inf, 0.005]"
    )  # and nothing was changed in place
