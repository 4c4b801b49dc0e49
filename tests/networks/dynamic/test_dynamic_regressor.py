import numpy as np
import pytest
from sklearn.base import clone

from polydraulic import AbductiveRegressor, RegionRegressor
from polydraulic.errors import InputError
from polydraulic.networks import (
    DynamicRegressor,
    PerceptronRegressor,
    Variable,
    dump_models,
    free_run,
    model_bounds,
    parse_models,
)


def hammerstein(n=600, seed=0):
    """Second order, with a squared input after a dead time of two rows."""
    rng = np.random.default_rng(seed)
    u, y = np.repeat(rng.uniform(-1.0, 1.0, size=n // 5), 5), np.zeros(n)
    for t in range(2, n):
        y[t] = 1.5 * y[t - 1] - 0.6 * y[t - 2] + 0.2 * u[t - 2] ** 2 + 0.1 * u[t - 2]
    return u[:, None], y


FIXED = {"input_lags": [2], "output_lags": [1, 2], "increments": False, "horizon": None}
ONE = AbductiveRegressor(max_layers=2)


@pytest.mark.parametrize("increments", [False, True])
def test_a_free_run_follows_a_system_of_the_right_lags(increments):
    u, y = hammerstein()
    model = DynamicRegressor(ONE, **FIXED | {"increments": increments}).fit(u[:300], y[:300])
    assert model.warm_up_ == 2
    measured = np.where(np.arange(300) < 2, y[300:], np.nan)
    run = model.simulate(u[300:], measured)
    assert np.abs(run - y[300:]).max() < 1e-4
    assert np.abs(model.predict(u[300:], y[300:]) - y[300:]).max() < 1e-5


@pytest.mark.slow
def test_lags_horizon_and_terms_are_chosen_by_runs_on_rows_held_out():
    u, y = hammerstein()
    y = y + np.random.default_rng(1).normal(scale=0.003, size=len(y))
    model = DynamicRegressor(longest_lag=3, n_blocks=3).fit(u[:400], y[:400])
    chosen = model.choice_
    read = {(lag.signal, lag.steps) for lag in model.to_model().dynamics.lags}
    assert read >= {("x0", 2), ("y", 1), ("y", 2)}
    assert chosen in model.tried_
    assert chosen.error <= 1.031 * min(one.error for one in model.tried_)
    assert len({one.horizon for one in model.tried_}) > 1
    run = model.simulate(u[400:], y[400:])
    assert np.sqrt(np.mean((run - y[400:]) ** 2)) < 0.03 * y.std()


QUICK = {"input_lags": [1, 2], "output_lags": [1, 2], "horizon": 8, "max_terms": 6, "n_blocks": 2}


def test_polynomials_run_well_though_measured_with_noise():
    u, y = hammerstein(300)
    noisy = y + np.random.default_rng(1).normal(scale=0.03 * y.std(), size=len(y))
    told = []
    model = DynamicRegressor(**QUICK, progress=lambda *call: told.append(call)).fit(u[:200], noisy[:200])
    run = model.simulate(u[200:], noisy[200:])
    assert np.sqrt(np.mean((run[5:] - y[205:]) ** 2)) < 0.05 * y.std()
    assert 5 <= model.choice_.terms <= 6
    assert [one.terms for one in model.tried_] == [2, 3, 4, 5, 6]
    best = min(model.tried_, key=lambda one: one.error)
    ((what, done, most),) = told
    assert what == f"lags to 2, error {best.error:.2f}"
    assert 1 == done < most


def test_each_choice_is_logged(caplog):
    u, y = hammerstein(200)
    with caplog.at_level("INFO", logger="polydraulic"):
        DynamicRegressor(**QUICK | {"max_terms": 2}).fit(u, y)
    assert caplog.text.count("Choice(input_lags=(1, 2)") == 1


def test_runs_of_polynomials_do_not_grow_without_bound():
    u, y = hammerstein(200)
    model = DynamicRegressor(**QUICK).fit(u[:, :], y)
    wild = 100.0 * np.random.default_rng(0).normal(size=(1000, 1))
    run = model.simulate(wild, np.full(1000, y[0]))
    margin = 0.1001 * np.ptp(y)
    assert y.min() - margin < run.min() < run.max() < y.max() + margin


def test_a_linear_system_gets_a_linear_model():
    rng = np.random.default_rng(4)
    u, y = rng.uniform(-1, 1, size=(400, 1)), np.zeros(400)
    for t in range(1, 400):
        y[t] = 0.9 * y[t - 1] + u[t - 1, 0] + rng.normal(scale=0.2)
    model = DynamicRegressor(input_lags=[1], output_lags=[1], horizon=None, max_terms=4).fit(u, y).to_model()
    middle = np.array([[0.0, y.mean()], [0.1, y.mean()], [0.0, y.mean() + 0.1]])
    base, by_input, by_output = model.predict(middle)
    assert np.allclose([(by_input - base) / 0.1, (by_output - base) / 0.1], [1.0, 0.9], atol=0.06)


def test_nothing_is_learnt_across_gaps():
    u, y = hammerstein(400)
    whole = DynamicRegressor(ONE, **FIXED).fit(u, y)
    order = np.r_[200:400, 0:200]
    labels = np.repeat([0, 1], 200)
    cut = DynamicRegressor(ONE, **FIXED).fit(u[order], y[order], segments=labels)
    assert np.abs(cut.simulate(u, y) - whole.simulate(u, y)).max() < 1e-4
    spoilt = y.copy()
    spoilt[200] = np.nan
    assert np.abs(DynamicRegressor(ONE, **FIXED).fit(u, spoilt).simulate(u, y) - y).max() < 1e-4
    steps = [
        DynamicRegressor(ONE, **FIXED).fit(u[order], y[order] + 9.0 * labels, segments=given).to_model().dynamics.step
        for given in (labels, None)
    ]
    assert steps[0] == pytest.approx(cut.to_model().dynamics.step)
    assert steps[1][1] > 5.0


def test_two_outputs_read_each_other():
    u, first = hammerstein(500)
    second = np.zeros(500)
    for t in range(1, 500):
        second[t] = 0.7 * second[t - 1] + 0.5 * first[t - 1]
    y = np.column_stack([first, second])
    settings = {"input_lags": [2], "output_lags": [1, 2], "increments": True, "horizon": None}
    model = DynamicRegressor(ONE, **settings).fit(u[:300], y[:300])
    assert np.abs(model.simulate(u[300:], y[300:]) - y[300:]).max() < 1e-3


def test_models_go_through_files_and_stay_in_their_bounds():
    u, y = hammerstein()
    model = DynamicRegressor(ONE, **FIXED, raster=0.02).fit(u, y)
    models = model.to_models([Variable("valve", "V")], [Variable("pressure", "Pa")])
    assert [str(variable) for variable in models[0].inputs] == ["valve[t-2] [V]", "pressure[t-1] [Pa]", "pressure[t-2] [Pa]"]  # fmt: skip
    (read,) = parse_models(dump_models(models), "m.json")
    assert read == models[0]
    assert read.dynamics.raster == 0.02
    found = free_run([read], {"valve": u[:, 0], "pressure": y})
    assert np.array_equal(found["pressure"], model.simulate(u, y))
    proved = model_bounds(read)
    margin = 0.11 * np.ptp(y)
    assert y.min() - margin < proved.low < proved.high < y.max() + margin


@pytest.mark.parametrize(
    "estimator",
    [RegionRegressor(ONE, edges={0: [0.0]}), PerceptronRegressor(hidden_units=3, n_starts=1, max_iter=20)],
)
def test_any_learner_that_gives_a_model_will_do(estimator):
    u, y = hammerstein(300)
    model = DynamicRegressor(estimator, **FIXED | {"increments": True}).fit(u, y)
    assert model.choice_.terms is None
    assert np.isfinite(model.simulate(u, y)).all()


def test_without_output_lags_there_is_no_memory():
    u = np.random.default_rng(0).uniform(size=(200, 1))
    y = np.append(0.0, u[:-1, 0] ** 2)
    model = DynamicRegressor(ONE, input_lags=[0, 1], output_lags=[], horizon=None).fit(u, y)
    assert not model.choice_.increments
    assert np.abs(model.simulate(u, y) - y).max() < 1e-6


U, Y = (values[:99] for values in hammerstein(100))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"input_lags": "best"}, "input_lags = 'best'"),
        ({"output_lags": [0, 1]}, r"output_lags = \[0, 1\]"),
        ({"input_lags": [1, 1]}, "different"),
        ({"input_lags": [1.5]}, "whole numbers"),
        ({"input_lags": [], "output_lags": []}, "nothing to learn from"),
        ({"output_lags": [2], "increments": True}, "must contain 1"),
        ({"horizon": 0}, "horizon = 0"),
        ({"longest_lag": 0}, "longest_lag = 0"),
        ({"n_blocks": 1}, "n_blocks = 1"),
        ({"max_terms": 0, "n_blocks": 2}, "max_terms = 0"),
        ({"n_blocks": 5}, "too few to choose from"),
        ({"raster": 0.0}, "raster = 0.0"),
        ({"input_lags": [99], "output_lags": [1], "increments": False, "horizon": None}, "100 rows follow each other"),
    ],
)
def test_settings_out_of_range_are_one_clear_error(settings, message):
    base = ONE if "n_blocks" not in settings else None
    with pytest.raises(InputError, match=message):
        DynamicRegressor(base, **settings).fit(U, Y)


