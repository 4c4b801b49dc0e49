import numpy as np
import pytest

from helpers.logs_with_memory import memory_log
from polydraulic import AbductiveRegressor
from polydraulic.errors import InputError
from polydraulic.identification import ModelRuns, plot_runs, run_models
from polydraulic.identification.run_plot import plot_separately
from polydraulic.identification.runs import last_value_held, run_on, side_by_side
from polydraulic.networks import DynamicRegressor, Variable
from polydraulic.tables import Table

LOG = memory_log(n=300)
SPANS = [(0, 150), (150, 152), (160, 300)]


@pytest.fixture(scope="module")
def fitted():
    fixed = {"input_lags": [1], "output_lags": [1, 2], "increments": False, "horizon": None}
    model = DynamicRegressor(AbductiveRegressor(max_layers=1), **fixed, raster=0.02)
    model.fit(LOG.matrix(["u"]), LOG.matrix(["y", "z"]))
    models = model.to_models([Variable("u", "V")], [Variable("y", "Pa"), Variable("z", "m")])
    return model, models


def test_runs_begin_from_measured_rows_and_short_spans_are_left_out(fitted):
    model, models = fitted
    y, z = run_on(models, LOG, SPANS)
    assert (y.n_run, y.longest) == (2, 148)
    assert y.row.tolist() == [*range(2, 150), *range(162, 300)]
    whole = model.simulate(LOG.matrix(["u"])[160:], LOG.matrix(["y", "z"])[160:])
    assert np.array_equal(np.column_stack([y.free, z.free])[148:], whole[2:])
    ahead = model.predict(LOG.matrix(["u"])[160:], LOG.matrix(["y", "z"])[160:])
    assert np.array_equal(y.one_step[148:], ahead[2:, 0])
    assert np.array_equal(z.measured, LOG["z"][z.row])
    assert np.array_equal(y.time, LOG["time"][y.row])


def test_runs_begin_anew_after_a_horizon(fitted):
    y, _ = run_on(fitted[1], LOG, SPANS, 40)
    assert np.bincount(y.number).tolist() == [40, 40, 40, 28, 40, 40, 40, 18]
    starts = np.unique(y.number, return_index=True)[1]
    assert np.array_equal(y.free[starts], y.one_step[starts])


def test_the_last_value_is_held_from_where_a_run_begins(fitted):
    y, _ = run_on(fitted[1], LOG, SPANS)
    held, before = last_value_held(y, LOG["y"])
    assert set(held[:148]) == {LOG["y"][1]}
    assert set(held[148:]) == {LOG["y"][161]}
    assert np.array_equal(before, LOG["y"][y.row - 1])


def test_no_run_fits(fitted):
    with pytest.raises(InputError, match="at most 2 rows of the table follow each other; a run needs more than 2"):
        run_on(fitted[1], LOG, [(0, 2), (5, 7)])
    with pytest.raises(InputError, match="no column 'u'"):
        run_on(fitted[1], type(LOG)({"y": LOG["y"], "z": LOG["z"]}, {}), SPANS)


def test_models_of_other_lags_answer_the_same_rows(fitted):
    fixed = {"input_lags": [1, 5], "output_lags": [1], "increments": False, "horizon": None}
    other = DynamicRegressor(AbductiveRegressor(max_layers=1), **fixed)
    other.fit(LOG.matrix(["u"]), LOG.matrix(["y", "z"]))
    longer = other.to_models([Variable("u", "V")], [Variable("y", "Pa"), Variable("z", "m")])
    spans = [(0, 150), (150, 155), (160, 300)]
    (short, _), (long, _) = side_by_side([fitted[1], longer], LOG, spans)
    assert short.row.tolist() == long.row.tolist() == [*range(5, 150), *range(165, 300)]
    assert np.array_equal(long.free, run_on(longer, LOG, spans)[0].free)
    assert np.array_equal(short.free, run_on(fitted[1], LOG, [(3, 150), (163, 300)])[0].free)


def test_models_run_on_a_log_whose_gaps_they_see(fitted):
    models = fitted[1]
    found = run_models(models, LOG)
    assert (found.runs[0].n_run, found.runs[0].longest) == (2, 148)  # a pause after half of the rows
    table = found.to_table()
    assert table.names == ["time", "run", "y", "y.run", "y.one_step", "z", "z.run", "z.one_step"]
    assert (table.unit("y.run"), table.unit("z.one_step"), table.unit("time")) == ("Pa", "m", "s")
    assert np.array_equal(table["y.run"], found.runs[0].free)
    head, free, *_ = str(found).splitlines()
    assert head == "2 free run(s) of up to 148 rows, 296 of 300 rows answered"
    rms = np.sqrt(np.mean((found.runs[0].free - found.runs[0].measured) ** 2))
    assert free.startswith("y, free run: R2 0.99")
    assert f"rms {rms / 1e5:.4g} bar" in free
    assert f"rms {rms:.4g} Pa" in found.text("si")
    assert run_models(models, LOG, every=0.6).runs[0].longest == 30


@pytest.mark.parametrize(
    ("every", "message"),
    [
        (0.01, "every = 0.01 s: must be finite and no less than the raster of 0.02 s"),
        (float("inf"), "every = inf s: must be finite"),
        (float("nan"), "every = nan s: must be finite"),
    ],
)
def test_times_that_are_none_are_named(fitted, every, message):
    with pytest.raises(InputError, match=message):
        run_models(fitted[1], LOG, every=every)


def test_without_a_raster_there_is_no_time(fitted):
    model, _ = fitted
    untimed = Table({name: LOG[name] for name in "uyz"}, {})
    bare = DynamicRegressor(**{**model.get_params(deep=False), "raster": None})
    bare.fit(LOG.matrix(["u"]), LOG.matrix(["y", "z"]))
    models = bare.to_models([Variable("u")], [Variable("y"), Variable("z")])
    with pytest.raises(InputError, match="neither model nor log says how far apart rows are"):
        run_models(models, untimed, every=1.0)
    assert run_models(models, untimed).to_table().unit("time") == "rows"


def test_pictures_show_measured_next_to_simulated(fitted):
    models = fitted[1]
    runs = run_on(models, LOG, SPANS)
    figure = plot_runs(ModelRuns(models, runs, LOG))
    assert [axis.get_ylabel() for axis in figure.axes] == ["y [bar]", "z [mm]"]
    measured, free = figure.axes[0].lines
    assert np.isnan(measured.get_xdata()).sum() == 1  # no line from one run to the next
    assert free.get_ydata()[:148] == pytest.approx(runs[0].free[:148] / 1e5)
    si = plot_runs(ModelRuns(models, runs, Table(LOG.columns, LOG.units, {"began": 1.7e9})), units="si")
    assert [axis.get_ylabel() for axis in si.axes] == ["y [Pa]", "z [m]"]
    assert si.axes[-1].get_xlabel() == "time of day, 2023-11-14"
    assert not figure.axes[0].collections  # no interval where none is stated
    models[0].training.update({"interval_half_widths": [0.1], "free_run_rows": 148})
    figure = plot_separately(models[0], runs[0])
    assert len(figure.axes) == 2
    assert len(figure.axes[0].collections) == 1
    models[0].training["free_run_rows"] = 40  # stated for shorter runs only
    assert not plot_separately(models[0], runs[0]).axes[0].collections
    models[0].training.clear()


@pytest.mark.parametrize(("every", "longest"), [(0.02, 1), (0.029, 1), (0.031, 2), (0.04, 2), (100.0, 148)])
def test_times_become_rows(fitted, every, longest):
    assert run_models(fitted[1], LOG, every=every).runs[0].longest == longest