def test_arrays_that_do_not_fit_are_one_clear_error():
    model = DynamicRegressor(ONE, **FIXED).fit(U, Y)
    with pytest.raises(InputError, match=r"y has shape \(50,\)"):
        model.fit(U, Y[:50])
    with pytest.raises(InputError, match="the model has 1 outputs"):
        model.simulate(U, np.column_stack([Y, Y]))
    with pytest.raises(InputError, match="2 output names"):
        model.to_models(outputs=[Variable("a"), Variable("b")])
    assert str(clone(model)) == str(model)


@pytest.mark.parametrize(("scale", "offset"), [(1e-150, 0.0), (1e140, 0.0), (1.0, 1e9)])
def test_signals_of_any_size_are_learnt(scale, offset):
    u, y = hammerstein(300)
    learner = DynamicRegressor(input_lags=[2], output_lags=[1, 2]).fit(u * scale + offset, y * scale + offset)
    run = learner.simulate(u * scale + offset, y * scale + offset)
    assert np.std(run / scale - (y + offset / scale)) < 0.01 * y.std()


@pytest.mark.parametrize("scale", [1e-200, 1e-310, 1e200])
def test_signals_whose_squares_are_no_numbers_are_named(scale):
    u, y = hammerstein(100)
    with pytest.raises(InputError, match="x0 lies in .* scale it"):
        DynamicRegressor().fit(u * scale, y)
    with pytest.raises(InputError, match="y lies in .* scale it"):
        DynamicRegressor().fit(u, y * scale)
